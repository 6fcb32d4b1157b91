#!/usr/bin/env bash
# Which lines the tests run: native/src by gcov, the add-on by coverage.py; fails below 90 and 85 per cent.
# Usage: bash tests/coverage.sh [--build FOLDER] [--leave-out TESTS] [--addon "PYTEST WORDS"] [--only native|addon]
# TESTS: native ones, as GoogleTest's filter has them, e.g. 'IrregularSurface*:Parity*'. Each suite is a process of its own, as many
# at a time as there are cores, so that one that fails or takes longer than PARADESC_SUITE_SECONDS (1800) loses no counts but its own.
# Not counted: generated shader text, OpenMesh, stb and other headers from outside, engine/paper/no_context.cpp and wgl_context.cpp
# (other systems), and lines that the comments LCOV_EXCL_LINE or "pragma: no cover" mark.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"

build=$root/build/coverage left_out='' words='' only='' patience=${PARADESC_SUITE_SECONDS:-1800}
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
  rm -rf "$build/suites"
  mkdir "$build/suites"
  "$build/paradesc_tests" --gtest_list_tests --gtest_filter="*${left_out:+:-$left_out}" | grep -E '^[^ ].*\.( |$)' | sed 's/\..*/./' |
    sort -u | xargs -P "$(nproc)" -I SUITE bash -c 'suite "$@"' _ SUITE "$build" "$patience" "$left_out"
  if grep -hs . "$build"/suites/*failed; then code=1; fi
  report_native
}

# suite NAME BUILD SECONDS LEFT_OUT: one suite, beside others; counts of processes that end at once are added one after the other.
suite() {
  local name=$1 log=$2/suites/${1}log ended
  timeout "$3" "$2/paradesc_tests" --gtest_brief=1 --gtest_filter="${name}*${4:+:-$4}" >"$log" 2>&1
  ended=$?
  [ $ended -eq 0 ] || { echo "$name ended with $ended" && tail -n 5 "$log"; } >"$2/suites/${name}failed"
}
export -f suite

# Below the share it fails. Lines of a template count once, not once an instance.
report_native() {
  PYTHONPATH=$tools "$python" -m gcovr --root "$root" --object-directory "$build" --filter "$root/native/src/" \
    --exclude '.*/(no|wgl)_context\.cpp' --gcov-ignore-errors=all --gcov-ignore-parse-errors=all --gcov-suspicious-hits-threshold=0 \
    --merge-mode-functions=separate --merge-lines --exclude-throw-branches --sort uncovered-number \
    --json-summary "$build/native.json" --txt "$build/native.txt" \
    --fail-under-line 90
  local ended=$?
  cat "$build/native.txt"
  return $ended
}

addon() {
  [ -f "$root/addon/paradesc/lib/libparadesc.so" ] || build_library paradesc
  # shellcheck disable=SC2086
  (cd "$root" && PYTHONPATH=$root/addon:$tools "$python" -m coverage run --data-file "$build/addon.data" --source addon/paradesc,addon/paradesc_blender \
    --concurrency thread -m pytest -q --rootdir "$root" -p no:cacheprovider ${words:-tests/addon}) || code=1
  PYTHONPATH=$tools "$python" -m coverage report --data-file "$build/addon.data" --skip-covered --sort=-miss \
    --fail-under 85 || code=1
}

[ "$only" = addon ] || native || code=1
[ "$only" = native ] || addon
exit $code
