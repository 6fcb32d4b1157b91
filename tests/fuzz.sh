#!/usr/bin/env bash
# Fuzzes the C interface on the CPU, on the reference and on the software backend, and with computations that are stopped before
# they take long, and what the add-on reads from files.
#   bash tests/fuzz.sh                 the corpus, then new inputs, 100,000 in all; the same ones every time
#   bash tests/fuzz.sh --inputs N      so many in all
#   bash tests/fuzz.sh --cpu N         so many of the engine on the CPU alone
#   bash tests/fuzz.sh --hours H       as many as fit, others every time, at the lowest priority; the corpus grows in build/fuzz/corpus
# What is found lies in build/fuzz/findings; the command that repeats it is printed.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/sanitizers/build.sh"

inputs=100000 seconds=0 only_cpu= priority=10 patience=60
while [ $# -gt 0 ]; do
  case "$1 ${2:-}" in
  "--inputs "[1-9]*) inputs=$2 ;;
  "--cpu "[1-9]*) inputs=$(($2 * 10)) only_cpu=yes patience=600 ;; # runs for an hour and more, beside other work
  "--hours "[0-9.]*) seconds=$(awk -v hours="$2" 'BEGIN { print int(hours * 3600) }') ;;
  *) fail "usage: bash tests/fuzz.sh [--inputs N | --cpu N | --hours H]" ;;
  esac
  shift 2
done

python=${PARADESC_PYTHON:-$python}
install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${CLANG_PACKAGES[@]}"
[ -x "$python" ] || make_environment "${REQUIREMENTS[@]}"
folder=$root/build/fuzz
mkdir -p "$folder/findings"
build_with_clang "$folder" "-O2 -gline-tables-only" "paradesc_fuzz_cpu paradesc_fuzz_reference paradesc_fuzz_software paradesc_fuzz_stopped" \
  -DPARADESC_FUZZ=ON -DPARADESC_TESTS=OFF
[ -f "$root/addon/paradesc/lib/libparadesc.so" ] || build_library paradesc

export UBSAN_OPTIONS=print_stacktrace=1 LSAN_OPTIONS=suppressions=$root/tests/sanitizers/leaks.txt:print_suppressions=0

# calls TARGET NAME LIMIT...: libFuzzer over the corpus and what follows from it. Stopped computations begin with that of whole ones,
# cut short: a mesh, options and the first calls, of which there are twice as many a second as of long sequences. The device keeps
# its programs from input to input, so leaks are looked for at the end; elsewhere after each.
calls() {
  local target=$1 name=$2 seeds=reference log=$folder/$2.log longest=1024 leaks=1 status
  [ "$target" != stopped ] || longest=256
  [ "$target" != software ] || seeds=software leaks=0
  shift 2
  mkdir -p "$folder/corpus/$name"
  nice -n "$priority" "$folder/paradesc_fuzz_$target" "-max_len=$longest" "-detect_leaks=$leaks" "-timeout=$patience" \
    -len_control=0 -entropic=0 -reload=0 -rss_limit_mb=4096 -print_final_stats=1 "-artifact_prefix=$folder/findings/$name-" "$@" \
    "$folder/corpus/$name" "$root/tests/fuzz/corpus/$seeds" >"$log" 2>&1
  status=$?
  echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs, $(sed -n 's/^calls of the interface: //p' "$log") calls," \
    "$(sed -n 's/^Done .* in \(.*\) second.*/\1/p' "$log") s"
  [ $status -ne 0 ] || return 0
  grep -vE '^#[0-9]+\s|NEW_FUNC' "$log" | tail -n 40
  echo "$name: FOUND SOMETHING (exit $status); again: $folder/paradesc_fuzz_$target $(sed -n 's/.*Test unit written to //p' "$log" | tail -n 1)"
  return 1
}

# files ARGUMENT...
files() {
  PYTHONPATH=$root/addon nice -n "$priority" "$python" "$root/tests/fuzz/readers.py" "$@"
}

# files_for SECONDS: other files every round.
files_for() {
  local end=$((SECONDS + $1)) seed=$RANDOM
  while [ $SECONDS -lt "$end" ]; do
    files --inputs 100000 --seed $((seed++)) || return 1
  done
}

stopped_and_files() {
  calls stopped stopped -seed=3 "-runs=$((inputs / 10))" && files --inputs "$((inputs * 7 / 10))"
}

failed=0
running=()
start() {
  "$@" &
  running+=($!)
}
finish() {
  local one
  for one in "${running[@]}"; do
    wait "$one" || failed=1
  done
  running=()
}

# Two at a time, one for each core of a small machine. An input on the device costs some twenty times as much as one on the
# reference, which costs many times one on the CPU, a stopped one or a file.
if [ "$seconds" -gt 0 ]; then
  priority=19 patience=1200 # other work on the machine may keep an input waiting
  start calls cpu cpu "-max_total_time=$((seconds / 2))"
  start calls reference reference "-max_total_time=$((seconds / 4))"
  wait "${running[1]}" || failed=1
  start calls software software "-max_total_time=$((seconds / 4))"
  finish
  start calls stopped stopped "-max_total_time=$((seconds / 2))"
  start files_for $((seconds / 2))
  finish
else
  start calls cpu cpu-1 -seed=1 "-runs=$((inputs / 20))"
  start calls cpu cpu-2 -seed=2 "-runs=$((inputs / 20))"
  finish
  if [ -z "$only_cpu" ]; then
    start calls software software -seed=1 "-runs=$((inputs / 500))"
    start calls reference reference -seed=1 "-runs=$((inputs / 10))"
    finish
    stopped_and_files || failed=1
  fi
fi
[ $failed -eq 0 ] && echo "Nothing found."
exit $failed
