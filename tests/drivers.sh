#!/usr/bin/env bash
# Tries OpenGL drivers that this machine has no card for, prints a table of them, and ends with 1 where anything fails.
# Usage: bash tests/drivers.sh [--chroot DIR] [--page] [DRIVER...]
# DRIVER: any of texts llvmpipe llvmpipe-25 zink card amd; without any all but card, of these without --chroot those that need none.
#   texts        every shader text of every variant, through Khronos' compiler to SPIR-V, and through SPIR-V's validator
#   llvmpipe     all tests of devices on this system's software rasterizer
#   llvmpipe-25  the same on Debian 13's, in the folder DIR, where a Debian 13 is made if it is missing (by root)
#   zink         the same on OpenGL over Vulkan there
#   card         the same on this machine's graphics card, only where it is asked for
#   amd          all programs compiled for three of AMD's cards that are not there, with the registers that they take
# --page writes what was found into tests/DRIVERS.md.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
source "$root/tests/support/chroot.sh"

# Debian 13's drivers: Mesa's software rasterizer, Vulkan by it, and AMD's without a card.
CHROOT_PACKAGES=(libegl1 libegl-mesa0 libgl1-mesa-dri libvulkan1 mesa-vulkan-drivers mesa-drm-shim)
folder=$root/build/drivers
chroot_folder='' words=()

usage() { sed -n '2,12s/^# //p' "${BASH_SOURCE[0]}"; }

while [ $# -gt 0 ]; do
  case $1 in
    --chroot) [ $# -gt 1 ] || fail "--chroot needs a folder."; chroot_folder=$2; shift 2 ;;
    -h | --help) usage; exit 0 ;;
    *) words+=("$1"); shift ;;
  esac
done

# fill_chroot: the tests as built here, what they link that a Debian 13 lacks, and the meshes, at the paths that they have here.
fill_chroot() {
  local place=$chroot_folder$root library
  mkdir -p "$place/build" "$chroot_folder/root/lib" "$chroot_folder/dev" &&
    cp "$root/build/paradesc_tests" "$place/build/" || fail "The tests could not be copied into $chroot_folder."
  for library in $(ldd "$root/build/paradesc_tests" | grep -o '/[^ ]*libOpenMesh[^ ]*'); do
    cp -L "$library" "$chroot_folder/root/lib/" || fail "$library could not be copied into $chroot_folder."
  done
  if [ -d "$root/../shared/meshes" ]; then
    mkdir -p "$place/../shared"
    cp -rLT "$root/../shared/meshes" "$place/../shared/meshes"
  fi
}

mkdir -p "$folder"
install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}" glslang-tools spirv-tools
build_library paradesc_tests
if [ -n "$chroot_folder" ]; then
  mkdir -p "$chroot_folder" || fail "The folder $chroot_folder could not be made."
  chroot_folder=$(cd "$chroot_folder" && pwd)
  make_chroot "$chroot_folder" "$folder/debootstrap.log" "${CHROOT_PACKAGES[@]}"
  fill_chroot
  if ! mountpoint -q "$chroot_folder/proc"; then
    mount -t proc proc "$chroot_folder/proc" || fail "/proc could not be mounted in $chroot_folder."
    trap 'umount "$chroot_folder/proc"' EXIT
  fi
fi
python3 "$root/tests/drivers.py" ${chroot_folder:+--chroot "$chroot_folder"} ${words[@]+"${words[@]}"}
