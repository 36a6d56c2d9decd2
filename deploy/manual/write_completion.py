#!/usr/bin/python3
"""Writes the bash completion of a program from its --help.

    write_completion.py NAME PROGRAM > completion
"""

import os
import sys

import program_help

SCRIPT = """\
# bash completion of {name}: commands, options, and values of options with a fixed set; otherwise
# files.
_{name}() {{
  COMPREPLY=()
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}}
  local command= word options= commands=
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$command/$word" in
      {known}) command=${{command:+$command }}$word ;;
    esac
  done
  case "$command" in
{cases}
  esac
  case "$command/$previous" in
{values}
  esac
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
  elif [[ -n $commands ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$current")
  fi
}}
complete -o bashdefault -o default -F _{name} {name}
"""


def names_of(entries):
    return [name for entry in entries for name in entry.names]


def value_case(command, entry):
    """Completes the value of an option: its allowed words, or nothing, so that bash offers files."""
    pattern = " | ".join(f'"{command}/{name}"' for name in entry.names)
    if not entry.choices:
        return f"    {pattern}) return ;;"
    choices = " ".join(entry.choices)
    return (f"    {pattern}) mapfile -t COMPREPLY "
            f'< <(compgen -W "{choices}" -- "$current"); return ;;')


def main():
    name, path = sys.argv[1:]
    program = program_help.read(os.path.abspath(path))
    known, cases, values = [], [], []
    for command in program.walk():
        words = " ".join(command.words)
        known += [f'"{words}/{inner.words[-1]}"' for inner in command.commands]
        # Options of the program are also allowed after a command.
        entries = command.options if command is program else command.options + program.options
        options = list(dict.fromkeys(names_of(entries)))
        case = f'options="{" ".join(options)}"'
        if command.commands:
            case += f'; commands="{" ".join(inner.words[-1] for inner in command.commands)}"'
        cases.append(f'    "{words}") {case} ;;')
        values += [value_case(words, entry) for entry in entries if entry.takes_value]
    print(SCRIPT.format(name=name, known=" | ".join(known) or '"//"', cases="\n".join(cases),
                        values="\n".join(values) or '    "//") ;;'), end="")


main()
