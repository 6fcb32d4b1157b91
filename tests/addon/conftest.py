"""What the add-on's tests share: fixtures of the sphere, and the command line as a process."""

import os
import subprocess
import sys

import pytest

from shapes import ADDON, ROOT, as_arrays, cube_sphere, write_obj

MESHES = ROOT.parent / "shared" / "meshes"


@pytest.fixture(scope="session")
def sphere():
    """The sphere as arrays."""
    return as_arrays(*cube_sphere())


@pytest.fixture
def sphere_obj(tmp_path):
    """The sphere as a file."""
    return write_obj(tmp_path / "sphere.obj", *cube_sphere())


def command_line():
    """The words before the command: this Blender's if the tests run in one, else the Python module's."""
    try:
        import bpy
    except ImportError:
        return [sys.executable, "-m", "paradesc"]
    if not bpy.app.binary_path:
        return [sys.executable, "-m", "paradesc"]
    cli = str(ADDON / "paradesc" / "cli.py")
    return [bpy.app.binary_path, "-b", "--factory-startup", "-P", cli, "--"]


@pytest.fixture
def paradesc(tmp_path):
    """Runs the command line in an empty folder."""

    def run(*words, cwd=tmp_path):
        return subprocess.run(
            [*command_line(), *map(str, words)],
            cwd=cwd,
            env=environment(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )

    return run


def environment():
    """This process' environment, with the add-on on Python's path."""
    return {**os.environ, "PYTHONPATH": str(ADDON)}


def real_mesh(name):
    """A mesh that is not ours; the test is skipped where it is absent."""
    path = MESHES / name
    if not path.is_file():
        pytest.skip(f"real meshes are not at ../shared/meshes ({name})")
    return path
