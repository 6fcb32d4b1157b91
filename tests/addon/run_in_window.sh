#!/usr/bin/env bash
# Opens Blender's window on a screen that nobody sees, and lets window_in_blender.py use the add-on there, or the script
# beside it that the second word names. With a file name as the first word it also leaves a screenshot of the panel there.
# The third and the fourth word are the size of the screen.
set -uo pipefail
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
seconds=300 width=${3:-1400} height=${4:-1000}
[ -z "${PARADESC_LONG_TESTS:-}" ] || seconds=1800
# Blender ends with 0 after a Python error: the script's last words count, and that it ends at all.
output=$(timeout $seconds xvfb-run -a -s "-screen 0 ${width}x${height}x24" env LIBGL_ALWAYS_SOFTWARE=1 \
  blender --factory-startup --enable-event-simulate --no-window-focus --window-geometry 0 0 $width $height \
  -P "$folder/${2:-window_in_blender.py}" -- "$folder" "${1:-}" 2>&1)
code=$?
printf '%s\n' "$output" | grep -E '^(window: |Traceback|[A-Za-z]*Error)' || printf '%s\n' "$output" | tail -n 30
[ $code -eq 0 ] || echo "window: Blender ended with $code"
[ $code -eq 0 ] && grep -qx 'window: all steps passed' <<<"$output"
