"""Live values without waiting follow beside the window, and are there at once if they must be."""

import threading

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import NAME, baked_shape, live_settings, stretching_sphere, switch, values  # noqa: E402
from paradesc.core import contexts  # noqa: E402
from paradesc_blender.animation import handlers, live, sessions  # noqa: E402
from scene import subdivide  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


class Gate:
    """Holds every computation beside the window until it is opened."""

    def __init__(self, monkeypatch):
        self.open, self.begun = threading.Event(), 0
        compute = live.Session.compute

        def held(session, request, progress=None):
            if progress is not None:
                self.begun += 1
                while not self.open.wait(0.002) and progress("held", 0.0):
                    pass
            return compute(session, request, progress)

        monkeypatch.setattr(live.Session, "compute", held)


@pytest.fixture
def gate(monkeypatch):
    """A gate behind which computations wait."""
    made = Gate(monkeypatch)
    yield made
    made.open.set()


@pytest.fixture
def played(monkeypatch, gate):
    """A live sphere as in a window where somebody plays it and does not wait."""
    made = stretching_sphere()
    assert switch(made) == ""
    monkeypatch.setattr(sessions, "waits", lambda _scene, _depsgraph: False)
    monkeypatch.setattr(sessions, "is_watched", lambda: True)
    return made


def collect_all():
    """Does what the window's timer does, until nothing is left."""
    for _ in range(5):
        if sessions.collect(wait=True) is None:
            return
    raise AssertionError("there is always something left")


def join_threads():
    """Waits until the computation has ended; nobody has taken its results yet."""
    for thread in threading.enumerate():
        if thread.name == "paradesc live":
            thread.join()


def expected(target):
    """The values of the object's present shape."""
    return baked_shape(target, live_settings(target)).values[NAME]


def test_values_follow_when_they_are_computed(played, gate):
    before = values(played)
    bpy.context.scene.frame_set(3)
    assert np.array_equal(values(played), before)
    gate.open.set()
    collect_all()
    assert np.array_equal(values(played), expected(played))
    assert set(sessions.session_at(played).seconds) == {"read", "compute", "write"}


def test_of_frames_that_wait_only_the_newest_is_computed(played, gate):
    for frame in (2, 3, 1, 2, 3):
        bpy.context.scene.frame_set(frame)
    assert gate.begun == 1
    gate.open.set()
    collect_all()
    assert gate.begun == 2
    assert np.array_equal(values(played), expected(played))


def test_values_follow_where_frames_come_before_the_timer(played, gate):
    """If drawing takes longer than computing, every frame finds that the thread has ended."""
    gate.open.set()
    before = values(played)
    for frame in (2, 3, 1):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(values(played), before)  # those of the frame before
        before = expected(played)
        join_threads()
    collect_all()
    assert np.array_equal(values(played), before)


def test_a_frame_that_must_be_right_ends_what_is_computed_beside_it(played, gate, monkeypatch):
    bpy.context.scene.frame_set(2)
    monkeypatch.setattr(sessions, "is_watched", lambda: False)  # a script, an exporter, a render of the viewport
    bpy.context.scene.frame_set(3)
    assert not sessions.session_at(played).busy
    assert np.array_equal(values(played), expected(played))
    assert sessions.collect() is None


def test_renders_and_windowless_runs_wait_whatever_the_scene_says():
    target = stretching_sphere()
    bpy.context.scene.paradesc_live.wait = False
    assert sessions.waits(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
    assert switch(target) == ""
    for frame in (2, 3):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(values(target), expected(target))


def test_what_goes_wrong_beside_the_window_is_one_sentence(played, gate):
    before = values(played)
    played.data.shape_keys.key_blocks[1].data[3].co.x = float("nan")
    bpy.context.scene.frame_set(3)
    gate.open.set()
    collect_all()
    assert played.paradesc_live.mode == "OFF"
    assert "3" in played.paradesc_live.sentence
    assert np.array_equal(values(played), before)


@pytest.mark.parametrize("end", ["remove", "switch off", "new file"])
def test_what_ends_live_values_ends_what_is_computed(played, gate, end):
    bpy.context.scene.frame_set(2)
    if end == "remove":
        bpy.data.objects.remove(played)
    elif end == "switch off":
        switch(played, "OFF")
    else:
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert sessions.collect() is None
    assert sessions.STATE.sessions == {}
    assert contexts.POOL.used == []
    assert gate.begun == 1


@pytest.mark.parametrize("mode", ["EDIT", "VERTEX_PAINT"])
def test_results_wait_until_the_mode_is_left(played, gate, mode):
    before = values(played)
    bpy.context.scene.frame_set(2)
    bpy.ops.object.mode_set(mode=mode)
    gate.open.set()
    collect_all()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(values(played), before)
    bpy.context.scene.frame_set(2)
    collect_all()
    assert np.array_equal(values(played), expected(played))


def test_results_of_a_mesh_that_has_become_another_are_dropped(played, gate):
    bpy.context.scene.frame_set(2)
    subdivide()
    gate.open.set()
    collect_all()
    assert played.paradesc_live.sentence == ""
    bpy.context.scene.frame_set(3)
    collect_all()
    assert np.array_equal(values(played), expected(played))


def test_a_saved_file_has_the_values_of_its_frame(played, gate, tmp_path):
    bpy.context.scene.frame_set(2)
    bpy.context.scene.frame_set(3)
    gate.open.set()
    wanted = expected(played)
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    with bpy.data.libraries.load(path) as (_there, here):
        here.meshes = [played.data.name]
    loaded = np.empty(len(wanted), np.float32)
    here.meshes[0].attributes[NAME].data.foreach_get("value", loaded)
    assert np.array_equal(loaded, wanted)


def test_what_was_written_beside_the_window_is_no_edit_but_is_compared_at_rest(played, gate):
    gate.open.set()
    bpy.context.scene.frame_set(3)
    collect_all()
    session = sessions.session_at(played)
    bpy.context.view_layer.update()
    assert (session.edited, session.unsure) == (False, True)
    for item in played.data.uv_layers.active.data:
        item.uv *= 0.9
    sessions.STATE.edited_at = 0.0
    handlers.follow_edits()
    collect_all()
    assert np.array_equal(values(played), expected(played))
