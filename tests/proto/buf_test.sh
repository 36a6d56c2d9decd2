#!/usr/bin/env bash
# The wire contract keeps buf's STANDARD rules and, without a new version, breaks no client of the
# last release: buf_test.sh BUILD_FOLDER. Ends with 77 if npm is missing or cannot install buf.
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=$1/buf

command -v npm >/dev/null || { echo "skipped: npm is missing; install nodejs and npm"; exit 77; }
mkdir -p "$folder"
cp tests/proto/package.json tests/proto/package-lock.json "$folder"
(cd "$folder" && npm ci --silent --no-audit --no-fund) ||
  { echo "skipped: npm cannot install buf"; exit 77; }
buf=$folder/node_modules/.bin/buf

"$buf" lint proto
"$buf" breaking proto --against tests/proto/released.binpb.gz

# The checks can fail.
rm -rf "$folder/copy"
cp -r proto "$folder/copy"
sed -i 's/METHOD_BEST/BEST/; s/int32 layer_count = 4/int32 layers = 40/' \
  "$folder/copy"/motiondb/v1/{query,database}.proto
! "$buf" lint "$folder/copy" >"$folder/lint" || { echo "lint accepts a bare enum value"; exit 1; }
grep -q METHOD_ "$folder/lint"
! "$buf" breaking "$folder/copy" --against tests/proto/released.binpb.gz >"$folder/breaking" ||
  { echo "a removed field is accepted"; exit 1; }
grep -q layer_count "$folder/breaking"
