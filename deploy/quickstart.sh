#!/usr/bin/env bash
# Demo: installs missing packages, builds, starts a server with a temporary store, ingests real
# motion from a Debian package, runs queries on held-out parts of it, and plans a motion.
#   deploy/quickstart.sh
set -euo pipefail
if [ $# -gt 0 ]; then
  sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0"
  [ "$1" = --help ] && exit 0
  echo "quickstart.sh: expected no arguments, got '$1'" >&2
  exit 2
fi
cd "$(dirname "$0")/.."

./deploy/install_packages.sh build demo
echo "building (a few minutes the first time) ..."
log=$(mktemp)
work=$(mktemp -d)
server_pid=
finish() {
  [ -z "$server_pid" ] || kill "$server_pid" 2>/dev/null || true
  [ -z "$server_pid" ] || wait "$server_pid" 2>/dev/null || true
  rm -rf "$work" "$log"
}
trap finish EXIT
cmake --preset release -DMOTIONDB_BUILD_TESTS=OFF -B build/quickstart >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
cmake --build build/quickstart --target motiondb motiondbd motiondb-import  # prints the progress
PATH="$PWD/build/quickstart/client/cli:$PWD/build/quickstart/server:$PATH"

# keep FILE FROM TO OUT: writes the frames of a BVH file between two fractions (0 to 1) of its
# length.
keep() {
  awk -v from="$2" -v to="$3" '
    /^[[:space:]]*Frames:/ { count = $2; first = int(from * count); last = int(to * count)
                             printf "Frames: %d\n", last - first; next }
    /^[[:space:]]*Frame Time:/ { print; motion = 1; next }
    motion { if (frame >= first && frame < last) print; frame++; next }
    { print }' "$1" >"$4"
}

plan=$PWD/build/quickstart/plan
models=/usr/share/assimp/models/BVH
mkdir "$work/seen" "$work/held_back"
printf 'path\tlabel\n' >"$work/seen/clips.tsv"
while read -r file label; do
  keep "$models/$file.bvh" 0 0.7 "$work/seen/$file.bvh"
  keep "$models/$file.bvh" 0.7 1 "$work/held_back/$file.bvh"
  printf '%s.bvh\t%s\n' "$file" "$label" >>"$work/seen/clips.tsv"
done <<'CLIPS'
01_01 jump_and_turn
01_03 climb_and_swing
Boxing_Toes boxing
CLIPS

motiondbd --store "$work/motion.db" --listen 127.0.0.1:0 >"$work/address" 2>"$log" &
server_pid=$!
for _ in $(seq 100); do
  grep -q listening "$work/address" && break
  kill -0 "$server_pid" 2>/dev/null || { cat "$log" >&2; exit 1; }
  sleep 0.1
done
MOTIONDB_SERVER=$(sed -n 's/.*listening on //p' "$work/address")
export MOTIONDB_SERVER

ask() {
  printf '\n$ motiondb %s\n' "$*" >&2  # standard error, because callers may cut the output
  (cd "$work" && motiondb "$@")
}

ask create demo >/dev/null
ask ingest demo --list seen/clips.tsv
ask recognize demo held_back/01_01.bvh --window 1 --hop 1 --top 1
ask recognize demo held_back/01_03.bvh --window 1 | tail -n 1
ask recognize demo held_back/Boxing_Toes.bvh --window 1 | tail -n 1
ask estimate demo held_back/01_01.bvh --layer 5 | cut -c1-120 | head -n 8
ask predict demo held_back/01_01.bvh --at 2 --horizon 0.08,0.4,1
ask plan demo --start 01_01@3 --goal 1.5,0,0 --disc 0.8,0.7,0.2 --out "$plan.bvh" --plot "$plan.svg"
printf '\nThe first 70 %% of each clip is stored; the queries use the rest. README.md has the next steps.\n'
