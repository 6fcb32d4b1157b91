#!/usr/bin/env bash
# Whether the tests notice bugs: some 80 single mutations of the code (tests/mutants/*.toml), one at a time in a copy of the tree under
# build/mutants, each with the tests that should notice it. Run by hand; all of it takes about an hour of two cores.
# Usage: bash tests/mutants.sh [--list] [--check] [--only NAMES] [--rest] [--jobs N] [--page]
#   --check   whether every mutation still applies: its old text is there exactly once, wherever the file has moved to
#   --only    names or parts of them, with commas between
#   --rest    those that no earlier run has seen noticed
#   --page    writes the table into tests/RELIABILITY.md, of the results that are kept in build/mutants
# Prints noticed, survived, does not apply, does not build; ends with 1 unless all are noticed but for those shown to be equivalent.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
python=${PARADESC_PYTHON:-$root/.venv/bin/python}
"$python" -c 'import tomllib' 2>/dev/null || { echo "mutants: $python is no Python 3.11; run tests/run.sh once." >&2; exit 2; }
exec "$python" "$root/tests/mutants/run.py" --python "$python" "$@"
