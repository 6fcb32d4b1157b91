#!/usr/bin/env bash
# The first command: installs what is needed, builds the library, makes the sample meshes and bakes them.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

install_packages "${BUILD_PACKAGES[@]}" "${RUN_PACKAGES[@]}"
if [ -f "$root/.venv/requirements.txt" ] && grep -q pytest "$root/.venv/requirements.txt"; then
  make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}" # the tests were here before
else
  make_environment "${REQUIREMENTS[@]}"
fi
build_library paradesc

samples=$root/blend_samples
mkdir -p "$samples/out"
"$python" "$samples/make_samples.py" "$samples" >/dev/null
for name in torus suzanne; do
  "$python" -m paradesc bake "$samples/$name.blend" --descriptors mean_curvature,shape_index --radius 0.02 \
    --output "$samples/out/$name.blend" --output "$samples/out/$name.png" --json "$samples/out/$name.json"
done

echo
echo "The samples with their descriptors as attributes and colors, and pictures of them:"
for name in torus suzanne; do
  echo "  $samples/out/$name.blend"
  echo "  $samples/out/$name.png"
done
