"""The Python package in callbacks, under Ctrl-C, on several threads and in forked processes."""

import copy
import gc
import multiprocessing
import pickle
import subprocess
import sys
import threading

import pytest

import paradesc
from paradesc import ParadescError
from paradesc.bridge import session
from python_api_test import of_python, same
from shapes import ADDON, ROOT, cube_sphere


@pytest.fixture(scope="module")
def sphere():
    """Positions, quads, and their UVs (m, 4, 2)."""
    return cube_sphere(8)


def test_progress_is_told_and_false_cancels(sphere):
    points, quads, _ = sphere
    told = []
    paradesc.compute(points, quads, radius=0.1, progress=lambda stage, fraction: told.append((stage, fraction)))
    assert told
    assert all(isinstance(stage, str) and 0 <= fraction <= 1 for stage, fraction in told)
    with pytest.raises(ParadescError, match=r"cancel|Cancel"):
        paradesc.compute(points, quads, radius=0.1, progress=lambda *_: False)
    with pytest.raises(ZeroDivisionError):
        paradesc.compute(points, quads, radius=0.1, progress=lambda *_: 1 / 0)


def test_an_error_in_progress_keeps_no_native_mesh(sphere):
    points, quads, _ = sphere
    gc.collect()
    gc.disable()  # which would free it at any moment, in which Ctrl-C is lost
    try:
        with pytest.raises(ZeroDivisionError):
            paradesc.compute(points, quads, radius=0.1, progress=lambda *_: 1 / 0)
        assert not [one for one in gc.get_objects() if isinstance(one, session.Made)]
    finally:
        gc.enable()


@pytest.mark.slow
@of_python
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends Ctrl-C otherwise")
@pytest.mark.parametrize("more", [[], ["--mesh"]], ids=["compute", "frames"])
def test_every_ctrl_c_arrives(more):
    words = [sys.executable, str(ROOT / "tests" / "bench" / "interrupts.py"), "--triangles", "60000", "--signals", "12"]
    done = subprocess.run([*words, *more], capture_output=True, text=True, timeout=200, env={"PYTHONPATH": str(ADDON)},
                          check=False)  # fmt: skip
    assert "12 signals" in done.stdout, done.stderr
    assert "0 not caught" in done.stdout


def test_threads_compute_at_once_and_share_a_mesh(sphere):
    points, quads, _ = sphere
    expected = paradesc.compute(points, quads, radius=0.1)
    mesh, found = paradesc.Mesh(points, quads), []

    def work():
        for _ in range(4):
            found.append(same(paradesc.compute(points, quads, radius=0.1), expected))
            found.append(same(mesh.compute(radius=0.1), expected))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [True] * 32


def forked(channel, points, quads):
    """Sends the values that a forked process computes."""
    channel.send(paradesc.compute(points, quads, radius=0.1)["mean_curvature"].tobytes())


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="this system does not fork")
def test_a_forked_process_computes_the_same(sphere):
    points, quads, _ = sphere
    expected = paradesc.compute(points, quads, radius=0.1)["mean_curvature"].tobytes()
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe()
    process = context.Process(target=forked, args=(theirs, points, quads))
    process.start()
    assert ours.poll(60)
    assert ours.recv() == expected
    process.join()


@pytest.mark.parametrize("error", [ParadescError(6, "Cancelled."), paradesc.InputError("There is no face.")])
def test_an_error_goes_to_another_process(error):
    found = pickle.loads(pickle.dumps(error))  # without it, a pool of processes breaks with all of its work
    assert type(found) is type(error)
    assert (found.status, found.sentence, str(found)) == (error.status, error.sentence, error.sentence)
    assert found.args == error.args


@pytest.mark.parametrize("call", [pickle.dumps, copy.copy, copy.deepcopy])
def test_a_mesh_says_that_it_stays_in_its_process(sphere, call):
    with paradesc.Mesh(*sphere[:2]) as mesh, pytest.raises(TypeError, match=r"make one there of the same arrays\."):
        call(mesh)


def forked_with_a_device(channel, mesh, points, quads):
    """The error of a forked process about the device that the other one has open, and what it computes without it."""
    told = []
    for call in (
        lambda: mesh.compute("mean_curvature", 0.1, buffer_size=128),
        lambda: paradesc.compute(points, quads, radius=0.1, backend="software"),
        lambda: paradesc.compute(points, quads, radius=0.1, precision="half"),
    ):
        try:
            call()
        except paradesc.ParadescError as error:
            told.append(str(error))
    mesh.close()
    channel.send((told, paradesc.compute(points, quads, radius=0.1)["mean_curvature"].tobytes()))


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="this system does not fork")
def test_a_process_forked_with_a_device_open_is_refused_it_and_computes_on_the_processor(sphere):
    points, quads, uvs = sphere
    expected = paradesc.compute(points, quads, radius=0.1)["mean_curvature"].tobytes()
    with paradesc.Mesh(points, quads, uvs=uvs, backend="software") as mesh:
        of_device = mesh.compute("mean_curvature", 0.1, buffer_size=128)["mean_curvature"].tobytes()
        context = multiprocessing.get_context("fork")
        ours, theirs = context.Pipe()
        process = context.Process(target=forked_with_a_device, args=(theirs, mesh, points, quads))
        process.start()
        assert ours.poll(120), "it hangs"
        told, found = ours.recv()
        process.join()
        assert found == expected
        assert len(told) == 3
        assert all("forked" in sentence for sentence in told), told
        assert mesh.compute("mean_curvature", 0.1, buffer_size=128)["mean_curvature"].tobytes() == of_device
