"""The parts that the add-on's tests share: fixtures of the sphere, and the command line as a process."""

import functools
import gc
import json
import os
import subprocess
import sys
from dataclasses import dataclass

import pytest

from shapes import ADDON, ROOT, as_arrays, cube_sphere, write_obj

MESHES = ROOT.parent / "shared" / "meshes"


def pytest_runtest_setup():
    """Sets what earlier tests have left apart: the add-on collects garbage at its end, and would look through millions of objects."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def sphere():
    """The sphere as arrays."""
    return as_arrays(*cube_sphere())


@pytest.fixture
def sphere_obj(tmp_path):
    """The sphere as a file."""
    return write_obj(tmp_path / "sphere.obj", *cube_sphere())


@pytest.fixture
def registered():
    """The add-on registered in Blender, and an empty scene."""
    import paradesc_blender as package
    from scene import empty_scene, measure_curvature

    empty_scene()
    package.register()
    measure_curvature()
    yield
    package.unregister()


@pytest.fixture
def target():
    """A small sphere, the active object."""
    from scene import add_sphere

    return add_sphere(steps=3)


@pytest.fixture
def folder(tmp_path):
    """The folder of the saved file."""
    from scene import saved_scene

    saved_scene(tmp_path / "file.blend")
    return tmp_path


def blender_program():
    """The words that start, in the background, the Blender in which the tests run; none in its Python module."""
    try:
        import bpy
    except ImportError:
        return []
    return [bpy.app.binary_path, "-b", "--factory-startup"] if bpy.app.binary_path else []


@pytest.fixture
def pyvista():
    """PyVista; it wants a newer numpy than Blender's, and then disturbs how Blender ends."""
    if blender_program():
        pytest.skip("PyVista is tried in Blender's Python module only, where numpy is ours")
    return pytest.importorskip("pyvista", reason="PyVista is not installed")


def command_line():
    """The words before the command: this Blender's if the tests run in one, else the Python module's."""
    program = blender_program()
    cli = str(ADDON / "paradesc" / "cli.py")
    return [*program, "-P", cli, "--"] if program else [sys.executable, "-m", "paradesc"]


@functools.cache
def said_by_blender():
    """The lines that Blender itself always writes to its standard error stream here, whatever it is started for.

    For example, without /etc/mtab it says that it could not get a list of mounted file-systems.
    """
    words = blender_program() or [sys.executable, "-c", "import bpy"]
    done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120, check=False)
    return frozenset(done.stderr.splitlines())


def completed(words, cwd, env=None):
    """Runs a program to its end; leaves out of its standard error what Blender itself always says here."""
    done = subprocess.run(
        list(map(str, words)),
        cwd=cwd,
        env=env,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    lines = done.stderr.splitlines(keepends=True)
    done.stderr = "".join(line for line in lines if line.rstrip("\n") not in said_by_blender())
    return done


@pytest.fixture
def paradesc(tmp_path):
    """Runs the command line in an empty folder."""

    return lambda *words, cwd=tmp_path: completed([*command_line(), *words], cwd, environment())


def environment():
    """This process's environment, with the add-on on Python's path."""
    return {**os.environ, "PYTHONPATH": str(ADDON)}


def real_mesh(name):
    """A real mesh; the test is skipped if it is absent."""
    path = MESHES / name
    if not path.is_file():
        pytest.skip(f"real meshes are not in shared/meshes beside the checkout ({name})")
    return path


@dataclass
class Ended:
    """The output and the code of a command that has ended."""

    code: int
    output: str
    error: str


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Runs a command in this process, in an empty folder."""
    from paradesc.commands.main import main

    monkeypatch.chdir(tmp_path)

    def call(*words):
        capfd.readouterr()
        code = main([str(word) for word in words])
        return Ended(code, *capfd.readouterr())

    return call


@pytest.fixture
def report(tmp_path):
    """Reads a JSON report."""
    return lambda name="report.json": json.loads((tmp_path / name).read_text())


@pytest.fixture
def three_objects(tmp_path):
    """Two spheres, a third object that shares a mesh, and objects that cannot be baked."""
    import bpy

    from scene import add_sphere, empty_scene, saved_scene

    empty_scene()
    first = add_sphere("first", steps=6)
    second = add_sphere("second/large", steps=8)
    second.location, second.scale = (10, 0, 0), (2, 2, 2)
    copy = first.copy()
    copy.name, copy.location = "twin", (0, 10, 0)
    bpy.context.collection.objects.link(copy)
    add_sphere("hidden", steps=4).hide_render = True
    bpy.context.collection.objects.link(bpy.data.objects.new("bare", bpy.data.meshes.new("bare")))
    return saved_scene(tmp_path / "three.blend")


def pytest_sessionfinish(session, exitstatus):
    """Keeps how the tests ended for pytest_unconfigure()."""
    session.config.ended = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """Ends the process at once: Blender's own glTF exporter leaves callbacks that make its Python module crash at exit.

    headless_test.py and install_test.py test in other processes that the add-on does not do so.
    """
    bpy = sys.modules.get("bpy")
    if bpy is not None and not bpy.app.binary_path and hasattr(config, "ended"):
        if "coverage" in sys.modules and (counts := sys.modules["coverage"].Coverage.current()) is not None:
            counts.stop()
            counts.save()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.ended)


@pytest.fixture
def stretching():
    """A sphere that a shape key makes an ellipsoid, from frame 1 to frame 3."""
    from live_values import stretching_sphere  # needs Blender

    return stretching_sphere()
