#!/usr/bin/env bash
# Checks that the manual pages and completions have all commands and options. Reads --help of the
# programs with its own parser, independent of program_help.py. Arguments: motiondbd, motiondb, the
# folder of pages and completions.
set -euo pipefail
motiondbd=$1 motiondb=$2 written=$3
command -v man >/dev/null || { echo "skipped: no man; deploy/install_packages.sh deploy-test"; exit 77; }

missing=0
count=0
check() {  # WHERE WORD: checks that standard input contains the word
  count=$((count + 1))
  # Not grep -q: it would close the pipe early.
  grep -Fe "$2" | grep -Ee "(^|[^-a-z])$2([^-a-z]|$)" >/dev/null || { echo "$1: no $2" >&2; missing=1; }
}

page() {
  MANWIDTH=200 man --warnings -P cat -l "$written/man/$1.gz" 2>"$work/warnings" | col -b
  [ ! -s "$work/warnings" ] || { cat "$work/warnings" >&2; missing=1; }
}

# complete_words PROGRAM WORD...: prints the completions after these words.
complete_words() {
  PATH=$(dirname "${!1}"):$PATH bash -c '. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); "_$1"; printf "%s\n" "${COMPREPLY[@]}"' \
    - "$written/completions/$1" "$@"
}

options_of() {  # HELP
  grep -oE '^  (-[a-z],)?--[a-z][-a-z]*' <<<"$1" | grep -oE -- '--[a-z][-a-z]*'
}

commands_of() {  # HELP
  sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p' <<<"$1"
}

check_values() {  # HELP PROGRAM COMMAND... OPTION: checks that the completions of the option are its values in the help
  local help=$1 program=$2 option=${!#} value word offered=0
  set -- "${@:3:$#-3}"
  value=$(sed -nE "s/^  (-[a-z],)?$option ([^ ]+).*/\2/p" <<<"$help")
  complete_words "$program" "$@" "$option" "" >"$work/offered"
  if [[ -z $value || $value == \(Env:* || $value == Needs:* ]]; then  # a flag changes nothing
    complete_words "$program" "$@" "" | diff - "$work/offered" >&2 || { echo "$program $* $option" >&2; missing=1; }
    return
  fi
  while read -r word; do
    [ -n "$word" ] || continue
    offered=$((offered + 1))
    [[ $word =~ ^[A-Za-z0-9_.-]+$ ]] || { echo "$program $* $option: offers '$word'" >&2; missing=1; }
  done <"$work/offered"
  # An option with a fixed set of values completes these; for others bash completes files.
  [[ ($value == *{*}* && $offered -gt 1) || ($value != *{*}* && $offered = 0) ]] ||
    { echo "$program $* $option $value: offers $(tr '\n' ' ' <"$work/offered")" >&2; missing=1; }
}

# Names of databases complete too, if a server runs.
export MOTIONDB_SERVER=127.0.0.1:1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
page motiondb.1 >"$work/motiondb"
page motiondbd.8 >"$work/motiondbd"
page motiondbd.conf.5 >"$work/conf"

help=$("$motiondbd" --help)
complete_words motiondbd - >"$work/options"
for option in $(options_of "$help"); do
  check "motiondbd(8)" "$option" <"$work/motiondbd"
  check "completion of motiondbd" "$option" <"$work/options"
  check_values "$help" motiondbd "$option"
  case "$option" in --help | --version | --config | --check-config) continue ;; esac
  check "motiondbd.conf(5)" "${option#--}" <"$work/conf"
done

walk() {  # COMMAND...: checks this command and all commands below it
  local help command commands option
  help=$("$motiondb" "$@" --help)
  complete_words motiondb "$@" - >"$work/options"
  for option in $(options_of "$help"); do
    check "motiondb(1), $*" "$option" <"$work/motiondb"
    check "completion of motiondb $*" "$option" <"$work/options"
    check_values "$help" motiondb "$@" "$option"
  done
  commands=$(commands_of "$help")
  [ -z "$commands" ] || complete_words motiondb "$@" "" >"$work/commands"
  for command in $commands; do
    check "motiondb(1)" "$* $command" < <(sed 's/^ */ /' "$work/motiondb")
    check "completion of motiondb $*" "$command" <"$work/commands"
  done
  for command in $commands; do
    if [ $# = 0 ]; then
      walk_apart "$command" &  # all commands together: each completion waits for a server
    else
      walk "$@" "$command"
    fi
  done
}

walk_apart() {  # COMMAND: walks in a folder of its own, and writes the count and the result there
  local all=$work
  work=$all/$1
  count=0
  mkdir "$work"
  cp "$all/motiondb" "$work"
  walk "$1"
  echo "$count $missing" >"$work/result"
}

walk
wait
for folder in "$work"/*/; do
  read -r of_command missed <"$folder/result"
  count=$((count + of_command)) missing=$((missing | missed))
done
[ "$count" -gt 150 ] || { echo "expected more than 150 words to check, found $count" >&2; missing=1; }
[ "$(complete_words motiondb plan --method ran)" = random ] ||
  { echo "expected the completion random of plan --method ran" >&2; missing=1; }
[ "$missing" = 0 ] && echo "manual_test: checked $count words"
exit "$missing"
