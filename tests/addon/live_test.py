"""Live mode: values follow frames and edits, in Blender without a window."""

import dataclasses

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import animated  # noqa: E402
from live_values import baked_shape, count_computations, live_settings, switch, values  # noqa: E402
from paradesc.core import color_maps, job  # noqa: E402
from paradesc_blender.animation import handlers, live, painting, sessions, surfaces  # noqa: E402
from paradesc_blender.scene import mesh_io, source_meshes  # noqa: E402
from paradesc_blender.settings import hooks, properties  # noqa: E402
from paradesc_blender.ui import live_panel  # noqa: E402
from scene import add_sphere, attribute_values, subdivide  # noqa: E402

NAME = "mean_curvature"


pytestmark = pytest.mark.usefixtures("registered")


def edit_and_rest():
    """Does what the event loop does after an edit, once editing pauses."""
    bpy.context.view_layer.update()
    sessions.STATE.edited_at = None if sessions.STATE.edited_at is None else 0.0
    handlers.follow_edits()


@pytest.mark.parametrize("frame", [2, 3])
def test_every_frame_has_the_values_of_a_bake_of_its_shape(stretching, frame):
    assert switch(stretching) == ""
    at_first = values(stretching)
    bpy.context.scene.frame_set(frame)
    expected = baked_shape(stretching, live_settings(stretching))
    assert np.array_equal(values(stretching), expected.values[NAME])
    assert np.array_equal(values(stretching, "coverage"), expected.coverage)
    assert np.abs(values(stretching) - at_first).max() > 0.05


def test_undefined_values_are_grey():
    shown = color_maps.ValueRange(0.0, 1.0, False)
    found = painting.colors(np.float32([np.nan, 0, 1, 7]), shown, painting.color_table(shown))
    expected = color_maps.linear_rgba(color_maps.colors(np.array([np.nan, 0, 1, 1]), shown))
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_the_same_shape_is_computed_once(stretching, monkeypatch):
    done = count_computations(monkeypatch)
    switch(stretching)
    bpy.context.scene.frame_set(1)
    edit_and_rest()
    assert len(done) == 1
    bpy.context.scene.frame_set(2)
    for _ in range(3):  # our own writing is an edit of the mesh, too
        edit_and_rest()
    assert len(done) == 2


def test_what_another_tool_wrote_over_is_put_back(stretching, monkeypatch):
    switch(stretching)
    before = values(stretching)
    done = count_computations(monkeypatch)
    stretching.data.attributes[NAME].data[3].value = 99.0
    stretching.data.attributes.remove(stretching.data.attributes["coverage"])
    bpy.context.scene.frame_set(1)
    assert np.array_equal(values(stretching), before)
    assert np.isfinite(values(stretching, "coverage")).all()
    assert not done


@pytest.mark.parametrize(("name", "member", "other"), [(NAME, "value", 99.0), (f"{NAME}_color", "color", (0, 1, 0, 1))])
def test_one_value_alone_that_another_tool_wrote_over_is_put_back(stretching, name, member, other):
    switch(stretching)
    before = values(stretching, name)
    setattr(stretching.data.attributes[name].data[3], member, other)
    assert not np.array_equal(values(stretching, name), before)
    bpy.context.scene.frame_set(1)
    assert np.array_equal(values(stretching, name), before)


def test_the_radius_does_not_change_with_the_pose(stretching):
    switch(stretching)
    rest = job.run(
        mesh_io.read_object(stretching, corner_normals=False), properties.job_settings(bpy.context.scene.paradesc)
    )
    bpy.context.scene.frame_set(3)
    assert sessions.session_at(stretching).results.radius == pytest.approx(rest.radius, rel=1e-6)


@pytest.mark.slow
def test_the_viewport_takes_smaller_buffers_where_the_radius_spans_texels_enough(stretching):
    settings, group = bpy.context.scene.paradesc, bpy.context.scene.paradesc_live
    settings.buffer_size = group.buffer_size = 1024
    switch(stretching)
    session = sessions.session_at(stretching)
    size = session.stream.settings.options.buffer_size
    assert size < 1024
    assert session.results.field_report["radius_in_texels"] >= 5.4
    bpy.context.scene.frame_set(3)
    assert session.results.settings.options.buffer_size == size
    settings.radius_percent = 1.0
    bpy.context.scene.frame_set(2)
    assert session.results.settings.options.buffer_size == 1024


