#!/usr/bin/env bash
# Builds the fuzz targets and runs each for a number of executions or a time. Fails on a finding,
# and keeps its input in build/fuzz/findings.
#   tests/fuzz/run.sh [--runs N] [--seconds S] [--import PROGRAM] [TARGET...]
# TARGET: bvh, recognize, ..., import (all). Each target runs N times (default: for some seconds) or
# S seconds. Inputs that cover new code are kept in build/fuzz/corpus for the next run. `import`
# runs import_fuzz.py on the program motiondb-import, by default that of build/release.
set -euo pipefail
cd "$(dirname "$0")/../.."

files=(bvh amc trc c3d csv urdf marker_set npz gzip motion_codec
       annotation_tsv annotation_json babel text_grid)  # seeds: motion_seeds.cc
blobs=(chunk states_codec skeleton_codec graph_codec prediction_codec recognition_codec model_codec)
requests=(names filter connect ingest_stream recognize estimate predict represent observe plan restore)
all=("${files[@]}" "${blobs[@]}" "${requests[@]}" import)
runs=""
seconds=""
importer=build/release/import/motiondb-import
targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    --runs) runs=$2; shift 2 ;;
    --seconds) seconds=$2; shift 2 ;;
    --import) importer=$2; shift 2 ;;
    -*) echo "usage: tests/fuzz/run.sh [--runs N] [--seconds S] [--import PROGRAM] [TARGET...]" >&2
        exit 2 ;;
    *) targets+=("$1"); shift ;;
  esac
done
is_complete=$((${#targets[@]} == 0))
[ ${#targets[@]} -gt 0 ] || targets=("${all[@]}")
with_import=0
for i in "${!targets[@]}"; do
  [ "${targets[i]}" != import ] || { with_import=1; unset "targets[$i]"; }
done
if [ $with_import = 1 ] && [ ! -x "$importer" ]; then
  [ $is_complete = 1 ] || { echo "no program $importer" >&2; exit 2; }
  echo "skipped: import: no $importer"
  with_import=0
fi

failed=0
if [ $with_import = 1 ]; then
  amount=(--seconds "${seconds:-20}")
  [ -z "$runs" ] || amount=(--runs "$runs")
  tests/fuzz/import_fuzz.py --program "$importer" "${amount[@]}" || failed=1
fi
[ ${#targets[@]} -gt 0 ] || exit $failed

# Number of executions that take some seconds.
runs_of() {
  case "$1" in
    plan | restore) echo 150 ;;
    recognize | estimate | predict | observe) echo 1000 ;;
    represent | ingest_stream | model_codec | npz) echo 5000 ;;
    gzip) echo 3000 ;;
    *) echo 20000 ;;
  esac
}
# Longer inputs find nothing new and cost time.
max_length_of() {
  case "$1" in
    names | filter | chunk | graph_codec) echo 1024 ;;
    *) echo 32768 ;;
  esac
}

./deploy/install_packages.sh build test fuzz
mkdir -p build/fuzz
cmake --preset fuzz >build/fuzz/configure.log 2>&1 || { cat build/fuzz/configure.log >&2; exit 1; }
declare -A seeds  # programs that write the seed inputs
for target in "${targets[@]}"; do
  program=fuzz_request_seeds
  [[ " ${files[*]} " != *" $target "* ]] || program=fuzz_motion_seeds
  [[ " ${blobs[*]} " != *" $target "* ]] || program=fuzz_blob_seeds
  seeds[$program]=1
done
cmake --build --preset fuzz --target "${!seeds[@]}" "${targets[@]/%/_fuzz}"
for program in "${!seeds[@]}"; do
  MOTIONDB_FUZZ_SEEDS=build/fuzz/seeds "build/fuzz/tests/fuzz/$program" >build/fuzz/seeds.log ||
    { cat build/fuzz/seeds.log >&2; exit 1; }
done

# The targets bound their memory themselves; these limits catch the rest. Slow inputs below the
# timeout are no findings: the machine may be busy.
limits=(-timeout=60 -report_slow_units=60 -rss_limit_mb=3072 -malloc_limit_mb=1024)
export ASAN_OPTIONS="allocator_may_return_null=0:detect_leaks=0:${ASAN_OPTIONS:-}"
mkdir -p build/fuzz/findings
figures=build/fuzz/figures.tsv
printf 'target\texecutions\tcorpus\tnew coverage\tfindings\texec/s\n' >"$figures"

# run_target TARGET: appends a line to the figures; fails on a finding.
run_target() {
  local target=$1 corpus=build/fuzz/corpus/$1 log=build/fuzz/$1.log failed=0
  mkdir -p "$corpus"
  local amount=(-runs="${runs:-$(runs_of "$target")}")
  [ -z "$seconds" ] || amount=(-runs="${runs:--1}" -max_total_time="$seconds")
  local dictionary=tests/fuzz/dictionaries/$target.dict
  [ ! -f "$dictionary" ] || amount+=(-dict="$dictionary")
  findings() { find build/fuzz/findings -name "$target-*" | wc -l; }
  local before
  before=$(findings)
  "build/fuzz/tests/fuzz/${target}_fuzz" "${limits[@]}" "${amount[@]}" -print_final_stats=1 \
    -max_len="$(max_length_of "$target")" -artifact_prefix="build/fuzz/findings/$target-" \
    "$corpus" "build/fuzz/seeds/${target}_fuzz" >"$log" 2>&1 || failed=1
  local found=$(($(findings) - before))
  [ "$found" -eq 0 ] || failed=1
  stat() { sed -n "s/^stat::$1: *//p" "$log" | tail -n 1; }
  local first last executions
  first=$(sed -n 's/.*INITED *cov: \([0-9]*\).*/\1/p' "$log" | tail -n 1)
  last=$(sed -n 's/.* cov: \([0-9]*\).*/\1/p' "$log" | tail -n 1)
  executions=$(stat number_of_executed_units)
  printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$target" "${executions:-0}" "$(ls "$corpus" | wc -l)" \
    "$((${last:-0} - ${first:-0}))" "$found" "$(stat average_exec_per_sec)" >>"$figures"
  [ -n "$executions" ] || failed=1
  [ "$failed" = 0 ] || tail -n 60 "$log" >&2
  return "$failed"
}

running=0
for target in "${targets[@]}"; do
  if [ "$running" -ge "$(nproc)" ]; then
    wait -n || failed=1
    running=$((running - 1))
  fi
  run_target "$target" &
  running=$((running + 1))
done
while [ "$running" -gt 0 ]; do
  wait -n || failed=1
  running=$((running - 1))
done
column -t -s "$(printf '\t')" "$figures"
exit $failed
