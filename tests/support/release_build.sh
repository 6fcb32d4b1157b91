# Sourced, after blend_samples/setup.sh: builds the libraries of a release for all systems from this one, by Zig.
# Sets release and tools (folders of the builds and of the Python that has what they need).
source "$root/tests/support/foreign.sh"

ZIG_PACKAGE=ziglang==0.17.1 # a C++ compiler for all of them, with their C and C++ libraries
LIEF_PACKAGE=lief==1.0.0    # reads ELF, PE and Mach-O
release=$root/build/release
tools=$root/build/release-tools

# make_tools BASE PACKAGE...: the environment of the tools, by the Python BASE, with these packages besides.
make_tools() {
  local base=$1 stamp=$tools/packages.txt
  local packages=("$ZIG_PACKAGE" "$LIEF_PACKAGE" "${TEST_REQUIREMENTS[@]}" "${@:2}")
  [ -x "$tools/bin/python" ] || "$base" -m venv "$tools" || fail "$base could not make the environment $tools."
  printf '%s\n' "${packages[@]}" | grep -qvxFf <(cat "$stamp" 2>/dev/null) || return 0
  "$tools/bin/python" -m pip install -q --disable-pip-version-check "${packages[@]}" ||
    fail "pip could not install ${packages[*]} into $tools."
  printf '%s\n' "${packages[@]}" >>"$stamp"
}

# get_openmesh: the source of this system's OpenMesh.
get_openmesh() {
  local folder=$tools/openmesh
  openmesh=$(find "$folder" -maxdepth 1 -type d -name 'OpenMesh-*' 2>/dev/null | head -n 1)
  [ -z "$openmesh" ] || return 0
  command -v apt-get >/dev/null || fail "OpenMesh's source is got by apt; elsewhere unpack OpenMesh 9 into $folder/OpenMesh-9."
  get_package "$(. /etc/os-release && echo "$VERSION_CODENAME")" deb-src "$folder" openmesh
  tar -xf "$folder"/openmesh_*.orig.tar.* -C "$folder"
  openmesh=$(find "$folder" -maxdepth 1 -type d -name 'OpenMesh-*' | head -n 1)
}

# build_release TARGET: of native/cmake/package.cmake, with a library a platform.
build_release() {
  local zig openmesh
  zig=$("$tools/bin/python" -c 'import ziglang, pathlib; print(pathlib.Path(ziglang.__file__).with_name("zig"))')
  get_openmesh
  echo "Building for Linux, Windows and macOS (the first time about 28 minutes of one core: Zig builds a C++ library for each)"
  mkdir -p "$release"
  { cmake -S "$root" -B "$release" -G Ninja -DCMAKE_BUILD_TYPE=Release -DPARADESC_TESTS=OFF -DPARADESC_ZIG="$zig" \
    -DOPENMESH_SOURCE_DIR="$openmesh" && cmake --build "$release" --target "$1"; } >"$release/build.log" 2>&1 || {
    tail -n 40 "$release/build.log" >&2
    fail "The build failed; all of its output is in $release/build.log."
  }
}