# ---- Edits


def test_an_edit_of_the_shape_is_followed(stretching):
    switch(stretching)
    before = values(stretching)
    stretching.data.shape_keys.key_blocks[0].data[7].co *= 1.1
    edit_and_rest()
    assert np.abs(values(stretching) - before).max() > 0.05


def test_edit_mode_is_waited_for(stretching):
    switch(stretching)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.scene.frame_set(3)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(2, 2, 2))
    edit_and_rest()
    assert stretching.paradesc_live.mode == "LIVE"
    bpy.ops.object.mode_set(mode="OBJECT")
    edit_and_rest()
    assert np.array_equal(values(stretching), baked_shape(stretching, live_settings(stretching)).values[NAME])


def test_another_topology_is_followed(stretching):
    switch(stretching)
    subdivide()
    bpy.context.scene.frame_set(3)
    assert stretching.paradesc_live.sentence == ""
    assert np.array_equal(values(stretching), baked_shape(stretching, live_settings(stretching)).values[NAME])


def test_a_moved_uv_map_is_followed(stretching):
    switch(stretching)
    layer = stretching.data.uv_layers.active
    for item in layer.data:
        item.uv *= 0.9
    stretching.data.update()
    edit_and_rest()
    bpy.context.scene.frame_set(2)
    assert np.array_equal(values(stretching), baked_shape(stretching, live_settings(stretching)).values[NAME])


def test_a_changed_setting_is_followed(stretching):
    switch(stretching)
    bpy.context.scene.paradesc.descriptors = {"curvedness", "shape_index"}
    bpy.context.scene.frame_set(2)
    expected = baked_shape(stretching, live_settings(stretching))
    for name in ("curvedness", "shape_index"):
        assert np.array_equal(values(stretching, name), expected.values[name], equal_nan=True)


def test_a_renamed_object_goes_on(stretching):
    switch(stretching)
    stretching.name = "ball"
    bpy.context.scene.frame_set(3)
    assert len(sessions.STATE.sessions) == 1
    assert np.array_equal(values(stretching), baked_shape(stretching, live_settings(stretching)).values[NAME])


# ---- What goes wrong


def test_modifiers_that_change_the_vertices_are_one_sentence(stretching, caplog):
    switch(stretching)
    before = values(stretching)
    stretching.modifiers.new("fewer", "DECIMATE").ratio = 0.5
    bpy.context.scene.frame_set(3)
    assert stretching.paradesc_live.mode == "OFF"
    assert "take vertices away" in stretching.paradesc_live.sentence
    assert stretching.paradesc_live.sentence in caplog.text  # for the log of a farm
    assert np.array_equal(values(stretching), before)
    stretching.modifiers.clear()
    assert switch(stretching) == ""


APPENDING = {
    "SUBSURF": {"levels": 2},
    "MIRROR": {"use_mirror_merge": True, "merge_threshold": 0.1},
    "SOLIDIFY": {"thickness": 0.1, "use_rim": True},
    "ARRAY": {"count": 3, "use_merge_vertices": True, "merge_threshold": 0.1},
}


@pytest.mark.parametrize("kind", APPENDING)
def test_vertices_that_modifiers_append_come_after_the_original_ones(stretching, kind):
    modifier = stretching.modifiers.new("more", kind)
    for name, value in APPENDING[kind].items():
        setattr(modifier, name, value)
    place = source_meshes.read(stretching, "evaluated").vertices
    assert np.array_equal(place, np.arange(len(stretching.data.vertices)))
    assert kind in surfaces.APPENDING
    assert switch(stretching) == ""
    bpy.context.scene.frame_set(3)
    assert stretching.paradesc_live.sentence == ""
    evaluated = stretching.evaluated_get(bpy.context.evaluated_depsgraph_get())
    positions = mesh_io.read_positions(evaluated.data)[: len(place)]
    arrays = dataclasses.replace(mesh_io.read_object(stretching, corner_normals=False), positions=positions)
    assert np.array_equal(values(stretching), job.run(arrays, live_settings(stretching)).values[NAME])


def test_a_mirror_that_cuts_is_one_sentence(stretching):
    modifier = stretching.modifiers.new("cut", "MIRROR")
    modifier.use_bisect_axis[0] = True
    assert "take vertices away" in switch(stretching)


