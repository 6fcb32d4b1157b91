#!/usr/bin/env bash
# The second command: installs what is needed, builds everything, and runs all tests: the native ones, 100,000 fuzzed inputs, the
# add-on's in Blender's Python module, then the same in Blender's own executable, without and with a window.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"

install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${TEST_PACKAGES[@]}"
make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}"
build_library
site_packages=$("$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')

passed=() failed=() skipped=()

# step NAME COMMAND...: runs it and remembers how it ended.
step() {
  local name=$1 start=$SECONDS
  shift
  echo
  echo "==== $name"
  if "$@" </dev/null; then
    passed+=("$name ($((SECONDS - start)) s)")
  else
    failed+=("$name (exit $?)")
  fi
}

step "native tests" ctest --test-dir "$root/build" --output-on-failure --no-tests=error -j "$(nproc)"
step "structure" "$python" -m pytest -q --rootdir "$root" "$root/tests/structure"
step "fuzzing" bash "$root/tests/fuzz.sh"
step "add-on in the Python module" "$python" -m pytest -q --rootdir "$root" "$root/tests/addon"
if command -v blender >/dev/null; then
  step "add-on in $(blender --version 2>/dev/null | head -n 1)" \
    blender -b --factory-startup -P "$root/tests/addon/run_in_blender.py" -- "$site_packages" -q
else
  skipped+=("add-on in Blender itself: there is no blender here")
fi
if command -v blender >/dev/null && command -v xvfb-run >/dev/null; then
  step "add-on in Blender's window" bash "$root/tests/addon/run_in_window.sh"
  step "live values in Blender's window" bash "$root/tests/addon/run_in_window.sh" "" live_in_window.py
  step "bakes beside a window that draws" bash "$root/tests/addon/run_in_window.sh" "" coexist_in_window.py
else
  skipped+=("add-on in Blender's window: blender or xvfb-run is not here")
fi

echo
echo "==== Summary"
[ ${#passed[@]} -eq 0 ] || printf 'passed   %s\n' "${passed[@]}"
[ ${#skipped[@]} -eq 0 ] || printf 'skipped  %s\n' "${skipped[@]}"
[ ${#failed[@]} -eq 0 ] || printf 'FAILED   %s\n' "${failed[@]}"
echo "suites: ${#passed[@]} passed, ${#failed[@]} failed, ${#skipped[@]} skipped"
[ ${#failed[@]} -eq 0 ]
