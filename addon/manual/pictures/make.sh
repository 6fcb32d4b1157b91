#!/usr/bin/env bash
# Draws the pictures of the manual with the Blender that is installed: some in a window on a screen that nobody sees, some by a render.
# The kind panel leaves first_mask.png, too, and fails unless one click shows a grey mask and the panel fits a screen.
# Usage: bash addon/manual/pictures/make.sh [FOLDER] [KIND...], KIND: legend panel hero cavity wear descriptors radii creases frames maps beside onto sculpting presets textures export trouble
set -euo pipefail
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
output=$(mkdir -p "${1:-$folder}/descriptors" && cd "${1:-$folder}" && pwd)
[ $# -eq 0 ] || shift
declare -A places=([maps]=color_maps.png [descriptors]=descriptors)

# in_window WIDTH HEIGHT KIND OPTION...
in_window() {
  local width=$1 height=$2 kind=$3
  shift 3
  timeout 300 xvfb-run -a -s "-screen 0 ${width}x${height}x24" env LIBGL_ALWAYS_SOFTWARE=1 blender --factory-startup "$@" \
    --no-window-focus --window-geometry 0 0 "$width" "$height" -P "$folder/make.py" -- "$kind" "$output/$kind.png"
}

kinds=("$@")
[ ${#kinds[@]} -gt 0 ] || kinds=(legend panel hero cavity wear descriptors radii creases frames maps beside onto sculpting presets textures export trouble)
for kind in "${kinds[@]}"; do
  case $kind in
    legend) in_window 720 520 legend ;;
    sculpting) in_window 720 520 sculpting ;;
    panel) in_window 1000 900 panel --enable-event-simulate ;;
    *) timeout 600 blender -b --factory-startup --python-exit-code 1 -P "$folder/make.py" -- "$kind" "$output/${places[$kind]:-$kind.png}" ;;
  esac
done
