#!/usr/bin/env bash
# Installs missing packages, builds, and runs all tests (under tsan only the suitable ones) or some.
#   tests/run.sh [PRESET] [TEST...] [CTEST OPTIONS...]
#     PRESET: release (default), dev, asan, tsan
#     TEST: a test program, for example tree_tests: builds and runs only that one
set -euo pipefail
cd "$(dirname "$0")/.."
preset=release
if [[ ${1:-} = [a-z]* && $1 != *_tests ]]; then
  preset=$1
  shift
fi
tests=()
while [[ ${1:-} = *_tests ]]; do
  tests+=("$1")
  shift
done

packages=(build test)
[ ${#tests[@]} -gt 0 ] || packages+=(web web-test)
./deploy/install_packages.sh "${packages[@]}"
export MOTIONDB_REQUIRE_POSTGRES=1  # no skipped tests of the PostgreSQL store
# The build folder may have been configured without tests.
cmake --preset "$preset" -DMOTIONDB_BUILD_TESTS=ON >"/tmp/motiondb-configure-$$.log" 2>&1 ||
  { cat "/tmp/motiondb-configure-$$.log" >&2; rm -f "/tmp/motiondb-configure-$$.log"; exit 1; }
rm -f "/tmp/motiondb-configure-$$.log"
timeout=900  # seconds; a test that takes longer hangs
if [ "$preset" != release ]; then
  timeout=1800
  export MOTIONDB_TEST_SLOWNESS=10
  # The release build injects every fault at every disk operation; the code is equal in all builds.
  export MOTIONDB_FAULT_SEEDS=${MOTIONDB_FAULT_SEEDS:-2}
  export MOTIONDB_FAULT_STRIDE=${MOTIONDB_FAULT_STRIDE:-16}
  # Freed memory is reused after 64 MiB instead of 256, and reports have 8 callers of an allocation
  # instead of 30: half the time. Undefined behaviour traps (deploy/cmake/MotiondbTarget.cmake).
  export ASAN_OPTIONS="handle_sigill=1:quarantine_size_mb=64:malloc_context_size=8:${ASAN_OPTIONS:-}"
  export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0:${LSAN_OPTIONS:-}"
fi
# Sanitizers find nothing new in tests of documents, packaging and accuracy.
[[ "$preset" != *san ]] || set -- -LE '^once$' "$@"
if [ "$preset" = tsan ] && [ ${#tests[@]} = 0 ]; then
  # The tests that run several threads. Debian's gRPC is not instrumented, so those of the service
  # and the client are left out.
  tests=({tree,model,calibration,storage,storage_commit}_tests server_{engine,observability}_tests)
fi
if [ ${#tests[@]} = 0 ]; then
  cmake --build --preset "$preset"
else
  cmake --build --preset "$preset" --target "${tests[@]}"
  set -- -R "^($(IFS='|'; echo "${tests[*]}"))(_part[0-9]+)?\$" "$@"
fi
# Temporary files in memory, if it has 4 GiB for them: the tests would wait for the disk half of their
# time. Power cuts, full and slow disks are simulated.
memory=/dev/shm
free_mib=$(df --output=avail --block-size=1M "$memory" 2>/dev/null | tail -n 1) || true
if [ -z "${TMPDIR:-}" ] && [ "${free_mib:-0}" -gt 4096 ] &&
   ! grep -q "^[^ ]* $memory .*noexec" /proc/mounts; then
  TMPDIR=$(mktemp -d "$memory/motiondb-tests-XXXXXX")
  chmod 1777 "$TMPDIR"  # PostgreSQL runs as a user of its own
  export TMPDIR
  trap 'rm -rf "$TMPDIR"' EXIT
fi
# One test more than processors, because tests also wait.
ctest --test-dir "build/$preset" --no-tests=error --output-on-failure --timeout "$timeout" \
  --parallel $(($(nproc) + 1)) "$@"
