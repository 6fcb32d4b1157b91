#!/usr/bin/env bash
# Does what somebody does who has just found the add-on: installs the zip into a Blender without any settings, adds the monkey with a
# Subdivision that is not applied, and clicks once. It makes the pictures of the panel and of the mask, as for the manual.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
user=$(mktemp -d)
trap 'rm -rf "$user"' EXIT
PARADESC_ZIP=$user/paradesc.zip
export PARADESC_ZIP BLENDER_USER_CONFIG=$user/config BLENDER_USER_SCRIPTS=$user/scripts
mkdir "$user/config" "$user/scripts"
python3 - "$root" "$user/stage" "$PARADESC_ZIP" <<'PACK' || exit 1
import sys
from pathlib import Path

root, folder, target = map(Path, sys.argv[1:])
sys.path.insert(0, str(root / "native" / "cmake"))
import package

package.stage_legacy(folder, {"linux-x64": sorted((root / "addon" / "paradesc" / "lib").glob("*.so*"))})
package.write_zip(folder, target)
PACK
output=$(bash "$root/addon/manual/pictures/make.sh" "$root/build/pictures" panel 2>&1)
grep '^panel: ' <<<"$output" || { printf '%s\n' "$output" | tail -n 20; exit 1; }
