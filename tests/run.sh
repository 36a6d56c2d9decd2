#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test (under tsan those that it can judge).
#   tests/run.sh [PRESET] [CTEST OPTIONS...]
#     PRESET: release (default), dev, asan, tsan
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift $(( $# > 0 ? 1 : 0 ))

./deploy/install_packages.sh build test
# Tests are asked for: the folder may be one that was configured without.
cmake --preset "$preset" -DMOTIONDB_BUILD_TESTS=ON >"/tmp/motiondb-configure-$$.log" 2>&1 ||
  { cat "/tmp/motiondb-configure-$$.log" >&2; rm -f "/tmp/motiondb-configure-$$.log"; exit 1; }
rm -f "/tmp/motiondb-configure-$$.log"
timeout=900  # seconds, after which a test is taken to hang
if [ "$preset" != release ]; then
  timeout=1800
  export MOTIONDB_TEST_SLOWNESS=10
  export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0:${LSAN_OPTIONS:-}"
fi
if [ "$preset" = tsan ]; then
  # Debian's gRPC is not instrumented, so the thread sanitizer sees core, storage and the jobs.
  tests=({motion,format,kinematics,tree,graph,model,inference,calibration,recognition}_tests
         {estimation,prediction,observe,planning,storage,storage_commit}_tests
         server_{engine,observability}_tests)
  cmake --build --preset "$preset" --target "${tests[@]}"
  set -- -R "^($(IFS='|'; echo "${tests[*]}"))\$" "$@"
else
  cmake --build --preset "$preset"
fi
ctest --test-dir "build/$preset" --no-tests=error --output-on-failure --timeout "$timeout" --parallel "$(nproc)" "$@"
