#!/usr/bin/env bash
# Computes a library of small assets in one process, in several and by Dask, also with a worker that is killed: prints seconds, what
# sharing out costs beside computing, and one hash of all results, which has to be the same. No part of the tests: it takes minutes.
#   bash tests/farms.sh [--assets 2000] [--keep FOLDER]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../blend_samples/setup.sh"
python=${PARADESC_PYTHON:-$python}
[ -x "$python" ] || make_environment "${REQUIREMENTS[@]}" "${TEST_REQUIREMENTS[@]}"
[ -f "$root/addon/paradesc/lib/libparadesc.so" ] || build_library paradesc
exec "$python" "$root/tests/farms.py" "$@"
