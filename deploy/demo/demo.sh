#!/usr/bin/env bash
# The queries of the quickstart: starts a server with a new store, stores generated motion of four
# people, and asks about motion of a fifth one and about a boxer. The server keeps running.
#   deploy/demo/demo.sh PROGRAM_FOLDER DEMO_FOLDER
# DEMO_FOLDER is replaced if an earlier demo made it; that demo's server is stopped.
set -euo pipefail
if [ $# != 2 ]; then
  echo "usage: demo.sh PROGRAM_FOLDER DEMO_FOLDER" >&2
  exit 2
fi
here=$(cd "$(dirname "$0")" && pwd)
programs=$(cd "$1" && pwd)
mkdir -p "$2"
demo=$(cd "$2" && pwd)
boxer=/usr/share/assimp/models/BVH/Boxing_Toes.bvh  # Debian package assimp-testmodels
PATH="$programs:$PATH"

# Whether the process of the former demo's server is still that server.
is_running() { [ "$(readlink "/proc/$1/exe" 2>/dev/null)" = "$(realpath "$programs/motiondbd")" ]; }
if [ -s "$demo/server.pid" ]; then
  pid=$(<"$demo/server.pid")
  if is_running "$pid"; then
    kill "$pid"
    while is_running "$pid"; do sleep 0.1; done
  fi
fi
rm -rf "$demo"/{stored,new,motion.db*,server.pid,server.log,plan.*}

echo "generating motion: walk, run, turn and wave of five people"
python3 "$here/generate_motion.py" "$demo/stored"
mkdir "$demo/new"
mv "$demo"/stored/*-eve-*.bvh "$demo/new"
sed -i '/-eve-/d' "$demo/stored/clips.tsv"
cp "$boxer" "$demo/new/boxing.bvh"

# Port 50051, or a free one.
start_server() {
  "$programs/motiondbd" --store "$demo/motion.db" --listen "$1" >"$demo/server.log" 2>&1 &
  pid=$!
  until grep -q 'listening on' "$demo/server.log"; do
    kill -0 "$pid" 2>/dev/null || return 1
    sleep 0.1
  done
}
start_server 127.0.0.1:50051 || start_server 127.0.0.1:0 || { cat "$demo/server.log" >&2; exit 1; }
echo "$pid" >"$demo/server.pid"
MOTIONDB_SERVER=$(sed -n 's/.*listening on //p' "$demo/server.log" | head -n 1)
export MOTIONDB_SERVER

ask() {
  printf '\n$ motiondb %s\n' "$*"
  (cd "$demo" && motiondb "$@")
}
say() { printf '\n%s\n' "$*"; }

say "Store clips of four people, several for each label:"
ask create demo
ask ingest demo --list stored/clips.tsv
say "Name the motion of a fifth person. The file names tell the truth; a boxer is unknown:"
ask recognize demo new
say "Which state is it in, by its node in the tree?"
ask estimate demo new/walk-eve-1.bvh --layer 5 | cut -c1-100
say "What comes next, beside what then happened?"
ask predict demo new/walk-eve-1.bvh --at 2 --horizon 0.08,0.4,1 --compare
say "How does one get to a goal behind a pillar?"
ask plan demo --start walk-ada-1@1 --goal 2.5,1,45deg --disc 1.2,0.6,0.2 --out plan.bvh --plot plan.svg

cat <<END

server:    $MOTIONDB_SERVER (process $pid; stop it with: kill $pid)
programs:  $programs
restart:   $programs/motiondbd --store $demo/motion.db --listen $MOTIONDB_SERVER
open next: $demo/plan.svg in a browser, $demo/plan.bvh in Blender, README.md for the tour
END
