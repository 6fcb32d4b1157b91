#!/usr/bin/env bash
# Builds the site of the manual, the notebooks and the interfaces of Python and C into build/site/html. Sphinx comes into an
# environment of its own beside it. Warnings, such as a link that leads nowhere, are errors.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
site=$root/build/site
python=$site/env/bin/python

[ -x "$python" ] || python3 -m venv "$site/env"
"$python" -m pip install -q --disable-pip-version-check -r "$root/addon/site/requirements.txt" numpy
"$python" -m sphinx -E -W --keep-going -q -c "$root/addon/site" "$root/addon" "$site/html"
echo "The site is there: $site/html/index.html"
