#!/usr/bin/env bash
# Installs what a set of purposes needs and this machine lacks (Debian 12): install_packages.sh build test.
set -euo pipefail

build=(
  g++ cmake ninja-build ccache pkg-config
  libabsl-dev libboost-dev libcli11-dev libeigen3-dev libfmt-dev libspdlog-dev libsqlite3-dev
  libgrpc++-dev libprotobuf-dev protobuf-compiler protobuf-compiler-grpc zlib1g-dev
  libssl-dev       # tokens: random bytes and hashes; checksums of backups; the listener's TLS
  libnghttp2-dev   # HTTP/2 before gRPC: Debian's gRPC 1.51 does not bound what a connection may hold
  libtinyxml2-dev  # URDF files are XML
  libtomlplusplus-dev # the configuration file is TOML
  nlohmann-json3-dev # log lines as JSON, and the figures that motiondb_eval writes
  prometheus-cpp-dev # metrics: counters, histograms and their text format (its HTTP server is not used)
  python3          # manual pages and completions, from what the programs say of themselves
  file             # what the package's programs link, for its dependencies
  dpkg-dev
)
test=(
  catch2 clang-format
  assimp-testmodels  # real motion that any machine can install
  dart-doc           # two C3D captures
  libassimp-dev      # an importer that the BVH we write must please
  libbenchmark-dev   # Google Benchmark: what tests/bench measures speed with
  libfaiss-dev       # nearest neighbours: what recognition is measured against
  libopenblas0-pthread # FAISS at its own speed: the reference BLAS is many times slower
  openssl            # certificates that tests make
  python3-grpcio     # the client in Python of docs/api.md
  python3-protobuf
  python3-numpy      # opens what `motiondb dump` writes
  python3-prometheus-client # reads the metrics as Prometheus does
)
demo=(assimp-testmodels)
fuzz=(
  clang            # the compiler that has libFuzzer
  libclang-rt-dev  # its run-time libraries: libFuzzer and the sanitizers
  llvm             # llvm-symbolizer: findings with names and lines
  bsdextrautils    # column: the table of what was run
)
lint=(
  clang            # checks what mutexes guard
  clang-tidy       # checks sources that changed
)
deploy_test=(       # what tests/deploy uses beyond these
  debootstrap       # a Debian to install the package in, and to make an image from
  buildah           # builds and runs the image without a container engine
  nginx-light       # the front
  curl              # asks the front over HTTP/2
  prometheus        # promtool, which evaluates the alert rules
  openssl           # certificates of a test's own
  systemd           # systemd-analyze, which judges the unit
  man-db            # reads the manual pages
  bsdextrautils     # col, that takes their bold face off
  python3-yaml      # the Kubernetes manifests
)

wanted=()
for purpose in "$@"; do
  case "$purpose" in
    build) wanted+=("${build[@]}") ;;
    test) wanted+=("${test[@]}") ;;
    demo) wanted+=("${demo[@]}") ;;
    fuzz) wanted+=("${fuzz[@]}") ;;
    lint) wanted+=("${lint[@]}") ;;
    deploy-test) wanted+=("${deploy_test[@]}") ;;
    *) echo "install_packages.sh: expected build, test, demo, fuzz, lint or deploy-test, got '$purpose'" >&2; exit 2 ;;
  esac
done

missing=()
for package in "${wanted[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "installing: ${missing[*]}"
as_root=()
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "install these as root: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
# nginx and Prometheus are wanted as programs: their services would open ports. Where nobody has said what may
# start, nothing is started while this installs.
policy=/usr/sbin/policy-rc.d
if [[ " ${missing[*]} " =~ \ (nginx-light|prometheus)\  && ! -e $policy ]]; then
  trap '"${as_root[@]}" rm -f "$policy"' EXIT
  printf '#!/bin/sh\nexit 101\n' | "${as_root[@]}" tee "$policy" >/dev/null
  "${as_root[@]}" chmod 755 "$policy"
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