def test_positions_that_are_not_finite_are_one_sentence(stretching):
    switch(stretching)
    stretching.data.shape_keys.key_blocks[1].data[3].co.x = float("nan")
    bpy.context.scene.frame_set(3)
    assert stretching.paradesc_live.mode == "OFF"
    assert "3" in stretching.paradesc_live.sentence


def test_a_frame_that_is_smaller_than_the_radius_is_undefined_and_live_goes_on(stretching):
    switch(stretching)
    sound = values(stretching.data)
    for point in stretching.data.shape_keys.key_blocks[1].data:
        point.co = 0, 0, 0
    bpy.context.scene.frame_set(3)
    assert np.isnan(values(stretching.data)).all()
    assert "smaller than the radius at this frame" in live_panel.live_sentence(stretching)
    bpy.context.scene.frame_set(1)
    assert stretching.paradesc_live.mode == "LIVE"
    np.testing.assert_array_equal(values(stretching.data), sound)
    assert live_panel.live_sentence(stretching) == ""


def test_what_nobody_thought_of_is_one_sentence(stretching, monkeypatch):
    switch(stretching)

    def fail(*_words):
        raise ZeroDivisionError("nobody thought of this")

    monkeypatch.setattr(surfaces, "deformed_positions", fail)
    bpy.context.scene.frame_set(2)
    assert "nobody thought of this" in stretching.paradesc_live.sentence


def test_a_shared_mesh_has_one_live_object(stretching):
    switch(stretching)
    twin = bpy.data.objects.new("twin", stretching.data)
    bpy.context.collection.objects.link(twin)
    assert "sphere" in switch(twin)
    assert twin.paradesc_live.mode == "OFF"
    assert stretching.paradesc_live.mode == "LIVE"


def test_a_linked_duplicate_of_a_live_object_leaves_the_mesh_to_the_first(stretching):
    switch(stretching)
    twin = stretching.copy()
    bpy.context.collection.objects.link(twin)
    twin.modifiers.new("bend", "SIMPLE_DEFORM").angle = 2.0
    assert twin.paradesc_live.mode == "LIVE"
    for frame in (2, 3):
        bpy.context.scene.frame_set(frame)
        assert np.array_equal(values(stretching), baked_shape(stretching, live_settings(stretching)).values[NAME])
    assert sessions.session_at(twin) is None
    assert "sphere" in live_panel.live_sentence(twin)
    assert live_panel.live_sentence(stretching) == ""
    twin.data = stretching.data.copy()
    bpy.context.scene.frame_set(2)
    assert sessions.session_at(twin) is not None
    assert live_panel.live_sentence(twin) == ""


def test_attributes_that_are_not_ours_are_left_alone(stretching):
    stretching.data.attributes.new(NAME, "INT", "FACE")
    assert switch(stretching) == ""
    assert stretching.data.attributes[NAME].data_type == "INT"
    assert f"{NAME}_color" not in stretching.data.attributes
    for frame in (2, 3):
        bpy.context.scene.frame_set(frame)
        expected = baked_shape(stretching, live_settings(stretching)).values[NAME]
        assert np.array_equal(attribute_values(stretching.data, f"{NAME}_2"), expected)


def test_a_removed_object_is_forgotten(stretching):
    switch(stretching)
    bpy.data.objects.remove(stretching)
    bpy.context.scene.frame_set(2)
    assert sessions.STATE.sessions == {}


# ---- Switches, files


@pytest.mark.parametrize("before", [False, True])
def test_the_interface_lock_is_given_back(stretching, before):
    render = bpy.context.scene.render
    render.use_lock_interface = before
    switch(stretching)
    assert render.use_lock_interface
    switch(stretching, "OFF")
    assert render.use_lock_interface == before


def test_the_interface_lock_is_given_back_when_the_object_is_deleted(stretching):
    switch(stretching)
    with bpy.context.temp_override(selected_objects=[stretching]):
        bpy.ops.object.delete()
    bpy.context.view_layer.update()
    assert not bpy.context.scene.render.use_lock_interface


def test_the_interface_lock_stays_for_the_other_object(stretching):
    other = add_sphere("other", steps=4)
    switch(stretching), switch(other)
    switch(stretching, "OFF")
    assert bpy.context.scene.render.use_lock_interface
    switch(other, "OFF")
    assert not bpy.context.scene.render.use_lock_interface


