#!/usr/bin/env bash
# Runs the add-on's tests in several versions of Blender, one after the other, and prints a table.
# Usage: bash tests/versions.sh [--chroot DIR] [VERSION...] [-- pytest's words]
# VERSION: of Blender's Python module, as on the Python package index; "blender" is the installed program without a
# window, "window" with one. Without any: 4.2.23 4.5.15 5.0.1 blender window, and 5.2.3 newer-window where --chroot is given.
# Versions from 5.1 on need Python 3.13 and run in a Debian 13 in the folder DIR, which is made if it is missing (by root);
# "newer-window" is the window of that system's Blender, 4.3.2.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/support/chroot.sh"

DEFAULTS=(4.2.23 4.5.15 5.0.1)
NEWEST=5.2.3
# Debian 13's packages for Blender's Python module, Mesa's software rasterizer, and the C compiler that the tests ask.
CHROOT_PACKAGES=(python3-venv gcc libc6-dev libgomp1 libx11-6 libxext6 libxrender1 libxxf86vm1 libxi6 libxfixes3 libxkbcommon0 libsm6
  libice6 libgl1 libvulkan1 libegl1 libegl-mesa0 libgl1-mesa-dri)
# And for a window of its own Blender, whose picture xwd takes.
WINDOW_PACKAGES=(blender python3-numpy xvfb xauth x11-apps)
TESTED=(CMakeLists.txt LICENSE addon native/README.md native/cmake native/include native/src shaders tests blend_samples pyproject.toml README.md)

environments=$root/build/versions
place=/root/paradesc # in the Debian 13
chroot_folder='' asked=() words=() rows=() failures=0

usage() { sed -n '2,8s/^# //p' "${BASH_SOURCE[0]}"; }

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
  asked=("${DEFAULTS[@]}" ${chroot_folder:+"$NEWEST" newer-window} blender window)
fi

# needs_new_python VERSION: from 5.1 on Blender has Python 3.13.
needs_new_python() { [ "$(printf '%s\n' 5.1 "$1" | sort -V | head -n 1)" = 5.1 ]; }

# record NAME LOG CODE SECONDS: one row of the table, with pytest's last line.
record() {
  local said
  said=$(grep -E '^[0-9]+ (passed|failed|skipped|error)|^(no tests|window:|panel:|Fatal)|^paradesc: ' "$2" | tail -n 1)
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

# copy_to_chroot NAME PACKAGE...: a Debian 13 with these packages, with a copy of what is tested and of the meshes beside it.
copy_to_chroot() {
  local name=$1 folder=$chroot_folder
  shift
  [ -n "$folder" ] || fail "Blender $name needs another system; give --chroot DIR, a folder for a Debian 13."
  make_chroot "$folder" "$environments/debootstrap.log" "$@"
  rm -rf "${folder:?}$place"
  mkdir -p "$folder$place"
  (cd "$root" && tar -c --exclude=__pycache__ --exclude=blend_samples/out "${TESTED[@]}") | tar -x -C "$folder$place" ||
    fail "The repository could not be copied into $folder."
  if [ -d "$root/../shared/meshes" ]; then
    mkdir -p "$folder/root/shared"
    cp -rLT "$root/../shared/meshes" "$folder/root/shared/meshes"
  fi
  mountpoint -q "$folder/proc" || mount -t proc proc "$folder/proc" || fail "/proc could not be mounted in $folder."
  trap 'umount "$chroot_folder/proc"' EXIT
}

# in_chroot VERSION: the tests with that version of the Python module in Debian 13.
in_chroot() {
  local folder=$chroot_folder environment=/root/bpy-$1
  copy_to_chroot "$1" "${CHROOT_PACKAGES[@]}"
  chroot "$folder" "$environment/bin/python" -c 'import bpy, pytest' 2>/dev/null || {
    in_debian "$folder" python3 -m venv --clear "$environment" &&
      in_debian "$folder" "$environment/bin/python" -m pip install -q --disable-pip-version-check "bpy==$1" \
        "${TEST_REQUIREMENTS[@]}"
  } || fail "pip could not install bpy $1 in $folder."
  in_debian "$folder" env PYTHONPATH="$place/addon" "$environment/bin/python" -m pytest -q \
    -p no:cacheprovider --rootdir "$place" "$place/tests/addon" ${words[@]+"${words[@]}"}
}

# in_newer_window: what tests/run.sh does in a window, in that of Debian 13's Blender.
in_newer_window() {
  copy_to_chroot newer-window "${CHROOT_PACKAGES[@]}" "${WINDOW_PACKAGES[@]}"
  in_debian "$chroot_folder" bash -c "cd $place && blender --version | head -n 1 && bash tests/addon/run_in_window.sh &&
    bash tests/addon/run_in_window.sh '' live_in_window.py && bash tests/addon/run_in_window.sh '' shown_in_window.py &&
    bash tests/addon/run_in_window.sh '' image_in_window.py &&
    bash tests/addon/run_in_window.sh '' coexist_in_window.py &&
    bash tests/addon/first_click.sh"
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
    newer-window) logged newer-window in_newer_window ;;
    window) logged window bash "$root/tests/addon/run_in_window.sh" ;;
    *[!0-9.]* | '') fail "\"$version\" is no version of Blender; see --help." ;;
    *) if needs_new_python "$version"; then logged "$version" in_chroot "$version"; else logged "$version" in_module "$version"; fi ;;
  esac
done

echo
echo "==== Add-on's tests by version of Blender"
printf '%s\n' "${rows[@]}"
[ "$failures" -eq 0 ]
