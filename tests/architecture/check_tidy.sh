#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) on the most recently changed sources; all sources take an hour.
#   check_tidy.sh BUILD [--count N | FILE...]     BUILD: a folder where motiondb_proto was built
set -euo pipefail
build=$(realpath "$1")
shift
cd "$(dirname "$0")/../.."

count=16
if [ "${1:-}" = --count ]; then
  count=$2
  shift 2
fi
files=("$@")
if [ ${#files[@]} = 0 ]; then
  # By commit; uncommitted changes first.
  mapfile -t files < <({ git diff --name-only HEAD; git log --name-only --pretty=format: ; } |
    awk '/^(core|import|storage|server|client|text)\/.*\.cc$/ && !seen[$0]++' |
    while read -r file; do [ ! -f "$file" ] || echo "$file"; done | awk -v most="$count" 'NR <= most')
fi
[ ${#files[@]} -gt 0 ] || { echo "tidy: found no sources" >&2; exit 1; }
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -I{} clang-tidy --quiet {} -- -std=c++20 \
    -DMOTIONDB_VERSION='""' -DFMT_SHARED -DSPDLOG_FMT_EXTERNAL -I. -Iclient/include \
    -isystem /usr/include/eigen3 -isystem /usr/include/postgresql -isystem "$build/proto/generated" > "$log" 2>&1; then
  grep -vE '^[0-9]+ warnings? (generated|treated)|^Suppressed|^Use -header-filter' "$log"
  exit 1
fi
echo "tidy: ${#files[@]} files are clean"
