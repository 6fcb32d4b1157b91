#!/usr/bin/env bash
# The native tests as Windows has them: built by Zig and run by Wine on a screen that nobody sees, where WGL reaches this
# machine's software rasterizer. Tests of the reference and of the engine on the CPU alone are left out, because those do not
# depend on the system, and packages/release_test.py compares their bits.
#   bash tests/wine.sh [PATTERN]      GoogleTest's pattern of the tests to run
# tests/release.sh runs it; the library of windows-x64 is built if it is not there.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/support/release_build.sh"

build=$release/windows-x64
logs=$release/wine-tests
on_screen=${PARADESC_ON_SCREEN:-}
pattern=${1:-*:-*/reference:*/cpu}
export WINEPREFIX=$release/wine WINEDEBUG=-all WINEDLLOVERRIDES='mscoree=;mshtml='

# build_tests: the executable, from the objects of which the library is made.
build_tests() {
  [ -f "$build/CMakeCache.txt" ] || { make_tools "$python" && build_release library_windows-x64; }
  echo "Building the tests for Windows"
  { cmake -S "$root" -B "$build" -DPARADESC_TESTS=ON -DGOOGLETEST_SOURCE_DIR=/usr/src/googletest/googletest &&
    cmake --build "$build" --target paradesc_tests; } >"$logs/build.log" 2>&1 || {
    tail -n 40 "$logs/build.log" >&2
    fail "The build failed; all of its output is in $logs/build.log."
  }
}

# half NUMBER: every other test, in one process, which makes each program once.
half() {
  GTEST_TOTAL_SHARDS=2 GTEST_SHARD_INDEX=$1 timeout 3600 "$wine" "$build/paradesc_tests.exe" --gtest_color=no \
    --gtest_filter="$pattern" 2>&1 </dev/null | tr -d '\r' >"$logs/half$1.log"
}

# run_tests: both halves side by side, on one screen. Skipped tests are printed with their reasons; without a device all have failed.
run_tests() {
  local first status=0 all=("$logs/half0.log" "$logs/half1.log")
  wine=$(command -v /usr/lib/wine/wine64 || command -v wine64) || fail "wine64 is not here."
  "$wine" "$build/paradesc_tests.exe" --gtest_list_tests >/dev/null 2>&1 </dev/null # makes Wine's folder, once
  half 0 &
  first=$!
  half 1 || status=1
  wait $first || status=1
  grep -hE '^\[  (PASSED|FAILED) |^\[  SKIPPED \] .* ms\)$' "${all[@]}"
  grep -hA1 ': Skipped$' "${all[@]}" | grep -vE ': Skipped$|^--$' | sort | uniq -c
  if grep -q '^\[  SKIPPED \] WglContext' "${all[@]}"; then
    echo "wine: no OpenGL 4.5 was found, so the device has not been tested" >&2
    status=1
  fi
  [ $status -eq 0 ] || tail -n 20 "${all[@]}"
  return $status
}

if [ -n "$on_screen" ]; then
  run_tests
  exit
fi
install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" wine64 xvfb xauth
mkdir -p "$logs"
build_tests
PARADESC_ON_SCREEN=1 xvfb-run -a bash "$root/tests/wine.sh" "$pattern"
