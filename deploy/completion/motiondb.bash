# bash completion of motiondb. The program knows its commands, options and values, and asks the
# server for databases, clips and labels. Without candidates, bash completes files.
_motiondb() {
  local word
  COMPREPLY=()
  while IFS=$'\t' read -r word _; do
    # Quotes spaces. A clip with a time continues: no space after CLIP@.
    COMPREPLY+=("$(printf %q "$word")")
    [[ $word != *@ ]] || compopt -o nospace 2>/dev/null
  done < <("${COMP_WORDS[0]}" __complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}
complete -o bashdefault -o default -F _motiondb motiondb
