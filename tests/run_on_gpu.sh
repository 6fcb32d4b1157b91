#!/usr/bin/env bash
# Runs the tests of devices on this machine's graphics card.
# Usage: bash tests/run_on_gpu.sh [--built]
# It builds the library and the tests, after it has installed what they need by apt where that is there; Blender is not needed. With --built it installs and builds nothing, and takes what lies in build and in
# addon/paradesc/lib: for a machine without a network or a compiler.
# It ends with 1 where no card is offered, or where a test failed on it.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"

built=''

usage() { sed -n '2,6s/^# //p' "${BASH_SOURCE[0]}"; }

while [ $# -gt 0 ]; do
  case $1 in
    --built) built=yes; shift ;;
    -h | --help) usage; exit 0 ;;
    *) fail "There is no option $1; --built is the only one." ;;
  esac
done

# card: its name, or why OpenGL offers none, with the status 1.
card() {
  PYTHONPATH=$root/addon "$python" - <<'PYTHON'
import sys
from paradesc.bridge import Context, ParadescError
try:
    print(Context("gpu").device)
except (OSError, ParadescError) as error:
    print(error)
    sys.exit(1)
PYTHON
}

# why_hidden: where NVIDIA's own tool lists cards, what stands between them and OpenGL.
why_hidden() {
  command -v nvidia-smi >/dev/null && nvidia-smi -L 2>/dev/null | grep -q '^GPU' || return 0
  echo " nvidia-smi lists one, so NVIDIA's OpenGL is missing: a container needs NVIDIA_DRIVER_CAPABILITIES=all, and" \
    "__EGL_VENDOR_LIBRARY_FILENAMES must name 10_nvidia.json where that lies in no usual folder."
}

if [ -n "$built" ]; then
  [ -x "$root/build/paradesc_tests" ] || fail "There is no build/paradesc_tests; leave --built out, or build it first."
  export LD_LIBRARY_PATH=$root/addon/paradesc/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} # OpenMesh lies there
else
  install_packages "${BUILD_PACKAGES[@]}" libegl1 libgl1-mesa-dri python3-numpy # Mesa drives AMD's and Intel's
fi
python=$(python_that 'import sys, numpy; sys.exit(sys.version_info < (3, 10))' "$python" python3 /usr/bin/python3) ||
  fail "Python 3.10 or later with numpy is missing; please install it, then run this again."
[ -n "$built" ] || build_library paradesc
name=$(card) || fail "No graphics card is offered here: $name$(why_hidden)"
echo "Graphics card: $name"

[ -n "$built" ] || build_library paradesc_tests
"$python" "$root/tests/drivers.py" card ||
  fail "On $name tests of devices failed; their log is build/drivers/card.log."
echo "On $name all tests of devices passed."
