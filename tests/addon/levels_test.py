"""Levels of masks: contrast, brightness and inversion act at once; several meshes may share one range."""

from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.core import color_maps  # noqa: E402
from paradesc_blender.scene import record, viewports  # noqa: E402
from paradesc_blender.settings import looks as settings_looks  # noqa: E402
from paradesc_blender.show import recolor  # noqa: E402
from scene import add_sphere, attribute_values, select  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")

NAME = "convexity"


def bumpy(name="bumpy", height=0.3):
    """A sphere with a bump, which is what stands out of it."""
    target = add_sphere(name, steps=12)
    for vertex in target.data.vertices:
        if vertex.co.z > 0.9:
            vertex.co.z += height
    return target


def bake(*targets):
    """Bakes edge wear on these."""
    select(*targets)
    bpy.context.scene.paradesc.descriptors = {NAME}
    assert bpy.ops.paradesc.bake() == {"FINISHED"}


def greys(target):
    """(n,) what shaders read of the mask that is shown."""
    return attribute_values(target.data, f"{NAME}_color").reshape(-1, 4)[:, 0]


@pytest.fixture
def looks():
    return bpy.context.scene.paradesc_looks


def test_the_operator_takes_levels_of_its_own_which_then_are_the_panels(looks):
    target = bumpy()
    bake(target)
    plain = greys(target)
    assert bpy.ops.paradesc.bake(invert=True) == {"FINISHED"}
    assert looks.invert
    np.testing.assert_allclose(greys(target), 1 - plain, atol=1e-6)  # of 32-bit floats
    looks.invert, looks.brightness = False, 0.5
    assert bpy.ops.paradesc.bake() == {"FINISHED"}  # without any, the panel's stay
    assert (looks.invert, looks.brightness) == (False, 0.5)


def test_the_mask_is_the_value_over_its_range(looks):
    target = bumpy()
    bake(target)
    low, high = record.read(target.data)["ranges"][NAME]
    expected = np.clip((attribute_values(target.data, NAME) - low) / (high - low), 0, 1)
    np.testing.assert_allclose(greys(target), expected, atol=1e-6)  # of 32-bit floats


def test_levels_act_at_once_and_leave_values_and_range(looks):
    target = bumpy()
    bake(target)
    plain, values, span = greys(target), attribute_values(target.data, NAME), record.read(target.data)["ranges"][NAME]
    looks.invert = True
    np.testing.assert_allclose(greys(target), 1 - plain, atol=1e-6)
    looks.invert, looks.brightness = False, 0.5
    np.testing.assert_allclose(greys(target), np.sqrt(plain), atol=1e-6)  # exponent 4 ** -0.5
    looks.brightness, looks.contrast = 0.0, 0.5
    steep = np.tan(np.pi * 0.375)
    np.testing.assert_allclose(greys(target), np.clip(0.5 + steep * (plain - 0.5), 0, 1), atol=1e-5)
    looks.contrast = 0.0
    np.testing.assert_allclose(greys(target), plain, atol=1e-6)
    np.testing.assert_array_equal(attribute_values(target.data, NAME), values)
    assert record.read(target.data)["ranges"][NAME] == pytest.approx(span)


def test_the_next_bake_has_the_levels_too(looks):
    target = bumpy()
    bake(target)
    plain = greys(target)
    looks.invert = True
    bake(target)
    np.testing.assert_allclose(greys(target), 1 - plain, atol=1e-6)


def test_colors_that_were_painted_over_stay_when_levels_change(looks):
    target = bumpy()
    bake(target)
    colors = target.data.attributes[f"{NAME}_color"].data
    colors[0].color = (1, 0, 0, 1)
    looks.invert = True
    assert tuple(colors[0].color) == (1, 0, 0, 1)


def test_brightness_leaves_black_and_white_and_the_middle_of_two_sided_maps():
    levels = color_maps.Levels(brightness=0.7)
    np.testing.assert_array_equal(levels.applied(np.array([0.0, 1.0]), False), [0, 1])
    assert levels.applied(np.array([0.5]), True)[0] == 0.5


