#!/usr/bin/env bash
# Runs the add-on's tests in several versions of Blender, one after the other, and prints a table.
# Usage: bash tests/versions.sh [--chroot DIR] [VERSION...] [-- pytest's words]
# VERSION: of Blender's Python module, as on the Python package index; "blender" is the installed program without a
# window, "window" with one. Without any: 4.2.23 4.5.15 5.0.1 blender window, and 5.2.3 where --chroot is given.
# Versions from 5.1 on need Python 3.13 and run in a Debian 13 in the folder DIR, which is made if it is missing (by root).
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/support/chroot.sh"

DEFAULTS=(4.2.23 4.5.15 5.0.1)
NEWEST=5.2.3
# Debian 13's packages for Blender's Python module, Mesa's software rasterizer, and the C compiler that the tests ask.
CHROOT_PACKAGES=(python3-venv gcc libc6-dev libgomp1 libx11-6 libxext6 libxrender1 libxxf86vm1 libxi6 libxfixes3 libxkbcommon0 libsm6
  libice6 libgl1 libvulkan1 libegl1 libegl-mesa0 libgl1-mesa-dri)
TESTED=(CMakeLists.txt LICENSE addon native/README.md native/cmake native/include native/src shaders tests blend_samples pyproject.toml README.md)

environments=$root/build/versions
chroot_folder='' asked=() words=() rows=() failures=0

usage() { sed -n '2,7s/^# //p' "${BASH_SOURCE[0]}"; }

while [ $# -gt 0 ]; do
  case $1 in
    --chroot) [ $# -gt 1 ] || fail "--chroot needs a folder."; chroot_folder=$2; shift 2 ;;
    -h | --help) usage; exit 0 ;;
    --) shift; words=("$@"); break ;;
    -*) fail "There is no option $1; see --help." ;;
    *) asked+=("$1"); shift ;;
  esac
done
if [ ${#asked[@]} -eq 0 ]; then
  asked=("${DEFAULTS[@]}" ${chroot_folder:+"$NEWEST"} blender window)
fi

# needs_new_python VERSION: from 5.1 on Blender has Python 3.13.
needs_new_python() { [ "$(printf '%s\n' 5.1 "$1" | sort -V | head -n 1)" = 5.1 ]; }

# record NAME LOG CODE SECONDS: one row of the table, with pytest's last line.
record() {
  local said
  said=$(grep -E '^[0-9]+ (passed|failed|skipped|error)|^(no tests|window:|Fatal)|^paradesc: ' "$2" | tail -n 1)
  [ "$3" -eq 0 ] || failures=$((failures + 1))
  rows+=("$(printf '%-10s %-6s %5d s  %s' "$1" "$([ "$3" -eq 0 ] && echo ok || echo FAILED)" "$4" "${said:-see $2}")")
}

# logged NAME COMMAND...: runs it, shows and keeps its output, and records how it ended.
logged() {
  local name=$1 log=$environments/$1.log start=$SECONDS code
  shift
  echo
  echo "==== $name"
  "$@" </dev/null 2>&1 | tee "$log"
  code=${PIPESTATUS[0]}
  record "$name" "$log" "$code" $((SECONDS - start))
}

# in_module VERSION: the tests with that version of the Python module, in an environment of its own.
in_module() {
  local environment=$environments/$1 base
  if ! "$environment/bin/python" -c 'import bpy, pytest' 2>/dev/null; then
    base=$(find_python) || fail "Python 3.11 with its venv module is missing; Blender $1's module bpy needs that version."
    "$base" -m venv --clear "$environment" &&
      "$environment/bin/python" -m pip install -q --disable-pip-version-check "bpy==$1" "${TEST_REQUIREMENTS[@]}" ||
      fail "pip could not install bpy $1."
  fi
  PYTHONPATH=$root/addon exec "$environment/bin/python" -m pytest -q -p no:cacheprovider --rootdir "$root" \
    "$root/tests/addon" ${words[@]+"${words[@]}"}
}

# in_chroot VERSION: the same in Debian 13, on a copy of what is tested and of the meshes beside it.
in_chroot() {
  local folder=$chroot_folder place=/root/paradesc environment=/root/bpy-$1
  [ -n "$folder" ] || fail "Blender $1 needs Python 3.13; give --chroot DIR, a folder for a Debian 13."
  make_chroot "$folder" "$environments/debootstrap.log" "${CHROOT_PACKAGES[@]}"
  rm -rf "${folder:?}$place"
  mkdir -p "$folder$place"
  (cd "$root" && tar -c --exclude=__pycache__ --exclude=blend_samples/out "${TESTED[@]}") | tar -x -C "$folder$place" ||
    fail "The repository could not be copied into $folder."
  if [ -d "$root/../shared/meshes" ]; then
    mkdir -p "$folder/root/shared"
    cp -rLT "$root/../shared/meshes" "$folder/root/shared/meshes"
  fi
  chroot "$folder" "$environment/bin/python" -c 'import bpy, pytest' 2>/dev/null || {
    in_debian "$folder" python3 -m venv --clear "$environment" &&
      in_debian "$folder" "$environment/bin/python" -m pip install -q --disable-pip-version-check "bpy==$1" \
        "${TEST_REQUIREMENTS[@]}"
  } || fail "pip could not install bpy $1 in $folder."
  mountpoint -q "$folder/proc" || mount -t proc proc "$folder/proc" || fail "/proc could not be mounted in $folder."
  trap 'umount "$chroot_folder/proc"' EXIT
  in_debian "$folder" env PYTHONPATH="$place/addon" "$environment/bin/python" -m pytest -q \
    -p no:cacheprovider --rootdir "$place" "$place/tests/addon" ${words[@]+"${words[@]}"}
}

# in_program: the tests in the installed Blender itself; only pytest comes from an environment beside it.
in_program() {
  local environment=$environments/pytest
  command -v blender >/dev/null || fail "There is no blender here."
  "$environment/bin/python" -c 'import pytest' 2>/dev/null || {
    python3 -m venv --clear "$environment" &&
      "$environment/bin/python" -m pip install -q --disable-pip-version-check "${TEST_REQUIREMENTS[@]}"
  } || fail "pip could not install ${TEST_REQUIREMENTS[*]}."
  exec blender -b --factory-startup --python-exit-code 1 -P "$root/tests/addon/run_in_blender.py" -- \
    "$("$environment/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')" -q ${words[@]+"${words[@]}"}
}

mkdir -p "$environments"
install_packages "${RUN_PACKAGES[@]}" libvulkan1
if [ ! -e "$root/addon/paradesc/lib/libparadesc.so" ]; then
  install_packages "${BUILD_PACKAGES[@]}"
  build_library paradesc
fi
for version in "${asked[@]}"; do
  case $version in
    blender) logged blender in_program ;;
    window) logged window bash "$root/tests/addon/run_in_window.sh" ;;
    *[!0-9.]* | '') fail "\"$version\" is no version of Blender; see --help." ;;
    *) if needs_new_python "$version"; then logged "$version" in_chroot "$version"; else logged "$version" in_module "$version"; fi ;;
  esac
done

echo
echo "==== Add-on's tests by version of Blender"
printf '%s\n' "${rows[@]}"
[ "$failures" -eq 0 ]