def test_switched_off_values_stay_and_nothing_is_kept(stretching):
    switch(stretching)
    bpy.context.scene.frame_set(2)
    before = values(stretching)
    switch(stretching, "OFF")
    bpy.context.scene.frame_set(3)
    assert np.array_equal(values(stretching), before)
    assert sessions.STATE.sessions == {}


def test_a_loaded_file_is_live_again(stretching, tmp_path):
    switch(stretching)
    path = str(tmp_path / "live.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert sessions.STATE.sessions == {}
    bpy.ops.wm.open_mainfile(filepath=path)
    made = bpy.data.objects["sphere"]
    bpy.context.scene.frame_set(3)
    assert np.array_equal(values(made), baked_shape(made, live_settings(made)).values[NAME])
    switch(made, "OFF")
    assert not bpy.context.scene.render.use_lock_interface


def test_every_handler_is_hung_in_once_and_taken_out():
    def count():
        return sum(
            getattr(hook, "__module__", "").startswith("paradesc_blender.animation.handlers")
            for name in handlers.HANDLERS
            for hook in getattr(bpy.app.handlers, name)
        )

    hooks.add(handlers)
    assert count() == len(handlers.HANDLERS)
    hooks.remove(handlers)
    assert count() == 0
    hooks.add(handlers)


def test_values_of_several_radii_are_called_as_asked(stretching):
    bpy.context.scene.paradesc.more_radii = "12"
    assert switch(stretching) == ""
    bpy.context.scene.frame_set(3)
    asked = properties.job_settings(bpy.context.scene.paradesc).value_names()
    expected = baked_shape(stretching, live_settings(stretching))
    for name, computed in zip(asked, expected.values, strict=True):
        assert np.array_equal(values(stretching, name), expected.values[computed])
    assert len(asked) == 2


def test_without_descriptors_live_says_so_as_a_bake_does(stretching):
    switch(stretching)
    bpy.context.scene.paradesc.descriptors = set()
    bpy.context.scene.frame_set(2)
    assert stretching.paradesc_live.sentence == "No descriptor is chosen; choose at least one."


def test_the_world_is_refused_in_one_sentence(stretching):
    bpy.context.scene.paradesc.space = "world"
    assert "object space" in switch(stretching)


def test_colors_are_those_of_the_scene_that_is_evaluated(stretching):
    other = bpy.data.scenes.new("other")
    other.collection.objects.link(stretching)
    other.paradesc.backend, other.paradesc.buffer_size, other.paradesc.descriptors = "software", 128, {NAME}
    other.paradesc_looks.color_map = "grey"
    layer = other.view_layers[0]
    layer.update()
    session = live.Session()
    assert session.refresh(stretching, layer.depsgraph, other)
    session.close()
    assert np.ptp(attribute_values(stretching.data, f"{NAME}_color")[:, :3], axis=1).max() < 1e-3


def test_an_object_of_two_scenes_has_the_values_of_the_one_whose_frame_changed_last(monkeypatch):
    target = animated.bent_cylinder()
    first, second = bpy.context.scene, bpy.data.scenes.new("second")
    for item in first.objects:
        second.collection.objects.link(item)
    for scene in (first, second):
        scene.paradesc.backend, scene.paradesc.samples, scene.paradesc.buffer_size = "software", 32, 256
        scene.paradesc.descriptors = {NAME}
    shown = [(scene, scene.view_layers[0]) for scene in (first, second)]
    assert switch(target) == ""
    straight = values(target)
    done = count_computations(monkeypatch)
    second.frame_set(20)
    bent = values(target)
    assert np.nanmax(np.abs(bent - straight)) > 0.05
    assert sessions.place_of(target, shown) == shown[1]
    for _ in range(3):  # our own writing is an edit in both scenes
        shown[1][1].update()
        sessions.refresh(second, shown[1][1].depsgraph, [target])
    assert len(done) == 1
    assert np.array_equal(values(target), bent, equal_nan=True)
    first.frame_set(1)
    assert sessions.place_of(target, shown) == shown[0]
    assert np.array_equal(values(target), straight, equal_nan=True)
    assert sessions.place_of(target, shown[1:]) == shown[1], "the only one that is shown"
    assert len(done) == 2
