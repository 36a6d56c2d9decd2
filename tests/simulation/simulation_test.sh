#!/usr/bin/env bash
# A seed gives the same run again, and a store without one of its protections is found out.
#   simulation_test.sh PROGRAM
set -euo pipefail
program=$1

first=$("$program" --seeds 5)
again=$("$program" --seeds 5)
[ "$first" = "$again" ] || { echo "the same seeds gave '$first', then '$again'" >&2; exit 1; }

# The search begins shortly before a seed that found it when this was written.
for search in fence:90 compare-and-set:600 revision:0 database:130 revocation:0; do
  protection=${search%:*}
  if found=$("$program" --first "${search#*:}" --seeds 1000 --without "$protection"); then
    echo "the missing $protection was not found: $found" >&2
    exit 1
  fi
  seed=$(sed -n 's/^seed \([0-9]*\) at .*/\1/p' <<< "$found")
  again=$("$program" --first "${seed:?"$found"}" --seeds 1 --without "$protection" || true)
  [ "$found" = "$again" ] || { echo "seed $seed gave '$found', then '$again'" >&2; exit 1; }
  echo "without $protection: $found"
done
