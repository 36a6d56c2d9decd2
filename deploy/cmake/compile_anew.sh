#!/bin/sh
# compile_anew.sh COMMAND...: deletes the output, the file after -o, and runs the command that
# compiles it. g++ writes different bytes each time it precompiles the same headers, and ccache takes
# an older precompiled header in place of the output for one more input. So a second one would not
# be that of the cache, and nothing that includes it would be found there.
before=
for each in "$@"; do
  if [ "$before" = -o ]; then rm -f "$each"; fi
  before=$each
done
exec "$@"
