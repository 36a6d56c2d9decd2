#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test.
#   tests/run.sh [PRESET] [CTEST OPTIONS...]     PRESET: release (default), dev, asan, tsan
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift $(( $# > 0 ? 1 : 0 ))

./deploy/install_packages.sh build test
cmake --preset "$preset" >"/tmp/motiondb-configure-$$.log" 2>&1 ||
  { cat "/tmp/motiondb-configure-$$.log" >&2; rm -f "/tmp/motiondb-configure-$$.log"; exit 1; }
rm -f "/tmp/motiondb-configure-$$.log"
cmake --build --preset "$preset"
ctest --test-dir "build/$preset" --output-on-failure --timeout 600 "$@"
