#!/usr/bin/env bash
# Builds the web page into a folder.
#   build_page.sh FOLDER AUTO|ON
# If npm cannot download the packages, AUTO leaves the folder without a page; ON fails.
set -euo pipefail
folder=$1
wanted=$2
cd "$(dirname "$0")"

# Builds of several folders share the packages.
exec 9>.build-lock
flock 9

installed=node_modules/.package-lock-of-build.json
if ! cmp -s package-lock.json "$installed"; then
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  if ! npm ci --prefer-offline --no-audit --no-fund --fetch-retries=1 --fetch-timeout=30000 \
    >"$log" 2>&1; then
    tail -n 5 "$log" >&2
    if [ "$wanted" = ON ]; then
      echo "web page: npm cannot install the packages of client/web" >&2
      exit 1
    fi
    echo "web page: not built, because npm cannot install the packages of client/web" >&2
    rm -rf "$folder"
    exit 0
  fi
  cp package-lock.json "$installed"
fi

npm run --silent build -- --logLevel warn
rm -rf "$folder"
mkdir -p "$(dirname "$folder")"
cp -r dist "$folder"
