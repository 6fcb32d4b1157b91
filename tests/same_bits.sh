#!/usr/bin/env bash
# Whether two trees compute the same: every shared mesh, every descriptor, three radii, both precisions, at vertices and at texels, then
# every other option once, on the software device, each tree with its own library. Values whose bits differ are counted, and where there
# are any it ends with 1. NaN equals NaN of the same bits. Sentences that differ are named, and count for nothing.
# Usage: bash tests/same_bits.sh OLD NEW [--quick] [--grid] [--only NAMES] [--meshes FOLDER] [--rows N] [--json FILE]
#   OLD, NEW   folders of built trees, or revisions of this repository, which are built in build/same_bits
#   --quick    three small meshes, small buffers, few samples
#   --grid     radii, precisions and places alone, without the other options
#   --only     names of meshes without their suffix, with commas between
# What a tree gave is kept in build/same_bits, or in PARADESC_SAME_BITS, by its library's checksum: the old tree is computed once.
# PARADESC_PYTHON is a Python with numpy; else that of .venv, or the system's.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
here=$root/tests/same_bits
kept=${PARADESC_SAME_BITS:-$root/build/same_bits}

usage() {
  sed -n '2,12s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit 2
}

fail() {
  echo "same_bits: $*" >&2
  exit 2
}

[ $# -ge 2 ] || usage
old=$1 new=$2
shift 2
computing=() comparing=() keyed=""
while [ $# -gt 0 ]; do
  case $1 in
    --quick | --grid) computing+=("$1") keyed+=$1; shift ;;
    --meshes) computing+=("$1" "$2") keyed+=$2; shift 2 ;;
    --only) computing+=("$1" "$2"); comparing+=("$1" "$2"); shift 2 ;;
    --rows | --json) comparing+=("$1" "$2"); shift 2 ;;
    *) usage ;;
  esac
done

for python in "${PARADESC_PYTHON:-$root/.venv/bin/python}" python3 none; do
  ! "$python" -c 'import numpy' 2>/dev/null || break
done
[ "$python" != none ] || fail "There is no Python with numpy; name one by PARADESC_PYTHON."

# built TREE: the folder of a tree whose library is there, and not older than its sources.
built() {
  local library=$1/addon/paradesc/lib/libparadesc.so linked=$1/build/libparadesc.so newer
  if [ -d "$1" ]; then
    [ -f "$library" ] || fail "$1 is not built: there is no $library."
    [ "$linked" -nt "$library" ] || linked=$library # the same again is not copied
    newer=$(find "$1/native" "$1/shaders" -regex '.*\.\(cpp\|h\|c\|def\|glsl\)' -newer "$linked" -print -quit)
    [ -z "$newer" ] || fail "The library of $1 is older than $newer; build it."
    (cd "$1" && pwd)
    return
  fi
  local commit tree launcher=()
  commit=$(git -C "$root" rev-parse --verify --quiet "$1^{commit}") || fail "$1 is neither a folder nor a revision."
  tree=$root/build/same_bits/trees/$commit
  ! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  if [ ! -f "$tree/built" ]; then
    [ -d "$tree" ] || git -C "$root" worktree add --quiet --detach "$tree" "$commit"
    { cmake -S "$tree" -B "$tree/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF "${launcher[@]}" &&
      cmake --build "$tree/build" --target paradesc; } >"$tree.log" 2>&1 || fail "The build of $1 failed; see $tree.log."
    touch "$tree/built"
  fi
  echo "$tree"
}

# compute TREE: all that it gives, and prints where that lies.
compute() {
  local key folder
  key=$({ cat "$1"/addon/paradesc/lib/* "$here"/*.py "$root"/tests/accuracy/{meshes,surfaces}.py; find "$1/addon/paradesc/bridge" -name '*.py' -exec cat {} +
    echo "$(uname -n) $keyed"; } | sha256sum | cut -c1-16)
  folder=$kept/$key
  PYTHONPATH=$1/addon:$root/tests/accuracy "$python" "$here/compute.py" "$1" "$folder" "${computing[@]}" >&2 ||
    fail "$1 could not be computed."
  echo "$folder"
}

old=$(built "$old")
new=$(built "$new")
old=$(compute "$old")
new=$(compute "$new")
"$python" "$here/compare.py" "$old" "$new" "${comparing[@]}"
