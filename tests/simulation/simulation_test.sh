#!/usr/bin/env bash
# A seed gives the same run again, and a store without one of its protections is found out.
#   simulation_test.sh PROGRAM
set -euo pipefail
program=$1

first=$("$program" --seeds 5)
again=$("$program" --seeds 5)
[ "$first" = "$again" ] || { echo "the same seeds gave '$first', then '$again'" >&2; exit 1; }

for protection in fence compare-and-set revision database revocation; do
  if found=$("$program" --seeds 1000 --without "$protection"); then
    echo "the missing $protection was not found: $found" >&2
    exit 1
  fi
  seed=$(sed -n 's/^seed \([0-9]*\) at .*/\1/p' <<< "$found")
  again=$("$program" --first "${seed:?"$found"}" --seeds 1 --without "$protection" || true)
  [ "$found" = "$again" ] || { echo "seed $seed gave '$found', then '$again'" >&2; exit 1; }
  echo "without $protection: $found"
done