@pytest.mark.parametrize("contrast", [-1.0, 1.0])
def test_contrast_goes_from_the_middle_alone_to_black_and_white(contrast):
    found = color_maps.Levels(contrast=contrast).applied(np.array([0.0, 0.25, 0.75, 1.0]), False)
    np.testing.assert_allclose(found, [0.5] * 4 if contrast < 0 else [0, 0, 1, 1], atol=1e-12)


def test_meshes_on_the_same_scale_have_one_range_at_a_bake_and_by_the_switch(looks):
    one, other = bumpy("one", 0.1), bumpy("other", 0.6)
    bake(one, other)

    def spans():
        return [record.read(item.data)["ranges"][NAME][1] for item in (one, other)]

    own = spans()
    assert own[0] != pytest.approx(own[1], rel=0.1)
    looks.same_scale = True
    assert spans()[0] == spans()[1]
    looks.same_scale = False
    assert spans() == pytest.approx(own)
    looks.same_scale = True
    together = spans()
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    assert spans() == together
    bake(one, other)
    assert spans()[0] == spans()[1]


@pytest.mark.parametrize("by", ["bake", "switch"])
def test_the_scale_that_two_equal_meshes_share_is_that_of_each(looks, by):
    one, other = bumpy("one"), bumpy("other")
    bake(one, other)
    (own,) = {record.read(item.data)["ranges"][NAME][1] for item in (one, other)}
    looks.same_scale = True
    if by == "bake":
        bake(one, other)
    spans = [record.read(item.data)["ranges"][NAME][1] for item in (one, other)]
    assert spans == pytest.approx([own, own], rel=1e-6)  # of areas in 32-bit positions


def test_recolor_gives_all_masks_of_selected_meshes_the_same_scale_in_edit_mode_too(looks):
    one, other = bumpy("one", 0.1), bumpy("other", 0.6)
    bake(one)
    bake(other)
    looks.same_scale = True  # of the one that is selected now
    select(one, other)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.paradesc.recolor(every=True) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    spans = [record.read(item.data)["ranges"][NAME][1] for item in (one, other)]
    assert spans[0] == spans[1]


def test_masks_that_are_not_shown_get_the_same_scale_and_lose_it_too_while_levels_are_of_the_shown_one(looks):
    one, other = bumpy("one", 0.1), bumpy("other", 0.6)
    select(one, other)
    bpy.context.scene.paradesc.descriptors = {"ambient_openness", NAME}
    bpy.ops.paradesc.bake()
    bpy.ops.paradesc.show(name=NAME)

    def spans(name):
        return [tuple(record.read(item.data)["ranges"][name]) for item in (one, other)]

    own = {name: spans(name) for name in ("ambient_openness", NAME)}
    assert all(len(set(found)) == 2 for found in own.values())
    looks.same_scale = True
    assert all(len(set(spans(name))) == 1 for name in own)
    looks.same_scale = False
    assert {name: spans(name) for name in own} == own
    looks.contrast = 0.5
    drawn = record.read(one.data)["drawn"]
    assert [drawn[name]["contrast"] for name in own] == [0.0, 0.5]


def test_a_listener_hears_a_change_once_however_often_the_add_on_was_enabled(monkeypatch):
    monkeypatch.setattr(settings_looks, "LISTENERS", [])
    heard = []

    def imported():
        """The listener of one import."""

        def listener(scene, setting):
            heard.append((scene.name, setting))

        return listener

    for _ in range(2):
        settings_looks.listen(imported())
    bpy.context.scene.paradesc_looks.invert = True
    assert heard == [("Scene", "invert")]
    settings_looks.ignore(imported())
    settings_looks.ignore(imported())
    assert settings_looks.LISTENERS == []


def test_meshes_with_several_fitted_radii_have_one_range_for_each_descriptor(looks):
    settings = bpy.context.scene.paradesc
    settings.radius_fit, settings.more_radii, looks.same_scale = "broad", "7", True
    one, other = bumpy("one"), add_sphere("other", steps=30)
    bake(one, other)
    ranges = {**record.read(one.data)["ranges"], **record.read(other.data)["ranges"]}
    assert len(ranges) == 3  # the fitted radius of each mesh, and the one that both have
    assert len(set(map(tuple, ranges.values()))) == 1


