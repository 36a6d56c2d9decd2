#!/usr/bin/env bash
# Installs missing packages, builds the release benchmarks and runs them. Prints one table whose
# rows compare with a peer or a limit of the same run, then the output of programs without rows.
# Missed bars do not fail. Use a machine without other load.
#   tests/bench/run.sh [--quick] [--json FILE]     --quick: small databases, few rounds
set -euo pipefail
cd "$(dirname "$0")/../.."

quick=0
json=
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) quick=1 ;;
    --json) json=$(realpath -m "${2:?--json: expected a file}"); shift ;;
    *) echo "run.sh: expected --quick or --json FILE, got '$1'" >&2; exit 2 ;;
  esac
  shift
done

# Programs that write rows, in the order of the table, with their options for --quick.
quick_flags=()
declare -A quick_options=(
  [annotations]="--listed 10000 --clips 200 --frames 100000"
  [masks]="--clips 200 --frames 100000"
  [parse]="--rounds 3"
  [recognize]="--clips 200 --frames 100000"
  [scale]="--clips 200 --frames 100000"
  [server]="--quick"
  [gateway]="--quick"
  [stores]="--clips 200 --frames 100000 --rounds 3"
  [tree]="--frames 10000,30000"
  [writes]="--clips 60 --frames 30000"
)
with_rows=(tree recognize masks annotations scale extend writes server gateway stores parse)
plain=(catalog kinematics plan robot_plan)

./deploy/install_packages.sh build test >&2
cmake --preset release >&2
cmake --build --preset release --target motiondb_bench_summary \
  "${with_rows[@]/#/motiondb_bench_}" "${plain[@]/#/motiondb_bench_}" >&2
programs=build/release/tests/bench

results=$(mktemp -d)
# A PostgreSQL cluster, which refuses to run as root.
postgres=$(ls -d /usr/lib/postgresql/*/bin | tail -1)
as_postgres=()
cluster=$(mktemp -d)
if [ "$(id -u)" = 0 ]; then
  as_postgres=(setpriv --reuid=postgres --regid=postgres --clear-groups)
  chown postgres "$cluster"
fi
end() {
  "${as_postgres[@]}" "$postgres/pg_ctl" stop -D "$cluster/data" -m immediate >/dev/null || true
  rm -rf "$results" "$cluster"
}
trap end EXIT
cd "$cluster"
"${as_postgres[@]}" "$postgres/initdb" -A trust -E UTF8 --locale=C -U motiondb -D "$cluster/data" >/dev/null
"${as_postgres[@]}" "$postgres/pg_ctl" start -D "$cluster/data" -l "$cluster/log" -w \
  -o "-k $cluster -c listen_addresses= -c shared_buffers=256MB" >/dev/null
cd - >/dev/null
# One large store for several programs: the first creates it.
declare -A options_always=(
  [scale]="--store $results/large.db"
  [extend]="--store $results/large.db --rebuild"
  [stores]="--postgres postgresql://motiondb@/postgres?host=$cluster"
)
tables=()
for name in "${with_rows[@]}"; do
  read -ra options <<<"${options_always[$name]-}"
  [ "$quick" = 0 ] || read -ra quick_flags <<<"${quick_options[$name]-}"
  options+=("${quick_flags[@]}")
  echo "motiondb_bench_$name ${options[*]}" >&2
  "$programs/motiondb_bench_$name" "${options[@]}" --json "$results/$name.json" >&2
  # A program without its data prints this and writes no file.
  [ ! -f "$results/$name.json" ] || tables+=("$results/$name.json")
done
if [ ${#tables[@]} -gt 0 ]; then
  "$programs/motiondb_bench_summary" "${tables[@]}" ${json:+--json "$json"}
fi
for name in "${plain[@]}"; do
  if [ "$quick" = 0 ] || [ "$name" = kinematics ]; then
    printf '### %s\n\n' "$name"
    "$programs/motiondb_bench_$name"
  fi
done
