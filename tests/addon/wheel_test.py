"""The wheel of this system: made of the library that is built already, and used by a Python that has numpy alone."""

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from conftest import blender_program
from paradesc import __version__
from shapes import ADDON, ROOT

WEBSITE = "https://example.org/paradesc"
LIBRARIES = sorted((ADDON / "paradesc" / "lib").glob("*"))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(blender_program()), reason="pip belongs to Python, not to Blender's executable"),
    pytest.mark.skipif(find_spec("scikit_build_core") is None, reason="scikit-build-core is not installed"),
]


def completed(*words):
    """Runs a program without what this Python was told about paths."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run(
        list(map(str, words)), env=environment, capture_output=True, text=True, timeout=120, check=False
    )


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The folder of programs of an environment with the wheel, and with numpy by its path."""
    folder = tmp_path_factory.mktemp("wheel")
    script = ROOT / "native" / "cmake" / "wheels.py"
    words = ("--output", folder / "wheels", f"--website={WEBSITE}", "--files", *LIBRARIES)
    made = completed(sys.executable, script, *words)
    assert made.returncode == 0, made.stdout + made.stderr
    (wheel,) = (folder / "wheels").glob("*.whl")
    completed(sys.executable, "-m", "venv", "--without-pip", folder / "venv")
    (site_packages,) = (folder / "venv").glob("lib/python*/site-packages")
    for path in Path(np.__file__).parents[1].glob("numpy*"):
        (site_packages / path.name).symlink_to(path)
    found = folder / "venv" / "bin"
    installed = completed(
        sys.executable, "-m", "pip", "--python", found / "python", "install", "--no-index", "--no-deps", wheel
    )
    assert installed.returncode == 0, installed.stdout + installed.stderr
    return found


def test_curvature_of_a_torus_is_that_of_the_closed_form(programs):
    done = completed(programs / "python", ROOT / "tests" / "packages" / "torus.py")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_example_of_the_index_page_runs(programs):
    (example,) = re.findall(r"```python\n(.+?)```", (ADDON / "PACKAGE.md").read_text(), re.S)
    done = completed(programs / "python", "-c", example)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("[1.60")  # of the outer equator: (R + 2 r) / (2 r (R + r)) = 1.607


def test_the_program_gives_the_exit_code(programs):
    done = completed(programs / "paradesc", "--version")
    assert (done.returncode, done.stdout) == (0, f"paradesc {__version__}\n")
    assert completed(programs / "paradesc", "list", "--quiet").returncode == 0
    assert completed(programs / "paradesc", "bake", "--wobble").returncode == 2


def test_indexes_get_the_address_that_the_build_was_given(programs):
    folder = programs.parents[1] / "wheels"
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
        told = [archive.read(name).decode()]
    with tarfile.open(sdist) as archive:
        told.append(archive.extractfile(f"{sdist.name.removesuffix('.tar.gz')}/PKG-INFO").read().decode())
    for metadata in told:
        assert re.findall("^Project-URL: (.+)$", metadata, re.MULTILINE) == [f"Homepage, {WEBSITE}"]
