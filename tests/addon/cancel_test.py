"""Cancelling at any time leaves the scene as it was and the next bake right; quitting while one runs ends well."""

import ast
import subprocess
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc import bridge  # noqa: E402
from paradesc.core import threads  # noqa: E402
from paradesc_blender.bake.batch import Batch  # noqa: E402
from processes import script_words  # noqa: E402
from scene import add_sphere, attribute_values, cancel_at, fingerprint, small_bake  # noqa: E402
from shapes import ADDON, PACKAGES, as_arrays, cube_sphere  # noqa: E402

STARTERS = {"Thread", "Timer", "ThreadPoolExecutor", "ThreadPool", "ProcessPoolExecutor", "start_new_thread"}
QUIT = """
import sys, time
from functools import partial
sys.path[:0] = [{addon!r}, {numpy!r}, {tests!r}]
import bpy
import paradesc_blender
from paradesc import bridge
from paradesc.core import job, threads
from shapes import as_arrays, cube_sphere
paradesc_blender.register()
options = bridge.Options(radius=0.2, samples=4096)
arrays, settings = as_arrays(*cube_sphere(40)), job.Settings(("mean_curvature",), options, {backend!r})
worker = threads.Worker(partial(job.run, arrays, settings))
while worker.fraction < {fraction}:
    time.sleep(0.01)
sys.stdout.write(f"quits while computing: {{not worker.done}}\\n")
sys.stdout.flush()
"""


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize("backend", ["software", "reference"])
def test_cancelled_anywhere_the_scene_is_as_before_and_the_next_bake_right(backend):
    target = add_sphere(steps=8)
    settings = small_bake(backend)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    expected = attribute_values(target.data, "mean_curvature")
    settings.descriptors = {"mean_curvature", "harris"}
    before = fingerprint(target)
    for fraction in (0.0, 0.1, 0.3, 0.6, 0.9):
        batch = Batch(bpy.context)
        cancel_at(batch, fraction)
        assert fingerprint(target) == before
    settings.descriptors = {"mean_curvature"}
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert np.array_equal(attribute_values(target.data, "mean_curvature"), expected)


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "fraction"), [("software", 0.05), ("software", 0.3), ("reference", 0.01)])
def test_quitting_while_a_bake_runs_neither_hangs_nor_crashes(tmp_path, backend, fraction):
    numpy_folder = str(Path(np.__file__).parents[1])
    script = tmp_path / "quit.py"
    words = {"addon": str(ADDON), "numpy": numpy_folder, "tests": str(Path(__file__).parent)}
    script.write_text(QUIT.format(**words, backend=backend, fraction=fraction))
    ended = subprocess.run(script_words(script), capture_output=True, text=True, timeout=120, check=False)
    assert "quits while computing: True" in ended.stdout, ended.stdout + ended.stderr
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_all_threads_of_the_addon_are_stopped_when_blender_quits():
    """For bakes, frames and live values alike, one module starts all threads: the one that stops them.

    Processes, which the command line alone starts, end with it.
    """
    starting = {
        str(path.relative_to(package))
        for package in PACKAGES
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] in STARTERS
    }
    assert starting == {str(Path("core", "threads.py")), str(Path("commands", "spreading.py"))}


def test_a_thread_that_ended_is_not_waited_for():
    cancelled = []
    thread = threads.start("short", lambda: None, lambda: cancelled.append(True))
    thread.join()
    threads.stop_all()
    assert not cancelled


def test_making_a_mesh_can_be_cancelled_and_an_exception_comes_through():
    arrays = as_arrays(*cube_sphere(100))  # long enough for the callback to be called
    with bridge.Context("reference") as context:
        with pytest.raises(bridge.ParadescError) as caught:
            context.mesh(arrays, lambda _stage, _fraction: False)
        assert caught.value.status == bridge.abi.STATUS_CANCELLED
        with pytest.raises(ZeroDivisionError):
            context.mesh(arrays, lambda _stage, _fraction: 1 / 0)
