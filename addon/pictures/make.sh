#!/usr/bin/env bash
# Draws the pictures of the manual with the Blender that is installed: a window on a screen that nobody sees, and a render.
# Usage: bash addon/pictures/make.sh [FOLDER]
set -euo pipefail
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
output=$(mkdir -p "${1:-$folder}" && cd "${1:-$folder}" && pwd)
timeout 300 xvfb-run -a -s "-screen 0 720x520x24" env LIBGL_ALWAYS_SOFTWARE=1 \
  blender --factory-startup --no-window-focus --window-geometry 0 0 720 520 -P "$folder/make.py" -- legend "$output/legend.png"
timeout 300 xvfb-run -a -s "-screen 0 1000x900x24" env LIBGL_ALWAYS_SOFTWARE=1 blender --factory-startup --enable-event-simulate \
  --no-window-focus --window-geometry 0 0 1000 900 -P "$folder/make.py" -- panel "$output/panel.png"
blender -b --factory-startup -P "$folder/make.py" -- radii "$output/radii.png"
blender -b --factory-startup -P "$folder/make.py" -- frames "$output/frames.png"
timeout 300 blender -b --factory-startup -P "$folder/make.py" -- cavity "$output/cavity.png"
blender -b --factory-startup -P "$folder/make.py" -- maps "$output/color_maps.png"
