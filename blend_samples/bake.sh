#!/usr/bin/env bash
# The first command: installs what is needed, builds the library, makes the sample meshes and bakes them.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}"
if [ -f "$root/.venv/requirements.txt" ] && grep -q pytest "$root/.venv/requirements.txt"; then
  make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}" "${SITE_REQUIREMENTS[@]}" # the tests were here before
else
  make_environment "${REQUIREMENTS[@]}"
fi
build_library paradesc

samples=$root/blend_samples
out=$samples/out
mkdir -p "$out"
"$python" "$samples/make_samples.py" "$samples" >/dev/null

# bake_as STEM NAME DESCRIPTORS OPTION...: one sample into a scene with attributes and colors, a picture, values, a report.
bake_as() {
  local stem=$out/$1 name=$2 descriptors=$3
  shift 3
  echo
  echo "== ${stem##*/}"
  "$python" "$root/addon/manual/pictures/draw.py" bake "$samples/$name.blend" --descriptors "$descriptors" "$@" \
    --output "$stem.blend" --output "$stem.png" --output "$stem.npz" --json "$stem.json"
  baked+=("$stem.blend" "$stem.png")
}

# bake NAME DESCRIPTORS OPTION...: as auto chooses.
bake() {
  bake_as "$1" "$@"
}

# bake_twice NAME DESCRIPTORS OPTION...: also in texture space, as graphics cards do, with pictures of the baked buffers.
bake_twice() {
  local stem=$1.texture_space
  bake "$@"
  bake_as "$stem" "$@" --backend software --dump-buffers "$out/$stem"
  baked+=("$out/$stem/")
  compared+=("$1")
}

# animate NAME: its frames into a cache beside the scene, which the add-on plays.
animate() {
  "$python" -m paradesc animate "$out/$1.blend" --frames 1:24 --descriptors mean_curvature --radius 0.04 --samples 64 \
    --buffer 512 --cache "$out/paradesc_cache"
}

baked=() compared=()
# Twice, for what is hard in texture space: charts of many shapes; turned, scaled and mirrored ones; hundreds on thin parts.
bake_twice 01_curvature_suzanne mean_curvature,shape_index --radius 0.02
bake_twice 02_charts_torus mean_curvature,gaussian_curvature --radius 0.02
bake_twice 03_genus_20_rim mean_curvature,shape_index --radius 0.02
bake 04_armature_cylinder mean_curvature --radius 0.04
animate 04_armature_cylinder
bake 05_shape_key_ellipsoid mean_curvature --radius 0.04
animate 05_shape_key_ellipsoid
bake 06_udim_sphere mean_curvature --radius 0.04
bake 07_mirrored_suzanne mean_curvature,shape_index --radius 0.02
bake 08_displaced_waves mean_curvature,shape_index --radius 0.01 --material-maps
bake 09_normal_mapped_waves mean_curvature,shape_index --radius 0.01 --material-maps
bake 10_no_uv_map_torus mean_curvature,gaussian_curvature --radius 0.02
bake 11_fragmented_sphere mean_curvature --radius 0.04

echo
echo "The samples (blend_samples/README.md says what each shows), with their descriptors as attributes and colors, and pictures"
echo "(the .blend files are for Blender 4.2 and later; folders have pictures of the buffers baked in texture space):"
printf '  %s\n' "${baked[@]}"
echo
"$python" "$samples/compare_engines.py" "$out" "${compared[@]}"
