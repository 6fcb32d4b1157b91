#!/usr/bin/env bash
# Draws the pictures of the manual: some in a window of the Blender that is installed, on a screen that nobody sees, most as a render
# of the environment that blend_samples/bake.sh makes. All of them take a quarter of an hour on two cores.
# The kind panel leaves first_mask.png, too, and fails unless one click shows a grey mask and the panel fits a screen.
# Usage: bash addon/manual/pictures/make.sh [FOLDER] [KIND...], KIND: one of the names below
set -euo pipefail
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
output=$(mkdir -p "${1:-$folder}/descriptors" && cd "${1:-$folder}" && pwd)
python=$folder/../../../.venv/bin/python
[ $# -eq 0 ] || shift
declare -A places=([maps]=color_maps.png [descriptors]=descriptors [live]=live.gif)

# in_window WIDTH HEIGHT KIND OPTION...
in_window() {
  local width=$1 height=$2 kind=$3
  shift 3
  timeout 300 xvfb-run -a -s "-screen 0 ${width}x${height}x24" env LIBGL_ALWAYS_SOFTWARE=1 blender --factory-startup --python-exit-code 1 "$@" \
    --no-window-focus --window-geometry 0 0 "$width" "$height" -P "$folder/make.py" -- "$kind" "$output/$kind.png"
}

kinds=("$@")
[ ${#kinds[@]} -gt 0 ] || kinds=(legend panel sculpting maps descriptors creases hero masks radii looks low_poly onto scans textures export presets trouble live beside)
for kind in "${kinds[@]}"; do
  case $kind in
    legend) in_window 720 520 legend ;;
    sculpting) in_window 720 520 sculpting ;;
    panel) in_window 1000 900 panel --enable-event-simulate ;;
    *) timeout 1200 "$python" "$folder/make.py" "$kind" "$output/${places[$kind]:-$kind.jpg}" ;;
  esac
done
