#!/usr/bin/env bash
# Demo: installs missing packages, builds or installs motiondb, and runs deploy/demo/demo.sh: a
# server that stores motion and answers every kind of query.
#   deploy/quickstart.sh                      builds: 5 to 6 minutes on two cores
#   deploy/quickstart.sh --package FILE.deb   installs a package instead: about 20 s
set -euo pipefail
usage() { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0"; }
package=
case "$#:${1:-}" in
  0:) ;;
  1:--help) usage; exit 0 ;;
  2:--package) package=$(realpath -- "$2") ;;
  *) usage >&2; echo "quickstart.sh: unexpected arguments: $*" >&2; exit 2 ;;
esac
if [ -n "$package" ] && [ ! -r "$package" ]; then
  echo "quickstart.sh: cannot read $package" >&2
  exit 2
fi
cd "$(dirname "$0")/.."
begin=$SECONDS
stage() { printf '[%d:%02d] %s\n' $(((SECONDS - begin) / 60)) $(((SECONDS - begin) % 60)) "$*"; }

if [ -n "$package" ]; then
  stage "installing $package and its dependencies"
  ./deploy/install_packages.sh demo "$package"
  programs=/usr/bin
else
  stage "installing what the build needs"
  ./deploy/install_packages.sh build demo
  stage "configuring"
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  programs=$PWD/build/quickstart/bin
  cmake --preset release -B build/quickstart -DMOTIONDB_BUILD_TESTS=OFF \
    -DCMAKE_RUNTIME_OUTPUT_DIRECTORY="$programs" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
  stage "building in build/quickstart"
  targets=(motiondb motiondbd motiondb-import motiondb_manuals)
  # The web page.
  if command -v node >/dev/null && command -v npm >/dev/null; then targets+=(web); fi
  NINJA_STATUS='  [%f of %t, %es] ' cmake --build build/quickstart --target "${targets[@]}"
fi
stage "running the demo"
./deploy/demo/demo.sh "$programs" build/quickstart/demo
stage "done"
