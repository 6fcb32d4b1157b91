#!/usr/bin/env bash
# Fuzzes the C interface on the reference and on the software backend, and what the add-on reads from files.
#   bash tests/fuzz.sh                 the inputs that found something once, then 100,000 new ones, about two minutes
#   bash tests/fuzz.sh --inputs N      so many new ones
#   bash tests/fuzz.sh --hours H       as many as fit, at the lowest priority; what is new is kept in build/fuzz/corpus
# What is found lies in build/fuzz/findings, with the command that repeats it on the screen.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/sanitizers/build.sh"

inputs=100000 seconds=0 pass=1
while [ $# -gt 0 ]; do
  case "$1 ${2:-}" in
  "--inputs "[1-9]*) inputs=$2 ;;
  "--hours "[0-9.]*) seconds=$(awk -v hours="$2" 'BEGIN { print int(hours * 3600) }') ;;
  *) fail "usage: bash tests/fuzz.sh [--inputs N | --hours H]" ;;
  esac
  shift 2
done

install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${CLANG_PACKAGES[@]}"
[ -x "$python" ] || make_environment "${REQUIREMENTS[@]}"
folder=$root/build/fuzz
mkdir -p "$folder/findings" "$folder/corpus/reference" "$folder/corpus/software"
build_with_clang "$folder" "-O2 -gline-tables-only" "paradesc_fuzz_reference paradesc_fuzz_software" -DPARADESC_FUZZ=ON -DPARADESC_TESTS=OFF

# Mesa keeps what it makes until the process ends, and its threads outlive it.
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=0 UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$root/tests/sanitizers/leaks.txt:print_suppressions=0
failed=0

# fuzz BACKEND INPUTS SECONDS: first everything of the corpus once, then new inputs until one of the limits (0: none).
fuzz() {
  local backend=$1 log=$folder/$1.log
  local options=(-max_len=1024 -len_control=0 -entropic=0 -rss_limit_mb=4096 -timeout=60 -reload=0 -print_final_stats=1 -verbosity=1
    "-artifact_prefix=$folder/findings/$backend-")
  [ "$2" -eq 0 ] || options+=("-runs=$2")
  [ "$3" -eq 0 ] || options+=("-max_total_time=$3")
  "${nice[@]}" "$folder/paradesc_fuzz_$backend" "${options[@]}" "$folder/corpus/$backend" "$root/tests/fuzz/corpus/$backend" >"$log" 2>&1
  local status=$?
  echo "$backend: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs," \
    "$(sed -n 's/^Done .* in \(.*\) second.*/\1 s/p' "$log")"
  if [ $status -ne 0 ]; then
    failed=1
    grep -vE "^#[0-9]+\s|NEW_FUNC" "$log" | tail -n 40
    echo "$backend: FOUND SOMETHING (exit $status). Again: $folder/paradesc_fuzz_$backend $(ls -t "$folder"/findings/"$backend"-* 2>/dev/null | head -n 1)"
  fi
}

# Of 20 inputs one takes the way over a device, which costs a hundred times as much; half are files.
nice=(nice)
if [ "$seconds" -gt 0 ]; then
  nice=(nice -n 19)
  fuzz reference 0 $((seconds / 2)) &
  first=$!
  fuzz software 0 $((seconds / 2)) # the two at once, where there are two cores
  software=$failed
  wait $first || failed=1
  [ "$software" -eq 0 ] || failed=1
  end=$((SECONDS + seconds / 2))
  while [ $SECONDS -lt $end ] && [ $failed -eq 0 ]; do
    PYTHONPATH=$root/addon "${nice[@]}" "$python" "$root/tests/fuzz/readers.py" --inputs 200000 --seed $((pass++)) || failed=1
  done
else
  fuzz reference $((inputs * 49 / 100)) 0
  fuzz software $((inputs / 100)) 0
  PYTHONPATH=$root/addon "$python" "$root/tests/fuzz/readers.py" --inputs $((inputs / 2)) || failed=1
fi
[ $failed -eq 0 ] && echo "Nothing found."
exit $failed
