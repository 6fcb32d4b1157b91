#!/usr/bin/env bash
# Builds the release packages for all systems from this one, and tests what users get: exports and needs of each library, the
# same bits under Wine and on other processors under QEMU, the native tests under Wine, and the add-on's own tests with the Linux one. The packages stay in
# build/release/packages.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/support/release_build.sh"

install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${TEST_PACKAGES[@]}" wine64 qemu-user-static libc6-arm64-cross
make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}"
make_tools "$python"

[ -f "$root/build/libparadesc.so" ] || build_library paradesc # by this system's compiler, to compare with

build_release package_addon
tail -n 8 "$release/build.log"

status=0
export PARADESC_RELEASE=$release PARADESC_OTHER_LIBRARY=$root/build/libparadesc.so
"$tools/bin/python" -m pytest -q -s -p no:cacheprovider --rootdir "$root" -o testpaths= \
  "$root/tests/packages/release_test.py" || status=1

bash "$root/tests/wine.sh" || status=1 # the native tests on Windows' way to a device

# The add-on's own tests, with the library that lies in the zips, and those zips installed.
lib=$root/addon/paradesc/lib
kept=$(mktemp -d)
mkdir -p "$lib"
mv "$lib"/* "$kept" 2>/dev/null
trap 'rm -f "$lib"/*; mv "$kept"/* "$lib" 2>/dev/null; rmdir "$kept"' EXIT
cp "$release/linux-x64/libparadesc.so" "$lib"
"$python" -m pytest -q --rootdir "$root" "$root/tests/addon" "$@" || status=1
if command -v blender >/dev/null; then
  site_packages=$("$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
  blender -b --factory-startup --python-exit-code 1 -P "$root/tests/addon/run_in_blender.py" -- "$site_packages" -q "$@" || status=1
fi
[ $status -eq 0 ] && echo "release: all passed" || echo "release: FAILED"
exit $status
