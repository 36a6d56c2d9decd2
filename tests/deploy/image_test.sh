#!/usr/bin/env bash
# Builds the image of deploy/docker/Dockerfile on a base from debootstrap, without a container
# engine. Runs containers, sends queries from outside, and checks that they are healthy and
# unprivileged and that the store survives them. It compiles the project, so ctest does not run it.
#   tests/deploy/image_test.sh MOTIONDB        path of the client
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
motiondb=$(realpath "$1")
. "$here/root_folder.sh"
need_root
need debootstrap buildah python3

work=$(mktemp -d)
container= run= server=
finish() {
  [ -z "$server" ] || kill -KILL "$server" 2>/dev/null || true
  [ -z "$container" ] || in_storage rm "$container" >/dev/null || true
  rm -rf "$work"
}
trap finish EXIT
fail() {
  echo "image_test: $1" >&2
  [ ! -s "$work/log" ] || tail -n 20 "$work/log" >&2
  exit 1
}
# The image storage of this test.
driver=$(grep -qw overlay /proc/filesystems && echo overlay || echo vfs)
in_storage() {
  buildah --root "$cache/containers" --runroot "$work/run" --storage-driver "$driver" "$@"
}

echo "== the base image"
base_root
if ! in_storage inspect localhost/bookworm >/dev/null 2>&1; then
  root=$work/root
  mkdir "$root"
  cp -a "$cache/bookworm/." "$root"
  rm -f "$root/etc/apt/sources.list"
  cp -rL /etc/apt/. "$root/etc/apt"
  cp -rL /usr/share/keyrings/. "$root/usr/share/keyrings"
  scratch=$(in_storage from scratch)
  in_storage add --quiet "$scratch" "$root" / >/dev/null
  in_storage config --cmd bash "$scratch"
  in_storage commit --quiet --rm "$scratch" localhost/bookworm >/dev/null
  rm -rf "$root"
fi

echo "== the image, built by the Dockerfile"
# Uses the compiler cache of this machine, if any.
mounts=()
compiled=${CCACHE_DIR:-$HOME/.cache/ccache}
[ ! -d "$compiled" ] || mounts=(--volume "$compiled:/root/.cache/ccache")
# npm in the build trusts what npm on this machine trusts.
trusted=$(npm config get cafile 2>/dev/null || true)
[ -f "$trusted" ] || trusted=${NODE_EXTRA_CA_CERTS:-}
if [ -f "$trusted" ]; then
  echo "cafile=/etc/npm-trusted.crt" >"$work/npmrc"
  mounts+=(--volume "$(realpath "$trusted"):/etc/npm-trusted.crt:ro" --volume "$work/npmrc:/root/.npmrc:ro")
fi
(cd "$here/../.." && in_storage bud --format docker --isolation chroot --build-arg BASE=localhost/bookworm \
  "${mounts[@]}" -f deploy/docker/Dockerfile -t localhost/motiondb .) >"$work/log" 2>&1 || fail "buildah bud"
grep -o "STEP .*" "$work/log"
: >"$work/log"
in_storage inspect --type image --format \
  'user {{.OCIv1.Config.User}}  volumes {{.OCIv1.Config.Volumes}}  ports {{.OCIv1.Config.ExposedPorts}}  stop {{.OCIv1.Config.StopSignal}}{{"\n"}}' \
  localhost/motiondb | tee "$work/config"
grep -q "user 65051:65051" "$work/config" || fail "the user of the image is not 65051:65051"
grep -q "/var/lib/motiondb" "$work/config" || fail "the store is not on a volume"
# The Docker format has the health check; in the OCI format buildah would omit it with a warning.
in_storage inspect --type image --format '{{.Docker.Config.Healthcheck.Test}}' localhost/motiondb |
  tee "$work/config" | grep -q /usr/lib/motiondb/health_check || fail "the image has no health check"

store=$work/volume
install -d -o 65051 -g 65051 "$store"
# With chroot isolation containers share the network of this machine, so they need free ports for
# gRPC and HTTP.
free_port() {
  python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}
port=$(free_port)
http=$(free_port)
web=$(free_port)

# in_container LOG COMMAND...: runs a command with the user and variables of the image, and retries
# if buildah itself could not start. buildah runs from a sealed copy of itself in memory; on a busy
# machine the kernel can refuse the seal with EBUSY.
in_container() {
  local attempt code
  for attempt in 1 2 3 4 5; do
    code=0
    in_storage run --isolation chroot --volume "$store:/var/lib/motiondb" \
      --env "MOTIONDBD_HTTP_LISTEN=127.0.0.1:$http" "$container" -- "${@:2}" 2>"$1" || code=$?
    grep -q "sealing memfd copy" "$1" || return "$code"
    sleep 1
  done
  return "$code"
}

# Starts a container with the program of the image.
start_container() {
  local i
  container=$(in_storage from localhost/motiondb)
  in_container "$work/log" motiondbd --listen "127.0.0.1:$port" --http-listen "127.0.0.1:$http" \
    --web-listen "127.0.0.1:$web" >"$work/address" &
  run=$!
  for i in $(seq 300); do
    if grep -q listening "$work/address"; then
      server=$(pgrep -u 65051 -f "^/usr/bin/motiondbd --listen 127.0.0.1:$port") || fail "no server runs as the user of the image"
      return
    fi
    kill -0 "$run" 2>/dev/null || fail "the container ended"
    sleep 0.1
  done
  fail "the server in the container did not start within 30 s"
}
stop_container() {
  [ -z "$server" ] || kill -TERM "$server" || true  # STOPSIGNAL of the image
  [ -z "$run" ] || wait "$run" || fail "the server did not shut down cleanly"
  server= run=
  [ -z "$container" ] || in_storage rm "$container" >/dev/null
  container=
}
ask() {
  "$motiondb" --server "127.0.0.1:$port" "$@"
}

echo "== a container"
start_container
[ "$(ps -o uid= -p "$server" | tr -d ' ')" = 65051 ] || fail "the server does not run as user 65051"
grep -q '^CapEff:.0*$' "/proc/$server/status" || fail "the server has capabilities"
in_container "$work/health" /usr/lib/motiondb/health_check || fail "the health check failed"
python3 -c 'import sys, urllib.request
sys.exit(b"<title>motiondb" not in urllib.request.urlopen(sys.argv[1]).read())' "http://127.0.0.1:$web" ||
  fail "no web page"
"$here/walk.py" 6 1 >"$work/walk.bvh"
"$here/walk.py" 6 2 >"$work/run.bvh"
ask create demo --marker-set source --min-frames 4 >/dev/null
ask ingest demo "$work/walk.bvh" --label walk | tail -n 1
# The server reads GLB with motiondb-import.
"$motiondb" convert "$work/run.bvh" "$work/run.glb" >/dev/null
ask ingest demo "$work/run.glb" --label run | tail -n 1
ask recognize demo "$work/run.bvh" --window all | tee "$work/answer"
grep -q run "$work/answer" || fail "recognize did not find the stored motion"
in_container "$work/which" sh -c 'for program in gcc g++ cmake; do ! which $program || exit 1; done' ||
  fail "the image has a compiler"

echo "== a new container on the same volume"
stop_container
start_container
ask recognize demo "$work/run.bvh" --window all | diff "$work/answer" - || fail "the store did not survive"
stop_container
echo "image_test: passed"
