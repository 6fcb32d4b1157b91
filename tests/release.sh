#!/usr/bin/env bash
# Builds the release packages for all systems from this one, and tests what users get: exports and needs of each library, the
# same bits under Wine and on other processors under QEMU, and the add-on's own tests with the Linux one. The packages stay in
# build/release/packages.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/support/foreign.sh"

ZIG_PACKAGE=ziglang==0.17.1 # a C++ compiler for all of them, with their C and C++ libraries
LIEF_PACKAGE=lief==1.0.0    # reads ELF, PE and Mach-O
release=$root/build/release
tools=$root/build/release-tools

# get_openmesh: the source of this system's OpenMesh.
get_openmesh() {
  local folder=$tools/openmesh
  openmesh=$(find "$folder" -maxdepth 1 -type d -name 'OpenMesh-*' 2>/dev/null | head -n 1)
  [ -z "$openmesh" ] || return 0
  command -v apt-get >/dev/null || fail "OpenMesh's source is got by apt; elsewhere unpack OpenMesh 9 into $folder/OpenMesh-9."
  get_package "$(. /etc/os-release && echo "$VERSION_CODENAME")" deb-src openmesh "$folder"
  tar -xf "$folder"/openmesh_*.orig.tar.* -C "$folder"
  openmesh=$(find "$folder" -maxdepth 1 -type d -name 'OpenMesh-*' | head -n 1)
}

install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" "${TEST_PACKAGES[@]}" wine64 qemu-user-static libc6-arm64-cross
make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}"
"$tools/bin/python" -c 'import lief, pytest, ziglang' 2>/dev/null || {
  "$python" -m venv "$tools" && "$tools/bin/pip" install -q "$ZIG_PACKAGE" "$LIEF_PACKAGE" "${TEST_REQUIREMENTS[@]}"
} || fail "pip could not install $ZIG_PACKAGE and $LIEF_PACKAGE into $tools."
zig=$("$tools/bin/python" -c 'import ziglang, pathlib; print(pathlib.Path(ziglang.__file__).with_name("zig"))')
get_openmesh

[ -f "$root/build/libparadesc.so" ] || build_library paradesc # by this system's compiler, to compare with

echo "Building for Linux, Windows and macOS (the first time about 18 minutes of one core: Zig builds a C++ library for each)"
mkdir -p "$release"
{ cmake -S "$root" -B "$release" -G Ninja -DCMAKE_BUILD_TYPE=Release -DPARADESC_TESTS=OFF -DPARADESC_ZIG="$zig" \
  -DOPENMESH_SOURCE_DIR="$openmesh" && cmake --build "$release" --target package_addon; } >"$release/build.log" 2>&1 || {
  tail -n 40 "$release/build.log" >&2
  fail "The build failed; all of its output is in $release/build.log."
}
tail -n 8 "$release/build.log"

status=0
export PARADESC_RELEASE=$release PARADESC_OTHER_LIBRARY=$root/build/libparadesc.so
"$tools/bin/python" -m pytest -q -s -p no:cacheprovider --rootdir "$root" -o testpaths= \
  "$root/tests/packages/release_test.py" || status=1

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
