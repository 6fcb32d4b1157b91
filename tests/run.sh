#!/usr/bin/env bash
# The second command: installs what is needed, builds everything, and runs all tests: the native ones, 20,000 fuzzed inputs, the
# add-on's in Blender's Python module, then the same in Blender's own executable, without and with a window.
#   bash tests/run.sh --quick    builds, then only what is fast of the native tests and of the add-on's in the Python module
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"

case "$*" in "" | --quick) ;; *) fail "usage: bash tests/run.sh [--quick]" ;; esac
install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${TEST_PACKAGES[@]}"
make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}" "${SITE_REQUIREMENTS[@]}"
build_library
site_packages=$("$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')

passed=() failed=() skipped=() logs=()
mkdir -p "$root/build/suites"

# step NAME COMMAND...: runs it, keeps a copy of its words, and remembers how it ended.
step() {
  local name=$1 start=$SECONDS log="$root/build/suites/${1//[^A-Za-z0-9]/_}.log" status=0
  shift
  echo
  echo "==== $name"
  { "$@" </dev/null; } > >(tee "$log") 2>&1 || status=$?
  wait $! # for the copy
  if [ $status -eq 0 ]; then
    passed+=("$name ($((SECONDS - start)) s)")
  else
    failed+=("$name (exit $status)")
    logs+=("$log")
  fi
}

# summary: the last words of steps that failed, and how all ended; its own status is that of all of them.
summary() {
  local log
  for log in ${logs[@]+"${logs[@]}"}; do
    echo
    echo "==== The end of ${log#"$root/"}"
    tail -n 25 "$log"
  done
  echo
  echo "==== Summary"
  [ ${#passed[@]} -eq 0 ] || printf 'passed   %s\n' "${passed[@]}"
  [ ${#skipped[@]} -eq 0 ] || printf 'skipped  %s\n' "${skipped[@]}"
  [ ${#failed[@]} -eq 0 ] || printf 'FAILED   %s\n' "${failed[@]}"
  echo "suites: ${#passed[@]} passed, ${#failed[@]} failed, ${#skipped[@]} skipped"
  [ ${#failed[@]} -eq 0 ]
}

# start_native FILTER: starts the native tests in two processes, every other test in each: a process makes each program once, and
# knows what its earlier tests expected.
halves=() half_logs=("$root/build/suites/first.log" "$root/build/suites/second.log")
start_native() {
  local i
  for i in 0 1; do
    GTEST_TOTAL_SHARDS=2 GTEST_SHARD_INDEX=$i "$root/build/paradesc_tests" --gtest_brief=1 --gtest_filter="$1" \
      >"${half_logs[i]}" 2>&1 </dev/null &
    halves+=($!)
  done
  trap 'kill $(jobs -p) 2>/dev/null' EXIT # of what an interrupt leaves behind
}

end_native() {
  step "native tests, one half" ended "${halves[0]}" "${half_logs[0]}"
  step "native tests, the other half" ended "${halves[1]}" "${half_logs[1]}"
}

# ended PROCESS LOG: waits for native tests, and shows their last words, or all of them if they failed or there were none.
ended() {
  local status=0
  wait "$1" || status=$?
  if [ $status -eq 0 ] && grep '^\[  PASSED  \] [1-9]' "$2"; then return 0; fi
  cat "$2"
  return $((status ? status : 1))
}

# shown PROCESS LOG: waits for it, and shows what it wrote; its status is that of the process.
shown() {
  local status=0
  wait "$1" || status=$?
  cat "$2"
  return $status
}

# quick: the fast tests, all side by side. The longest are waited for last.
quick() {
  start_native "-$(sed '/^#/d' "$root/tests/slow_native.txt" | paste -sd:)"
  step "structure" "$python" -m pytest -q --rootdir "$root" "$root/tests/structure"
  step "add-on in the Python module" "$python" -m pytest -q -m "not slow" --rootdir "$root" "$root/tests/addon"
  end_native
  skipped+=("slow tests, fuzzing, Blender itself: bash tests/run.sh has them")
}

if [ "${1:-}" = --quick ]; then
  quick
  summary
  exit
fi

start_native "*"
end_native
step "structure" "$python" -m pytest -q --rootdir "$root" "$root/tests/structure"
step "fuzzing" bash "$root/tests/fuzz.sh" --inputs 20000
# Either of these keeps about one core busy.
"$python" -m pytest -q --rootdir "$root" "$root/tests/addon" >"$root/build/suites/module.log" 2>&1 </dev/null &
module=$!
if command -v blender >/dev/null; then
  step "add-on in $(blender --version 2>/dev/null | head -n 1), beside the Python module" \
    blender -b --factory-startup --python-exit-code 1 -P "$root/tests/addon/run_in_blender.py" -- "$site_packages" -q
else
  skipped+=("add-on in Blender itself: there is no blender here")
fi
step "add-on in the Python module, the rest of it" shown $module "$root/build/suites/module.log"
if command -v blender >/dev/null && command -v xvfb-run >/dev/null; then
  step "add-on in Blender's window" bash "$root/tests/addon/run_in_window.sh"
  step "live values in Blender's window" bash "$root/tests/addon/run_in_window.sh" "" live_in_window.py
  step "what viewports show in Blender's window" bash "$root/tests/addon/run_in_window.sh" "" shown_in_window.py
  step "textures in Blender's window" bash "$root/tests/addon/run_in_window.sh" "" image_in_window.py
  step "bakes beside a window that draws" bash "$root/tests/addon/run_in_window.sh" "" coexist_in_window.py
  step "the first click in Blender's window" bash "$root/tests/addon/first_click.sh"
else
  skipped+=("add-on in Blender's window: blender or xvfb-run is not here")
fi

summary
