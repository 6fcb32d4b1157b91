#!/usr/bin/env bash
# Which lines the tests run: native/src by gcov, the add-on by coverage.py; fails below 90 and 85 per cent.
# Usage: bash tests/coverage.sh [--build FOLDER] [--leave-out TESTS] [--addon "PYTEST WORDS"] [--only native|addon]
# TESTS: native ones, as GoogleTest's filter has them, e.g. 'IrregularSurface*:Parity*'. Each suite is a process of its own,
# so that one that fails or takes longer than PARADESC_SUITE_SECONDS (600) loses no counts but its own.
# What is left out: generated shader text, OpenMesh, stb and other headers from outside, gpu/no_egl.cpp (systems without
# EGL), and lines that the comments LCOV_EXCL_LINE or "pragma: no cover" mark.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"

build=$root/build/coverage left_out='' words='' only='' patience=${PARADESC_SUITE_SECONDS:-600}
while [ $# -gt 0 ]; do
  case $1 in
    --build) build=$2; shift 2 ;;
    --leave-out) left_out=$2; shift 2 ;;
    --addon) words=$2; shift 2 ;;
    --only) only=$2; shift 2 ;;
    *) sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}"; exit 2 ;;
  esac
done
code=0
python=${PARADESC_PYTHON:-$python}
if [ "$python" = "$root/.venv/bin/python" ]; then
  install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${TEST_PACKAGES[@]}"
  make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}"
fi
mkdir -p "$build"
tools=$build/tools
[ -d "$tools/coverage" ] || "$python" -m pip install -q --disable-pip-version-check --target "$tools" gcovr coverage ||
  fail "pip could not install gcovr and coverage."

native() {
  local launcher=()
  ! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DPARADESC_COVERAGE=ON "${launcher[@]}" >"$build/build.log" || return 1
  cmake --build "$build" --target paradesc_tests >>"$build/build.log" 2>&1 || { tail -n 30 "$build/build.log"; return 1; }
  find "$build" -name '*.gcda' -delete
  : >"$build/suites.txt"
  local suite ended start
  while read -r suite; do
    start=$SECONDS
    timeout "$patience" "$build/paradesc_tests" --gtest_brief=1 --gtest_filter="${suite}*${left_out:+:-$left_out}" >"$build/suite.log" 2>&1
    ended=$?
    echo "$suite $((SECONDS - start)) s" >>"$build/suites.txt"
    [ $ended -eq 0 ] || { echo "$suite ended with $ended"; tail -n 5 "$build/suite.log"; code=1; }
  done < <("$build/paradesc_tests" --gtest_list_tests --gtest_filter="*${left_out:+:-$left_out}" | grep -E '^[^ ].*\.( |$)' | sed 's/\..*/./' | sort -u)
  report_native
}

# Below the share it fails.
report_native() {
  PYTHONPATH=$tools "$python" -m gcovr --root "$root" --object-directory "$build" --filter "$root/native/src/" \
    --exclude '.*/no_egl\.cpp' --gcov-ignore-errors=all --gcov-ignore-parse-errors=all --merge-mode-functions=separate \
    --exclude-throw-branches --sort uncovered-number --json-summary "$build/native.json" --txt "$build/native.txt" \
    --fail-under-line 90
  local ended=$?
  cat "$build/native.txt"
  return $ended
}

addon() {
  # shellcheck disable=SC2086
  (cd "$root" && PYTHONPATH=$root/addon:$tools "$python" -m coverage run --data-file "$build/addon.data" --source addon/paradesc \
    --concurrency thread -m pytest -q --rootdir "$root" -p no:cacheprovider ${words:-tests/addon}) || code=1
  PYTHONPATH=$tools "$python" -m coverage report --data-file "$build/addon.data" --skip-covered --sort=-miss \
    --fail-under 85 || code=1
}

[ "$only" = addon ] || native || code=1
[ "$only" = native ] || addon
exit $code
