#!/usr/bin/env bash
# Installs the add-on's zip into a Blender without any settings, and does in its window whatever an artist would, with a picture of each
# step and a report of what was seen.
# Usage: bash tests/window/drive.sh FOLDER [--chroot DIR] [GROUP...]
# GROUP: a file of tasks beside this one, by default all. Without --chroot it is the installed Blender; DIR is a Debian with a Blender, where
# this tree and the folder have the same paths as here. Each group has a Blender of its own, so that a crash costs one group alone.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
[ $# -gt 0 ] || { sed -n 's/^# //p' "${BASH_SOURCE[0]}"; exit 2; }
folder=$(mkdir -p "$1" && cd "$1" && pwd)
shift
within=()
if [ "${1:-}" = --chroot ]; then
  within=(chroot "$2")
  shift 2
fi
groups=("$@")
[ ${#groups[@]} -gt 0 ] || groups=(start missing words assets hard images live looks wear export large)
WIDTH=1600 HEIGHT=1000 MINUTES=40
command -v Xvfb >/dev/null && "${within[@]}" sh -c 'command -v blender && command -v xwd' >/dev/null ||
  { echo "Xvfb, Blender or xwd is missing: apt-get install xvfb blender python3-numpy x11-apps" >&2; exit 1; }

rm -rf "$folder/scripts" # of another version
mkdir -p "$folder/config" "$folder/scripts" "$folder/home"
python3 - "$root" "$folder/stage" "$folder/paradesc.zip" <<'PACK' || exit 1
import shutil
import sys
from pathlib import Path

root, stage, target = map(Path, sys.argv[1:])
sys.path.insert(0, str(root / "native" / "cmake"))
import package

shutil.rmtree(stage, ignore_errors=True)
stage.parent.mkdir(exist_ok=True)
package.stage_legacy(stage, {"linux-x64": sorted((root / "addon" / "paradesc" / "lib").glob("*.so*"))})
target.unlink(missing_ok=True)
package.write_zip(stage, target)
PACK

exec 3< <(exec Xvfb -displayfd 1 -ac -screen 0 "${WIDTH}x${HEIGHT}x24" 2>/dev/null)
screen_process=$!
trap 'kill $screen_process 2>/dev/null' EXIT
read -r display <&3
failed=0
for group in "${groups[@]}"; do
  timeout $((60 * MINUTES)) "${within[@]}" env -u WAYLAND_DISPLAY HOME="$folder/home" DISPLAY=":$display" LIBGL_ALWAYS_SOFTWARE=1 \
    BLENDER_USER_CONFIG="$folder/config" BLENDER_USER_SCRIPTS="$folder/scripts" \
    blender --factory-startup --enable-event-simulate --no-window-focus --window-geometry 0 0 $WIDTH $HEIGHT \
    -P "$here/drive.py" -- "$group" "$folder" >"$folder/$group.log" 2>&1
  code=$?
  if [ $code -ne 0 ] || ! grep -q "^$group: done" "$folder/$group.log"; then
    echo "$group ended early ($code), see $folder/$group.log"
    failed=1
  fi
done
python3 "$here/points.py" "$folder"
exit $failed
