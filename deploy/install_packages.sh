#!/usr/bin/env bash
# Installs missing Debian 12 packages for the given purposes, and package files, for example:
#   install_packages.sh build test ./motiondb.deb
set -euo pipefail

build=(
  g++ cmake ninja-build ccache pkg-config
  libabsl-dev libboost-dev libcli11-dev libeigen3-dev libfmt-dev libspdlog-dev libsqlite3-dev
  libgrpc++-dev libprotobuf-dev protobuf-compiler protobuf-compiler-grpc zlib1g-dev
  libssl-dev       # tokens: random bytes and hashes; checksums of backups; the listener's TLS
  libpq-dev        # the PostgreSQL store, for several servers
  libnghttp2-dev   # HTTP/2 listener: gRPC 1.51 of Debian does not bound the memory of a connection
  libseccomp-dev   # motiondb-import: system calls of a process that reads a file of unknown origin
  libassimp-dev    # motiondb-import reads FBX, glTF and Collada
  libzip-dev       # motiondb-import reads NPZ files, which are ZIP archives
  libutf8proc-dev  # full-text search: case folding of all scripts, and accents
  libtinyxml2-dev  # URDF files are XML
  libtomlplusplus-dev # the configuration file is TOML
  libcairo2-dev    # pictures as SVG and PNG from one drawing code: cairo draws the PNG
  nlohmann-json3-dev # log lines as JSON, and the results of motiondb_eval
  prometheus-cpp-dev # metrics: counters, histograms and their text format (its HTTP server is not used)
  python3          # generates manual pages and completions from --help
  file             # dpkg-shlibdeps: dependencies of the package
  dpkg-dev
)
web=(
  nodejs npm       # build the web page; their packages are in client/web/package-lock.json
)
test=(
  catch2 clang-format
  assimp-testmodels  # real motion in BVH
  dart-doc           # two C3D captures
  libbenchmark-dev   # Google Benchmark, for tests/bench
  libfaiss-dev       # nearest neighbours, the baseline of recognition
  libopenblas0-pthread # for FAISS: the reference BLAS is many times slower
  openssl            # certificates of tests
  pgbouncer          # the pooler of a test of the PostgreSQL store
  postgresql-15      # tests of the PostgreSQL store start clusters of their own
  python3-grpcio     # the Python client of docs/api.md
  python3-protobuf
  python3-numpy      # reads the files of `motiondb dump`
  python3-prometheus-client # parses the metrics
)
demo=(
  assimp-testmodels  # a boxer in BVH
  python3-minimal    # generates the motion of the demo
)
fuzz=(
  clang            # compiler with libFuzzer
  libclang-rt-dev  # run-time libraries of libFuzzer and the sanitizers
  llvm             # llvm-symbolizer: names and lines in findings
  bsdextrautils    # column: the table of results
)
lint=(
  clang            # thread safety analysis of mutexes
  clang-tidy       # checks changed sources
)
web_test=(
  chromium-headless-shell  # the browser of tests/web: Chromium without windows, which cost time
)
deploy_test=(       # additional packages for tests/deploy
  debootstrap       # Debian systems for the package and the image
  buildah           # builds and runs the image without a container engine
  nginx-light       # the proxy
  curl              # HTTP/2 requests to the proxy
  prometheus        # promtool, which tests the alert rules
  openssl           # certificates of tests
  systemd           # systemd-analyze, which checks the unit
  man-db            # renders the manual pages
  zsh fish          # complete the command line
  bsdextrautils     # col, which removes bold text
  python3-yaml      # the Kubernetes manifests
)

wanted=()
for purpose in "$@"; do
  case "$purpose" in
    build) wanted+=("${build[@]}") ;;
    web) command -v npm >/dev/null || wanted+=("${web[@]}") ;;  # npm of another source suffices
    web-test) wanted+=("${web_test[@]}") ;;
    test) wanted+=("${test[@]}") ;;
    demo) wanted+=("${demo[@]}") ;;
    fuzz) wanted+=("${fuzz[@]}") ;;
    lint) wanted+=("${lint[@]}") ;;
    deploy-test) wanted+=("${deploy_test[@]}") ;;
    */*.deb) wanted+=("$purpose") ;;
    *) echo "install_packages.sh: expected build, web, test, web-test, demo, fuzz, lint, deploy-test or a path of a .deb file, got '$purpose'" >&2; exit 2 ;;
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
  command -v sudo >/dev/null || { echo "install_packages.sh: no sudo; install as root: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
# The tests need only the programs of nginx and Prometheus; their services would open ports. Unless
# the machine has its own policy, prevent service starts during the installation.
policy=/usr/sbin/policy-rc.d
if [[ " ${missing[*]} " =~ \ (nginx-light|prometheus)\  && ! -e $policy ]]; then
  trap '"${as_root[@]}" rm -f "$policy"' EXIT
  printf '#!/bin/sh\nexit 101\n' | "${as_root[@]}" tee "$policy" >/dev/null
  "${as_root[@]}" chmod 755 "$policy"
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends -o APT::Status-Fd=1 "${missing[@]}" |
  awk -F: '/^(dl|pm)status:/ {
             stage = $1 == "dlstatus" ? "downloading" : "unpacking and configuring"
             if (!seen[stage, int($3 / 10)]++) { printf "  %s: %d %%\n", stage, $3; fflush() }
           }'
