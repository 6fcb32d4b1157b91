"""Live values measure the surface, the radius and the range of a bake, so that nothing jumps when Live is pressed."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import count_computations, switch, values  # noqa: E402
from paradesc.core import choices, fitting  # noqa: E402
from paradesc.files import cache  # noqa: E402
from paradesc_blender.animation import frames, handlers, sessions  # noqa: E402
from paradesc_blender.scene import record  # noqa: E402
from paradesc_blender.settings.animation import frame_source  # noqa: E402
from scene import add_sphere, attribute_values  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
MASK = "cavity"


@pytest.fixture
def cage():
    """A dented sphere of few faces that Subdivision makes many of, measured as it is shown with the samples of Live."""
    scene = bpy.context.scene
    settings = scene.paradesc
    settings.descriptors, settings.backend, settings.samples = {MASK}, "cpu", 16
    settings.radius_percent, scene.paradesc_animation.source = 8.0, "auto"
    made = add_sphere(steps=8)
    for vertex in made.data.vertices:
        vertex.co *= 1 + 0.3 * np.cos(5 * vertex.co.x)
    made.modifiers.new("finer", "SUBSURF").levels = 2
    return made


def bake():
    """Presses the button."""
    assert bpy.ops.paradesc.bake() == {"FINISHED"}


def test_live_gives_the_values_of_a_bake_with_the_modifiers_that_are_shown(cage):
    bake()
    baked = values(cage, MASK)
    assert switch(cage) == ""
    assert sessions.session_at(cage).read.arrays.positions.shape[0] > 4 * len(baked), "the cage was measured"
    np.testing.assert_array_equal(values(cage, MASK), baked)
    cage.modifiers["finer"].show_viewport = False
    bpy.context.view_layer.update()
    sessions.refresh_window([cage])
    assert np.nanmax(np.abs(values(cage, MASK) - baked)) > 0.05, "the modifier makes no difference"


def test_the_base_mesh_stays_what_is_measured_where_it_is_chosen(cage):
    bpy.context.scene.paradesc_animation.source = "original"
    bake()
    baked = values(cage, MASK)
    assert switch(cage) == ""
    np.testing.assert_allclose(values(cage, MASK), baked, atol=1e-5)  # the radius is rounded once more as a length


def test_another_source_is_followed(cage):
    assert switch(cage) == ""
    shown = values(cage, MASK)
    bpy.context.scene.paradesc_animation.source = "original"
    session = sessions.session_at(cage)
    assert not session.has_settings(bpy.context.scene)
    sessions.refresh_window([cage])
    assert session.has_settings(bpy.context.scene)
    assert np.nanmax(np.abs(values(cage, MASK) - shown)) > 0.05


@pytest.mark.parametrize("unit", ["diagonal", "mean-edge", "absolute"])
def test_the_panel_shows_the_radius_that_live_has_fitted_as_a_bake_does(cage, monkeypatch, unit):
    settings = bpy.context.scene.paradesc
    settings.radius_unit, settings.radius_fit = unit, "medium"
    member = choices.radius_member(settings)
    bake()
    baked = getattr(settings, member)
    setattr(settings, member, 2.0 * baked)  # which counts as typed
    settings.radius_fit = "medium"
    assert switch(cage) == ""
    assert getattr(settings, member) == pytest.approx(baked, rel=1e-5)
    assert settings.radius_fit == "medium"
    done = count_computations(monkeypatch)
    bpy.context.view_layer.update()
    sessions.STATE.edited_at = 0.0
    handlers.follow_edits()
    assert not done, "what is shown was taken for another setting"


def test_a_typed_radius_stays_when_live_is_switched_on(cage):
    assert switch(cage) == ""
    assert bpy.context.scene.paradesc.radius_percent == 8.0
    assert bpy.context.scene.paradesc.radius_fit == "typed"


def test_the_fitted_radius_is_that_of_a_bake_and_is_not_fitted_to_every_frame(cage, monkeypatch):
    bpy.context.scene.paradesc.radius_fit = "broad"
    bake()
    radius = record.read(cage.data)["field_report"]["radius"]
    fits = []
    fitted = fitting.fitted
    monkeypatch.setattr(fitting, "fitted", lambda *words: (fits.append(1), fitted(*words))[1])
    assert switch(cage) == ""
    session = sessions.session_at(cage)
    assert session.results.radius == pytest.approx(radius, rel=1e-5)
    done = count_computations(monkeypatch)
    cage.modifiers.new("bend", "SIMPLE_DEFORM").angle = 1.0
    for frame in (2, 3):
        bpy.context.scene.frame_set(frame)
    assert len(done) == 1
    assert len(fits) == 1
    assert session.results.radius == pytest.approx(radius, rel=1e-5)


def test_a_session_in_another_process_has_the_radius_of_the_window_whatever_its_frame(cage, tmp_path):
    bend = cage.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis = "BEND", "Z"
    for frame, angle in ((1, 0.0), (9, 3.0)):
        bend.angle = angle
        bend.keyframe_insert("angle", frame=frame)
    bpy.context.scene.frame_set(1)
    assert switch(cage) == ""
    radius = sessions.session_at(cage).results.radius
    bpy.context.scene.frame_set(9)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "live.blend"))
    name = cage.name
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "live.blend"))
    bpy.context.scene.frame_set(8)
    loaded = bpy.data.objects[name]
    assert sessions.session_at(loaded).results.radius == pytest.approx(radius, rel=1e-6)
    switch(loaded, "OFF")
    switch(loaded)  # from here on the bent shape counts, which is larger
    assert sessions.session_at(loaded).results.radius > 1.02 * radius


def test_a_session_in_another_process_has_the_radius_of_the_newest_modifiers(cage):
    switch(cage)
    before = sessions.session_at(cage).results.radius
    cage.modifiers.new("row", "ARRAY").count = 4
    sessions.refresh_window([cage])
    radius = sessions.session_at(cage).results.radius
    assert radius > 1.5 * before
    sessions.forget_all()
    sessions.refresh_window([cage])
    assert sessions.session_at(cage).results.radius == radius


def test_the_radius_stays_at_frames_that_have_other_vertices(cage):
    bpy.context.scene.paradesc.radius_fit, row = "medium", cage.modifiers.new("row", "ARRAY")
    for frame, count in ((1, 1), (4, 4)):
        row.count = count
        row.keyframe_insert("count", frame=frame)
    bpy.context.scene.frame_set(1)
    assert switch(cage) == ""
    session = sessions.session_at(cage)
    radius, few = session.results.radius, len(session.results.coverage)
    for frame in (4, 1):
        bpy.context.scene.frame_set(frame)
        assert len(session.results.coverage) == frame * few
        assert session.results.radius == pytest.approx(radius, rel=1e-6)


def test_the_record_of_live_values_tells_another_radius(cage):
    bpy.context.scene.paradesc_animation.source = "original"
    for percent in (8.0, 16.0):
        bpy.context.scene.paradesc.radius_fit, bpy.context.scene.paradesc.radius_percent = "typed", percent
        switch(cage)
        sessions.refresh_window([cage])
        assert record.read(cage.data)["drawn"][MASK]["radius"] == sessions.session_at(cage).results.radius


def carried_values(target, name=MASK):
    """The values on the mesh that the modifiers make, of which the last one stores them."""
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return attribute_values(evaluated.data, name)


@pytest.mark.parametrize("kind", ["SUBSURF", "DECIMATE"])
def test_what_modifiers_make_has_the_values_of_a_bake_and_follows(cage, kind):
    if kind == "DECIMATE":
        cage.modifiers.new("fewer", "DECIMATE").ratio = 0.5
    bake()
    baked, objects = carried_values(cage), len(bpy.context.scene.objects)
    assert switch(cage) == ""
    np.testing.assert_allclose(carried_values(cage), baked, atol=1e-5)
    for vertex in cage.data.vertices:
        vertex.co.z *= 1 - 0.3 * np.cos(9 * vertex.co.x)
    cage.data.update()
    sessions.STATE.edited_at = 0.0
    handlers.follow_edits()
    followed = carried_values(cage)
    assert np.nanmax(np.abs(followed - baked)) > 0.05
    if kind == "SUBSURF":
        np.testing.assert_array_equal(followed, sessions.session_at(cage).results.values[MASK])
    assert len(bpy.context.scene.objects) == objects, "there is a second object"
    assert len([item for item in cage.modifiers if item.type == "NODES"]) == 1


def test_live_alone_carries_values_and_leaves_them_as_a_bake_does(cage):
    assert switch(cage) == ""
    shown = carried_values(cage, f"{MASK}_color")
    assert len(shown) > 4 * len(cage.data.vertices)
    assert np.ptp(shown[:, 0]) > 0.5
    switch(cage, "OFF")
    np.testing.assert_array_equal(carried_values(cage, f"{MASK}_color"), shown)
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}, "they are taken for painted over"


def test_another_mask_that_was_baked_stays_beside_the_live_one(cage):
    bake()
    baked = carried_values(cage)
    bpy.context.scene.paradesc.descriptors = {"convexity"}
    assert switch(cage) == ""
    np.testing.assert_array_equal(carried_values(cage), baked)
    assert np.ptp(carried_values(cage, "convexity")) > 0.1


def test_values_in_sculpt_mode_are_not_hidden_by_carried_ones(cage):
    assert switch(cage) == ""
    bpy.ops.object.mode_set(mode="SCULPT")
    sessions.refresh_window([cage])
    assert not [item for item in cage.modifiers if item.type == "NODES"]
    bpy.ops.object.mode_set(mode="OBJECT")
    sessions.refresh_window([cage])
    assert [item for item in cage.modifiers if item.type == "NODES"]


def test_renders_with_another_level_of_subdivision_have_the_radius_of_the_window(cage, tmp_path, monkeypatch):
    bend = cage.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis = "BEND", "Z"
    for frame, angle in ((1, 0.0), (9, 3.0)):
        bend.angle = angle
        bend.keyframe_insert("angle", frame=frame)
    scene = bpy.context.scene
    scene.frame_set(1)
    cage.modifiers["finer"].render_levels = 3
    assert switch(cage) == ""
    session, radii, counts = sessions.session_at(cage), [], []
    radius, compute = session.results.radius, type(session).compute

    def watched(self, request, *more):
        results = compute(self, request, *more)
        radii.append(results.radius)
        counts.append(len(request.positions))
        return results

    monkeypatch.setattr(type(session), "compute", watched)
    scene.frame_set(9)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 1, "CPU"
    scene.cycles.use_denoising = False  # which not every Blender has
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.filepath = str(tmp_path / "still.png")
    bpy.ops.render.render(write_still=True)
    sessions.refresh_window([cage])
    assert cage.paradesc_live.sentence == ""
    assert max(counts) > 3 * min(counts), "the render had the level of the window"
    assert radii == pytest.approx([radius] * len(radii), rel=1e-6)


# ---- Colors


def test_live_has_the_range_of_the_newest_bake(cage):
    group = bpy.context.scene.paradesc_live
    assert switch(cage) == ""
    before = group.ranges[MASK].maximum
    switch(cage, "OFF")
    for vertex in cage.data.vertices:
        vertex.co *= 1 + 0.3 * np.cos(9 * vertex.co.y)
    bake()
    colors, baked = values(cage, f"{MASK}_color"), record.read(cage.data)["ranges"][MASK][1]
    assert abs(baked - before) > 0.01
    assert switch(cage) == ""
    assert group.ranges[MASK].maximum == pytest.approx(baked)
    np.testing.assert_allclose(values(cage, f"{MASK}_color"), colors, atol=2e-3)  # steps of the table of colors


def test_a_range_that_was_typed_stays_whatever_is_baked(cage):
    group = bpy.context.scene.paradesc_live
    assert switch(cage) == ""
    group.ranges[MASK].maximum = 0.123
    bake()
    sessions.refresh_window([cage])
    assert group.ranges[MASK].maximum == pytest.approx(0.123)


def test_levels_recolor_live_values_at_once_and_compute_nothing(cage, monkeypatch):
    assert switch(cage) == ""
    before = values(cage, f"{MASK}_color")
    done = count_computations(monkeypatch)
    bpy.context.scene.paradesc_looks.invert = True
    np.testing.assert_allclose(values(cage, f"{MASK}_color")[:, 0], 1 - before[:, 0], atol=2e-3)
    assert not done


def test_played_frames_have_the_colors_of_a_mask(cage, tmp_path):
    group = bpy.context.scene.paradesc_animation
    group.cache_folder, group.use_scene_range, group.frame_start, group.frame_end = str(tmp_path), False, 1, 1
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert switch(cage, "CACHE") == ""
    colors = values(cage, f"{MASK}_color")
    assert np.ptp(colors[:, :3], axis=1).max() < 1e-6, "a mask is grey"
    assert np.ptp(colors[:, 0]) > 0.5


def test_live_shows_its_colors_beside_others(cage):
    other = cage.data.color_attributes.new("painted", "FLOAT_COLOR", "POINT")
    cage.data.color_attributes.active_color = other
    assert switch(cage) == ""
    assert cage.data.color_attributes.active_color.name == f"{MASK}_color"
    bpy.context.scene.paradesc.descriptors = {"convexity"}
    sessions.refresh_window([cage])
    assert cage.data.color_attributes.active_color.name == "convexity_color"


# ---- Frames


def test_frames_are_those_of_the_source_that_is_chosen_for_all(cage):
    scene = bpy.context.scene
    group = scene.paradesc_animation
    assert frames.source_of(cage, frame_source(group)) == "evaluated"
    group.source = "original"
    assert frames.source_of(cage, frame_source(group)) == "deformed"
    group.source = "auto"
    cage.modifiers.new("fewer", "DECIMATE").ratio = 0.5
    assert frames.source_of(cage, frame_source(group)) == "deformed", "frames of other vertices cannot be played"
    group.frame_source = "evaluated"
    assert frames.source_of(cage, frame_source(group)) == "evaluated", "an older file has chosen it"


def test_the_menu_of_the_frame_source_shows_what_acts_before_and_after_a_choice():
    group = bpy.context.scene.paradesc_animation
    for source, acts in (("original", "deformed"), ("deformed", "deformed"), ("evaluated", "evaluated")):
        group.source = source
        assert (group.frame_source, frame_source(group)) == ("source", acts)
    group.frame_source = "deformed"
    assert (group.frame_source, frame_source(group)) == ("deformed", "deformed")


def test_frames_have_the_fitted_radius_of_the_base_mesh(cage, tmp_path):
    scene = bpy.context.scene
    scene.paradesc.radius_fit, group = "fine", scene.paradesc_animation
    group.source, group.cache_folder = "original", str(tmp_path)
    group.use_scene_range, group.frame_start, group.frame_end = False, 1, 1
    bake()
    radius = record.read(cage.data)["field_report"]["radius"]
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    path = next(iter(cache.frames_in(cache.object_folder(tmp_path, cage.name, [])).values()))
    assert cache.read_frame(path).info["radius"][MASK] == pytest.approx(radius, rel=1e-5)


def test_another_radius_is_followed_once_the_hand_rests_and_other_settings_ask_for_nothing(cage, monkeypatch):
    assert switch(cage) == ""
    bpy.context.view_layer.update()
    sessions.STATE.edited_at = None
    done = count_computations(monkeypatch)
    bpy.context.scene.paradesc.image_to_material = True
    bpy.context.view_layer.update()
    assert sessions.STATE.edited_at is None
    bpy.context.scene.paradesc.radius_percent = 16.0
    bpy.context.view_layer.update()
    assert sessions.STATE.edited_at is not None
    sessions.STATE.edited_at = 0.0
    handlers.follow_edits()
    assert len(done) == 1
    assert sessions.session_at(cage).has_settings(bpy.context.scene)
