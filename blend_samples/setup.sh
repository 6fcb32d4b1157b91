# Sourced by bake.sh and tests/run.sh: packages, Python environment and native library. Everything is skipped that is there.
# Sets root (the repository) and python (the environment's interpreter).

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
python=$root/.venv/bin/python

BUILD_PACKAGES=(build-essential cmake ninja-build libopenmesh-dev libglm-dev libstb-dev libegl-dev libgl-dev libgtest-dev)
# Mesa's software rasterizer, reached through EGL; then what Blender's Python module links.
RUN_PACKAGES=(libegl1 libegl-mesa0 libgl1-mesa-dri python3-venv
  libgl1 libx11-6 libxext6 libxrender1 libxxf86vm1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6 libgomp1)
# Blender itself, its numpy, and a screen for it that nobody has to see.
TEST_PACKAGES=(blender glslang-tools python3-numpy xvfb xauth)
# markdown: packages contain the manual as web pages; scikit-build-core: makes the wheel that an extension contains
REQUIREMENTS=(bpy==4.2.23 numpy==1.26.4 markdown==3.11.3 scikit-build-core==1.1.2)
# lizard: finds functions of C++ and GLSL, whose lengths are tested; trimesh: a peer, and maker of mesh files; scikit-build-core:
# packs the wheel; openjd-cli, distributed and dukpy (a JavaScript engine): what job descriptions and farms are tried with; mypy: types of
# the Python package; the rest, from pillow on: what notebooks and the manual's Python code need
TEST_REQUIREMENTS=(pytest==8.4.2 lizard==1.24.3 trimesh==5.2.0 scikit-build-core==1.1.2 openjd-cli==0.8.0 distributed==2026.8.0 dukpy==0.6.0
  mypy==2.4.1 pillow==13.0.0 pyvista==0.49.1 vtk==9.7.2 matplotlib==3.11.2 nbclient==0.11.0 nbformat==5.11.1 ipykernel==7.4.0 nibabel==5.4.2 click==8.5.1
  openimageio==3.0.21.0) # later ones need numpy 2, which Blender 4.2 has not
mapfile -t SITE_REQUIREMENTS <"$root/addon/site/requirements.txt"

fail() {
  echo "paradesc: $*" >&2
  exit 1
}

# install_packages NAME...: Debian packages that are missing, by apt; elsewhere one sentence says what is missing.
install_packages() {
  local name missing=() as_root=()
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    for name in c++ cmake ninja; do
      command -v "$name" >/dev/null || missing+=("$name")
    done
    [ ${#missing[@]} -eq 0 ] || fail "This is no Debian system; please install ${missing[*]} (a compiler for C++20, CMake," \
      "Ninja), OpenMesh 9, GLM, stb, GoogleTest and Mesa's EGL yourself, then run this again."
    return 0
  fi
  for name in "$@"; do
    dpkg-query -W -f='${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || missing+=("$name")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "These packages are missing and only root can install them: ${missing[*]}."
    as_root=(sudo)
  fi
  echo "Installing ${missing[*]}"
  "${as_root[@]}" apt-get update -q </dev/null >/dev/null || true
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}" \
    </dev/null >/dev/null || fail "apt-get could not install ${missing[*]}."
}

# python_that CODE CANDIDATE...: the first of these interpreters in which the code ends well.
python_that() {
  local code=$1 candidate
  shift
  for candidate in "$@"; do
    if "$candidate" -c "$code" 2>/dev/null; then
      echo "$candidate"
      return 0
    fi
  done
  return 1
}

# Blender 4.2's Python module exists for Python 3.11 alone.
find_python() {
  python_that 'import ensurepip, sys; sys.exit(sys.version_info[:2] != (3, 11))' python3 python3.11 /usr/bin/python3.11
}

# make_environment REQUIREMENT...: .venv with these packages and with addon/ on its path.
make_environment() {
  local base stamp="$root/.venv/requirements.txt" packages
  if ! "$python" -c '' 2>/dev/null; then
    base=$(find_python) || fail "Python 3.11 with its venv module is missing; Blender 4.2's module bpy needs that very version."
    "$base" -m venv --clear "$root/.venv" || fail "Python could not make the environment $root/.venv."
  fi
  if ! printf '%s\n' "$@" | cmp -s - "$stamp"; then
    echo "Installing $* into .venv"
    "$python" -m pip install -q --disable-pip-version-check "$@" || fail "pip could not install $*."
    printf '%s\n' "$@" >"$stamp"
  fi
  packages=$("$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
  echo "$root/addon" >"$packages/paradesc.pth"
}

# build_library TARGET...: all targets without one. The library lands in addon/paradesc/lib.
build_library() {
  local log=$root/build/build.log
  mkdir -p "$root/build"
  echo "Building${*:+ $*}"
  if ! { cmake -S "$root" -B "$root/build" -G Ninja -DCMAKE_BUILD_TYPE=Release &&
    cmake --build "$root/build" ${1:+--target "$@"}; } >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    fail "The build failed; all of its output is in $log."
  fi
}
