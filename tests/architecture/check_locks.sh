#!/usr/bin/env bash
# Checks with clang that guarded data is used only while its mutex is held, in all files of
# storage/, server/ and client/ that use a mutex of storage/mutex.h or absl, or that define methods
# of a class whose header does.
# Mutexes of the standard library have no annotations and are forbidden.
#   check_locks.sh BUILD     BUILD: a folder where motiondb_proto was built
set -euo pipefail
build=$(realpath "$1")
cd "$(dirname "$0")/../.."

if grep -rnE 'std::([a-z_]+_)?mutex\b' core text import storage server client --include='*.h' --include='*.cc' |
    grep -v '^storage/mutex.h:'; then
  echo "locks: use storage/mutex.h, or absl::Mutex in client/" >&2
  exit 1
fi
mapfile -t files < <({
  grep -rlE 'MutexLock|ReadLock|ABSL_GUARDED_BY' storage server client --include='*.cc'
  grep -rl ABSL_GUARDED_BY storage server client --include='*.h' | while read -r header; do
    classes=$(sed -nE 's/^(class|struct) ([A-Za-z]+)( final)?( :.*)? \{$/\2/p' "$header" | paste -sd '|')
    [ -z "$classes" ] ||
      grep -lE "^[^ /].*\b($classes)::~?[A-Za-z]+\(" "$(dirname "$header")"/*.cc || true
  done
} | sort -u)
[ ${#files[@]} -gt 20 ] || { echo "locks: found only ${#files[@]} files with a mutex" >&2; exit 1; }
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 4 clang++ -std=c++20 -fsyntax-only -w \
  -Wthread-safety -Werror=thread-safety -DMOTIONDB_VERSION='""' -DFMT_SHARED -DSPDLOG_FMT_EXTERNAL \
  -I. -Iclient/include -isystem /usr/include/eigen3 -isystem /usr/include/postgresql \
  -isystem "$build/proto/generated"
echo "locks: ${#files[@]} files lock correctly"
