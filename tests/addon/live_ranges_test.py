"""Which values the colors of live objects span, and that the panels say so."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import NAME, count_computations, switch, values  # noqa: E402
from paradesc.core import color_maps  # noqa: E402
from paradesc_blender.animation import painting, sessions  # noqa: E402
from paradesc_blender.scene import record  # noqa: E402
from paradesc_blender.show import recolor  # noqa: E402
from scene import add_sphere  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def colored(target, low, high, **more):
    """Returns whether the colors on the mesh span this range."""
    shown = color_maps.ValueRange(low, high, True, 0.0, **more)
    expected = color_maps.linear_rgba(color_maps.colors(values(target), shown))
    return np.abs(values(target, f"{NAME}_color") - expected).max() < 2e-3


def stored():
    """The range that the scene holds."""
    item = bpy.context.scene.paradesc_live.ranges[NAME]
    return item.minimum, item.maximum


# ---- Held at every frame


def test_colors_of_all_frames_are_by_the_first_frames_range(stretching):
    switch(stretching)
    shown = sessions.session_at(stretching).results.shown(NAME)
    bpy.context.scene.frame_set(3)
    expected = color_maps.linear_rgba(color_maps.colors(values(stretching), shown))
    np.testing.assert_allclose(values(stretching, f"{NAME}_color"), expected, atol=1e-3)
    own = sessions.session_at(stretching).results.shown(NAME)
    assert own.maximum > 1.2 * shown.maximum


def test_a_changed_range_recolors_without_computing(stretching, monkeypatch):
    switch(stretching)
    before = values(stretching)
    done = count_computations(monkeypatch)
    item = bpy.context.scene.paradesc_live.ranges[NAME]
    item.minimum, item.maximum = 0.0, 10.0
    expected = color_maps.linear_rgba(color_maps.colors(before, color_maps.ValueRange(0.0, 10.0, True, 0.0)))
    np.testing.assert_allclose(values(stretching, f"{NAME}_color"), expected, atol=1e-3)
    assert not done


def test_range_of_this_frame_holds_all_live_objects(stretching):
    switch(stretching)
    small = add_sphere("small", steps=6)
    small.data.transform([[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 1]])
    assert switch(small) == ""
    assert bpy.context.scene.paradesc_live.ranges[NAME].maximum < 0.7
    assert bpy.ops.paradesc.live_range() == {"FINISHED"}
    assert bpy.context.scene.paradesc_live.ranges[NAME].maximum > 0.9


def test_what_was_baked_and_is_not_live_keeps_its_range_and_can_be_recolored(stretching):
    bpy.context.scene.paradesc.descriptors = {"curvedness"}
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    before = recolor.stored_range(stretching.data, "curvedness")
    bpy.context.scene.paradesc.descriptors = {NAME}
    assert switch(stretching) == ""
    assert {NAME, "curvedness"} <= set(record.read(stretching.data)["ranges"])
    assert recolor.stored_range(stretching.data, "curvedness") == before
    assert bpy.ops.paradesc.recolor(every=True) == {"FINISHED"}


# ---- What the Colors panel says


def test_a_fixed_range_holds_at_once_and_at_every_frame(stretching):
    switch(stretching)
    group = bpy.context.scene.paradesc_looks
    group.minimum, group.maximum = -2.0, 3.0
    group.span = "fixed"
    assert colored(stretching, -2.0, 3.0)
    bpy.context.scene.frame_set(3)
    assert colored(stretching, -2.0, 3.0)
    group.maximum = 4.0
    assert colored(stretching, -2.0, 4.0)
    group.span = "auto"
    assert colored(stretching, *stored())


def test_other_percentiles_take_the_range_of_this_frame(stretching):
    switch(stretching)
    first = stored()
    bpy.context.scene.frame_set(3)
    assert stored() == first
    group = bpy.context.scene.paradesc_looks
    group.span, group.percentile = "percentile", 10.0
    found = values(stretching)
    wanted = max(abs(np.percentile(found, [10, 90])))
    assert stored() == pytest.approx((-wanted, wanted), rel=1e-5)
    assert colored(stretching, *stored())
    held = stored()
    bpy.context.scene.frame_set(1)
    assert stored() == held
    assert colored(stretching, *held)


def test_another_color_map_keeps_the_range_and_is_seen_at_once(stretching):
    switch(stretching)
    bpy.context.scene.frame_set(3)
    held = stored()
    bpy.context.scene.paradesc_looks.color_map = "purple-green"
    assert stored() == held
    assert colored(stretching, *held, map_name="purple-green")


def test_ranges_of_files_without_the_colors_they_follow_from_are_kept(stretching):
    group = bpy.context.scene.paradesc_live
    painting.add_range(group, NAME, -7.0, 7.0)
    switch(stretching)
    assert stored() == (-7.0, 7.0)
    assert colored(stretching, -7.0, 7.0)


def test_a_range_that_was_typed_holds_until_the_colors_are_set_otherwise(stretching):
    switch(stretching)
    item = bpy.context.scene.paradesc_live.ranges[NAME]
    item.minimum, item.maximum = -9.0, 9.0
    bpy.context.scene.frame_set(2)
    assert colored(stretching, -9.0, 9.0)
    bpy.context.scene.paradesc_looks.symmetric = False
    assert stored()[0] > -9.0
    assert colored(stretching, *stored())


def test_no_range_is_looked_for_while_one_is_held(stretching, monkeypatch):
    switch(stretching)
    monkeypatch.setattr(color_maps.np, "percentile", None)
    bpy.context.scene.frame_set(3)
    assert stretching.paradesc_live.sentence == ""


def test_the_legend_knows_unit_and_radius_of_live_values(stretching):
    switch(stretching)
    drawn = record.read(stretching.data)["drawn"][NAME]
    assert drawn["unit"] == "1/length"
    assert drawn["radius"] == pytest.approx(sessions.session_at(stretching).results.radius)
