"""Live values in sculpt mode follow at the end of a stroke, never in the middle of one. shown_in_window.py strokes."""

import time

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import count_computations, switch, values  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc_blender.animation import handlers, live, pausing, sessions  # noqa: E402
from paradesc_blender.scene import mesh_io  # noqa: E402
from paradesc_blender.ui import live_panel  # noqa: E402
from scene import add_sphere, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
MASK = "cavity"


@pytest.fixture
def sculpted():
    """A live sphere in sculpt mode."""
    small_bake()
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.backend, settings.radius_percent = {MASK}, "cpu", 12.0
    made = add_sphere(steps=16)
    assert switch(made) == ""
    bpy.ops.object.mode_set(mode="SCULPT")
    return made


def press_in(target, depth=0.3):
    """Moves some vertices as a stroke does, and tells handlers what Blender tells them: the object is drawn anew."""
    positions = np.empty(3 * len(target.data.vertices), np.float32)
    holder = target.data.vertices if target.data.shape_keys is None else target.active_shape_key.data
    holder.foreach_get("co", positions)
    positions = positions.reshape(-1, 3)
    top = positions[:, 2] > 0.8 * positions[:, 2].max()
    positions[top] *= 1 - depth
    holder.foreach_set("co", positions.ravel())
    target.update_tag()
    bpy.context.view_layer.update()


def rest():
    """Does what the event loop does once the stroke has ended."""
    if sessions.STATE.edited_at is not None:
        sessions.STATE.edited_at = 0.0
    return handlers.follow_edits()


def test_values_follow_a_stroke_without_leaving_the_mode(sculpted):
    before = values(sculpted, MASK)
    press_in(sculpted)
    assert rest() is None
    stroked = values(sculpted, MASK)
    assert np.nanmax(np.abs(stroked - before)) > 0.05
    assert sculpted.mode == "SCULPT"
    arrays = mesh_io.read_object(sculpted, corner_normals=False, needs_uvs=False)
    expected = job.run(arrays, sessions.session_at(sculpted).stream.settings)
    np.testing.assert_array_equal(stroked, expected.values[MASK])


def test_strokes_read_positions_alone_and_keep_the_radius(sculpted, monkeypatch):
    press_in(sculpted)
    rest()
    session, reads = sessions.session_at(sculpted), []
    radius = session.results.radius
    monkeypatch.setattr(live.Session, "take_mesh", lambda *_words: reads.append(1))
    for _ in range(2):
        press_in(sculpted)
        rest()
        rest()  # our own writing is an edit, too
    assert not reads
    assert session.results.radius == radius


def test_nothing_is_computed_or_written_in_the_middle_of_a_stroke(sculpted, monkeypatch):
    done = count_computations(monkeypatch)
    monkeypatch.setattr(pausing, "is_busy", lambda: True)
    press_in(sculpted)
    assert rest() is not None
    assert sessions.collect() is not None
    assert not done
    monkeypatch.setattr(pausing, "is_busy", lambda: False)
    assert rest() is None
    assert len(done) == 1


def test_buttons_are_not_looked_at_while_a_thread_computes(sculpted, monkeypatch):
    monkeypatch.setattr(live.Session, "computing", True)
    monkeypatch.setattr(pausing, "is_busy", lambda: pytest.fail("Blender 3.4 may crash"))
    assert sessions.collect() == sessions.COLLECT_STEP


def test_a_stroke_is_waited_for_shorter_than_an_edit(sculpted):
    assert handlers.delay_of([sculpted]) < handlers.delay_of([])
    sessions.STATE.edited_at = time.monotonic()
    assert 0 < handlers.follow_edits() <= handlers.STROKE_DELAY


def test_live_that_is_switched_on_in_sculpt_mode_stays_there(sculpted):
    switch(sculpted, "OFF")
    for name in (MASK, f"{MASK}_color"):
        sculpted.data.attributes.remove(sculpted.data.attributes[name])
    assert switch(sculpted) == ""
    assert sculpted.mode == "SCULPT"
    assert sculpted.data.color_attributes.active_color.name == f"{MASK}_color"


def test_the_shape_key_that_is_sculpted_is_measured(sculpted):
    bpy.ops.object.mode_set(mode="OBJECT")
    sculpted.shape_key_add(name="Basis")
    sculpted.shape_key_add(name="Dent").value = 1.0
    sculpted.active_shape_key_index = 1
    bpy.ops.object.mode_set(mode="SCULPT")
    rest()
    before = values(sculpted, MASK)
    press_in(sculpted)
    rest()
    assert np.nanmax(np.abs(values(sculpted, MASK) - before)) > 0.05


def test_fine_meshes_are_sculpted_without_fitted_normals(sculpted, monkeypatch):
    press_in(sculpted)
    rest()
    session = sessions.session_at(sculpted)
    assert session.results.settings.options.normals == "fitted"
    monkeypatch.setattr(live, "FINE", 1)
    press_in(sculpted)
    rest()
    assert session.results.settings.options.normals == "max"
    assert session.has_settings(bpy.context.scene)


def test_dynamic_topology_is_waited_for_and_said(sculpted, monkeypatch):
    done = count_computations(monkeypatch)
    bpy.ops.sculpt.dynamic_topology_toggle()
    assert live_panel.live_sentence(sculpted) == "Values follow when dynamic topology is switched off."
    sessions.refresh_window([sculpted])
    assert not done
    bpy.ops.sculpt.dynamic_topology_toggle()
    assert live_panel.live_sentence(sculpted) == ""
    sessions.refresh_window([sculpted])
    assert sculpted.paradesc_live.mode == "LIVE"


def test_multires_is_waited_for_and_said(sculpted):
    bpy.ops.object.mode_set(mode="OBJECT")
    modifier = sculpted.modifiers.new("multires", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier="multires")
    bpy.ops.object.mode_set(mode="SCULPT")
    assert "Multires" in live_panel.live_sentence(sculpted)
    modifier.sculpt_levels = 0
    assert live_panel.live_sentence(sculpted) == ""
