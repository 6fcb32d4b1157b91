"""Runs these tests inside a real Blender.

Usage: blender -b --factory-startup -P run_in_blender.py -- SITE_PACKAGES [pytest's words]
"""

import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent


def main() -> int:
    """Runs pytest and gives its exit code. Its packages come last on the path, so Blender's own numpy stays in use."""
    site_packages, *words = sys.argv[sys.argv.index("--") + 1 :]
    sys.path.append(site_packages)
    sys.path.insert(0, str(FOLDER))
    import pytest

    return int(pytest.main(["-p", "no:cacheprovider", "--rootdir", str(FOLDER.parents[1]), str(FOLDER), *words]))


sys.exit(main())
