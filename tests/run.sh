#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test (under tsan those that it can judge).
#   tests/run.sh [PRESET] [--in-process] [CTEST OPTIONS...]
#     PRESET: release (default), dev, asan, tsan
#     --in-process: without the client and the tests of whole programs, which take as long to build as the rest
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift $(( $# > 0 ? 1 : 0 ))

./deploy/install_packages.sh build test
cmake --preset "$preset" >"/tmp/motiondb-configure-$$.log" 2>&1 ||
  { cat "/tmp/motiondb-configure-$$.log" >&2; rm -f "/tmp/motiondb-configure-$$.log"; exit 1; }
rm -f "/tmp/motiondb-configure-$$.log"
tests=()
if [ "$preset" = tsan ]; then
  # Debian's gRPC is not instrumented, so the thread sanitizer sees core, storage and the jobs.
  tests=(tree_tests graph_tests model_tests inference_tests recognition_tests storage_tests
         server_engine_tests server_observability_tests)
elif [ "${1:-}" = --in-process ]; then
  shift
  tests=({bench,calibration,estimation,eval,experiment,format,bvh_assimp,graph,inference,kinematics}_tests
         {model,motion,observe,planning,prediction,recognition,storage,storage_power,tree}_tests
         server{,_engine,_observability,_security,_settings,_translate}_tests)
fi
if [ ${#tests[@]} -gt 0 ]; then
  cmake --build --preset "$preset" --target "${tests[@]}"
  set -- -R "^($(IFS='|'; echo "${tests[*]}"))\$" "$@"
else
  cmake --build --preset "$preset"
fi
ctest --test-dir "build/$preset" --output-on-failure --timeout 900 --parallel "$(nproc)" "$@"
