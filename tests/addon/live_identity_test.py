"""Live values follow objects, whatever these and their meshes are called, until they are gone."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import baked_shape, live_settings, switch, values  # noqa: E402
from paradesc_blender.animation import sessions, surfaces  # noqa: E402
from scene import add_sphere  # noqa: E402

NAME = "mean_curvature"


pytestmark = pytest.mark.usefixtures("registered")


def other_shape(name, size):
    """A second live sphere, with a range of its own."""
    made = add_sphere(name, steps=8)
    made.data.transform([[size, 0, 0, 0], [0, size, 0, 0], [0, 0, size, 0], [0, 0, 0, 1]])
    assert switch(made) == ""
    return made


def test_objects_that_change_names_keep_their_sessions_and_values(stretching):
    switch(stretching)
    other = other_shape("other", 2.0)
    kept = [sessions.session_at(item) for item in (stretching, other)]
    stretching.name, other.name = "aside", "sphere"
    stretching.name = "other"
    bpy.context.scene.frame_set(2)
    if hasattr(stretching, "session_uid"):
        assert [sessions.session_at(item) for item in (stretching, other)] == kept
    for item in (stretching, other):
        assert np.array_equal(values(item), baked_shape(item, live_settings(item)).values[NAME])


def test_an_object_made_anew_under_the_same_names_begins_anew(stretching):
    switch(stretching)
    former = sessions.session_at(stretching)
    names = stretching.name, stretching.data.name
    mesh = stretching.data
    bpy.data.objects.remove(stretching)
    bpy.data.meshes.remove(mesh)
    made = add_sphere(names[0], steps=8)
    assert (made.name, made.data.name) == names
    for item in made.data.uv_layers.active.data:
        item.uv *= 0.7
    made.paradesc_live.mode = "LIVE"
    bpy.context.scene.frame_set(2)
    if hasattr(made, "session_uid"):  # before that, only the mesh tells that it is another object
        assert sessions.session_at(made) is not former
    assert len(sessions.STATE.sessions) == 1
    assert np.array_equal(values(made), baked_shape(made, live_settings(made)).values[NAME])


def test_another_mesh_of_the_same_name_is_read_whatever_handlers_saw(stretching):
    switch(stretching)
    former = stretching.data
    name = former.name
    mesh = former.copy()
    for item in mesh.uv_layers.active.data:
        item.uv *= 0.7
    former.name, mesh.name = "former", name
    stretching.data = mesh
    bpy.data.meshes.remove(former)
    bpy.context.scene.frame_set(2)
    assert np.array_equal(values(stretching), baked_shape(stretching, live_settings(stretching)).values[NAME])


def test_an_object_that_is_removed_while_it_is_refreshed_is_forgotten(stretching, monkeypatch):
    switch(stretching)

    def remove(target, *_words):
        bpy.data.objects.remove(target)
        return target.name  # raises ReferenceError

    monkeypatch.setattr(surfaces, "deformed_positions", remove)
    bpy.context.scene.frame_set(2)
    assert sessions.live_objects() == []
    assert sessions.STATE.sessions == {}


def test_switching_off_an_object_that_is_gone_is_no_error(stretching):
    switch(stretching)
    bpy.data.objects.remove(stretching)
    sessions.switch_off(stretching, "whatever it was")
    assert sessions.live_objects() == []