def test_a_bake_tells_how_much_of_a_mask_is_black_or_white(looks):
    target = bumpy()
    bake(target)
    drawn = record.read(target.data)["drawn"][NAME]
    looks.invert = True
    turned = record.read(target.data)["drawn"][NAME]
    assert (turned["dark"], turned["bright"]) == pytest.approx((drawn["bright"], drawn["dark"]), abs=1e-6)
    looks.invert, looks.contrast = False, 1.0
    assert sum(record.read(target.data)["drawn"][NAME][word] for word in ("dark", "bright")) > 0.99


def test_white_is_at_most_the_98th_percentile_of_what_is_not_black_and_leaves_a_share_bright():
    values = np.concatenate([np.zeros(8000), np.linspace(0.0, 0.3, 1900), np.full(100, 1.0)])
    white = color_maps.strong(values, None, 0.0, 1.0)
    seen = values[values > color_maps.NOT_BLACK]
    assert white <= np.percentile(seen, 98)
    assert (values > white / 2).mean() == pytest.approx(0.04, abs=0.001)
    assert color_maps.strong(np.zeros(10), None, 0.0, 1.0) == color_maps.LEAST_WHITE


def test_black_is_what_most_of_the_surface_has_but_less_than_an_edge():
    limbs = np.concatenate([np.full(9000, 0.15), np.full(1000, 0.9)])
    assert color_maps.usual(limbs, None, 0.0, 1.0) == pytest.approx(0.15)
    assert color_maps.usual(limbs[::-1], np.repeat([1.0, 0.0], 5000), 0.0, 1.0) == pytest.approx(0.15)
    assert color_maps.usual(np.full(10, 0.9), None, 0.0, 1.0) == color_maps.MOST_USUAL
    assert color_maps.usual(np.zeros(10), None, 0.0, 1.0) == color_maps.usual(np.full(3, np.nan), None, 0.0, 1.0) == 0.0


def test_white_goes_by_area_not_by_the_number_of_vertices():
    values = np.concatenate([np.full(900, 0.9), np.full(100, 0.3)])  # many small faces in a detail
    areas = np.concatenate([np.full(900, 1e-5), np.full(100, 1.0)])
    assert color_maps.strong(values, areas, 0.0, 1.0) == pytest.approx(0.3)
    assert color_maps.strong(values, None, 0.0, 1.0) == pytest.approx(0.9)


def test_a_range_of_one_side_acts_at_once_and_is_as_a_bake_makes_it(looks):
    target = bumpy()
    bpy.context.scene.paradesc.descriptors = {"mean_curvature"}
    select(target)
    shown = []
    for symmetric in (True, False, True):
        looks.symmetric = symmetric
        shown.append(record.read(target.data).get("ranges", {}).get("mean_curvature"))
        bpy.ops.paradesc.bake()
        baked = record.read(target.data)["ranges"]["mean_curvature"]
        assert shown[-1] in (None, pytest.approx(baked))
    assert shown[2][0] < shown[1][0]
    assert shown[2][0] == pytest.approx(-shown[2][1])


def test_resetting_research_settings_recolors_what_is_shown(looks):
    target = bumpy()
    bake(target)
    looks.color_map = "blue-red"
    usual = greys(target)
    looks.neutral, looks.use_neutral = 0.7, True
    assert not np.allclose(greys(target), usual)
    assert bpy.ops.paradesc.reset_research() == {"FINISHED"}
    assert greys(target) == pytest.approx(usual)


def test_levels_that_a_script_sets_without_a_window_wait_for_recolor(looks, monkeypatch):
    target = bumpy()
    bake(target)
    before, context = greys(target), SimpleNamespace(scene=bpy.context.scene)
    monkeypatch.setattr(recolor, "bpy", SimpleNamespace(context=context, types=bpy.types))
    looks.contrast = 0.5
    assert viewports.wanted(context) == viewports.PLAIN
    assert greys(target) == pytest.approx(before)
