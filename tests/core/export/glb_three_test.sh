#!/usr/bin/env bash
# GLB files open in three.js, at the right positions, and are valid: glb_three_test.sh BUILD_FOLDER
# EXPORT_TESTS. Ends with 77 if npm is missing or cannot install three.js.
set -euo pipefail
cd "$(dirname "$0")"
folder=$1/three
export_tests=$2

command -v npm >/dev/null || { echo "skipped: npm is missing; install nodejs and npm"; exit 77; }
mkdir -p "$folder/samples"
cp package.json package-lock.json "$folder"
(cd "$folder" && npm ci --silent --no-audit --no-fund) ||
  { echo "skipped: npm cannot install three and gltf-validator"; exit 77; }

rm -f "$folder"/samples/*
MOTIONDB_GLB_SAMPLES=$folder/samples "$export_tests" "[.samples]"
export NODE_MODULES=$folder/node_modules
for glb in "$folder"/samples/*.glb; do
  node check_glb.mjs "$glb" "${glb%.glb}.json"
done

# The check can fail.
! node check_glb.mjs "$folder/samples/stick.glb" "$folder/samples/odd.json" >"$folder/wrong" 2>&1 ||
  { echo "wrong positions are accepted"; exit 1; }
