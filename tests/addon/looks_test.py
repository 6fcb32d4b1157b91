"""Baked values in other colors and places: maps, legends, channels, vertex groups, masks. Runs inside Blender."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from mesh_io_test import made_up_results  # noqa: E402

import paradesc_blender  # noqa: E402
from paradesc.core import color_maps, job  # noqa: E402
from paradesc_blender.scene import delivery, mesh_io, record, sculpt_masks  # noqa: E402
from paradesc_blender.settings import looks  # noqa: E402
from paradesc_blender.show import channels, overlay, recolor  # noqa: E402
from scene import add_sphere, attribute_values, fingerprint  # noqa: E402

NAMES = ("mean_curvature", "curvedness")


pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def baked():
    """A sphere with made-up values from -1 to 1 and from 0 to 2; vertex 5 has none of the latter."""
    target = add_sphere(steps=4)
    results = made_up_results(target, NAMES)
    results.values["mean_curvature"][5] = np.nan
    delivery.deliver(target, results)
    return target


def group():
    """The scene's settings."""
    return bpy.context.scene.paradesc_looks


def colors_of(target, name="mean_curvature"):
    """(n, 3) display colors of a descriptor."""
    return color_maps.linear_to_srgb(attribute_values(target.data, f"{name}_color")[:, :3])


def corner_values(mesh, name):
    """(corner_count, 4) of a color attribute."""
    values = np.empty(4 * len(mesh.loops), np.float32)
    mesh.attributes[name].data.foreach_get("color", values)
    return values.reshape(-1, 4)


def test_recolor_changes_the_colors_shown_and_no_value(baked):
    values, other = attribute_values(baked.data, "mean_curvature"), colors_of(baked, "curvedness")
    group().color_map = "grey"
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    defined = np.isfinite(values)
    assert np.ptp(colors_of(baked)[defined], axis=1).max() < 1e-3
    assert np.ptp(colors_of(baked)[5]) > 0.2  # what has no value is violet in grey maps
    assert np.array_equal(attribute_values(baked.data, "mean_curvature"), values, equal_nan=True)
    assert np.array_equal(colors_of(baked, "curvedness"), other)
    bpy.ops.paradesc.recolor(every=True)
    assert np.ptp(colors_of(baked, "curvedness"), axis=1).max() < 1e-3


def test_fixed_range_is_that_of_colors_and_legend(baked):
    group().span, group().minimum, group().maximum = "fixed", -0.5, 0.25
    bpy.ops.paradesc.recolor()
    title, shown = overlay.lines_of(baked.data, "mean_curvature")
    assert title == "Mean Curvature (1/length)"
    assert (shown.minimum, shown.maximum, shown.neutral) == (-0.5, 0.25, 0.0)
    expected = color_maps.colors(attribute_values(baked.data, "mean_curvature"), shown)
    np.testing.assert_allclose(colors_of(baked), expected, atol=1e-5)


def test_range_that_is_none_is_one_sentence_and_changes_nothing(baked):
    group().span, group().minimum, group().maximum = "fixed", 1.0, 1.0
    before = fingerprint(baked)
    with pytest.raises(RuntimeError, match="set a larger maximum"):
        bpy.ops.paradesc.recolor()
    assert fingerprint(baked) == before


def test_next_bake_has_the_colors_of_the_scene(baked, monkeypatch):
    group().color_map, group().span, group().percentile = "heat", "percentile", 0.0
    results = made_up_results(baked, NAMES)
    results.mesh_report["mean_edge"], results.field_report["undefined_vertices"] = 0.0, 0
    results.field_reports = {"": results.field_report}
    monkeypatch.setattr(job, "run", lambda *_words: results)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    shown = recolor.stored_range(baked.data, "curvedness")
    assert (shown.map_name, shown.minimum, shown.maximum) == ("heat", 0.0, 2.0)
    expected = color_maps.MAPS["heat"].function(attribute_values(baked.data, "curvedness").astype(float) / 2)
    np.testing.assert_allclose(colors_of(baked, "curvedness"), expected, atol=1e-3)


def test_later_bake_of_another_descriptor_keeps_the_legend_of_the_first(baked):
    before = recolor.stored_range(baked.data, "curvedness")
    delivery.deliver(baked, made_up_results(baked, ("shape_index",)))
    assert recolor.stored_range(baked.data, "curvedness") == before
    assert recolor.baked_names(baked.data) == ["curvedness", "mean_curvature", "shape_index"]


def test_recolor_and_material_take_all_selected_meshes(baked):
    other = add_sphere("other", steps=4)
    delivery.deliver(other, made_up_results(other, NAMES))
    bare = add_sphere("bare", steps=2)
    bpy.context.view_layer.objects.active = baked
    assert [item.select_get() for item in (baked, other, bare)] == [True] * 3
    group().color_map = "grey"
    bpy.ops.paradesc.recolor()
    bpy.ops.paradesc.make_material(kind="flat")
    for target in (baked, other):
        assert np.ptp(colors_of(target)[0]) < 1e-3
        assert target.data.materials[0].name.startswith("Paradesc Mean Curvature")
    assert len(bare.data.materials) == 0
    bpy.ops.paradesc.remove_material()
    assert not [item.name for item in bpy.data.materials if "Paradesc" in item.name]


def test_recolor_in_edit_mode_stays_in_edit_mode(baked):
    group().color_map = "grey"
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    assert baked.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.ptp(colors_of(baked)[0]) < 1e-3


def test_recolor_leaves_edit_mode_to_the_objects_that_were_in_it(baked):
    other = add_sphere("other", steps=4)
    bpy.context.view_layer.objects.active = baked
    bpy.ops.object.mode_set(mode="EDIT")
    assert (baked.mode, other.mode) == ("EDIT", "EDIT")
    other.select_set(False)
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    assert (baked.mode, other.mode) == ("EDIT", "EDIT")
    assert (baked.select_get(), other.select_get()) == (True, False)
    bpy.ops.object.mode_set(mode="OBJECT")


def test_shown_descriptor_is_the_one_chosen(baked):
    assert recolor.shown_name(baked.data) == "mean_curvature"
    bpy.ops.paradesc.show(name="curvedness")
    assert recolor.shown_name(baked.data) == "curvedness"
    colors = baked.data.color_attributes
    assert colors[colors.render_color_index].name == "curvedness_color"


def test_legend_is_there_only_where_our_colors_are_seen(baked):
    assert overlay.name_in("SOLID", "VERTEX", baked) == "mean_curvature"
    assert overlay.name_in("SOLID", "MATERIAL", baked) == ""
    assert overlay.name_in("RENDERED", "VERTEX", baked) == ""
    bpy.ops.paradesc.make_material(kind="colors")
    assert overlay.name_in("RENDERED", "MATERIAL", baked) == "mean_curvature"
    bpy.ops.paradesc.make_material(kind="cavity")
    assert overlay.name_in("RENDERED", "MATERIAL", baked) == ""
    own = baked.data.color_attributes.new("painted", "FLOAT_COLOR", "POINT")
    baked.data.color_attributes.active_color = own
    assert overlay.name_in("SOLID", "VERTEX", baked) == ""


def test_descriptor_of_a_newer_version_is_left_alone(baked):
    mesh = baked.data
    for name, kind in (("wobbliness", "FLOAT"), ("wobbliness_color", "FLOAT_COLOR")):
        mesh.attributes.new(name, kind, "POINT")
    stored = record.read(mesh)
    mesh[record.PROPERTY] = {**stored, "attributes": [*stored["attributes"], "wobbliness", "wobbliness_color"]}
    assert recolor.baked_names(mesh) == ["curvedness", "mean_curvature"]
    assert bpy.ops.paradesc.recolor(every=True) == {"FINISHED"}


def test_a_switch_of_an_operator_does_not_stay_on_for_the_next_click():
    """Blender fills what a button leaves open with the values of the operator's last run."""
    switches = [
        (name, item.identifier)
        for name in dir(bpy.ops.paradesc)
        for item in getattr(bpy.ops.paradesc, name).get_rna_type().properties
        if item.type == "BOOLEAN" and not item.is_skip_save
    ]
    assert switches == []


def test_operators_that_change_the_scene_are_steps_to_undo():
    """Those without a step write files of their own, or change a view, which Blender does not undo either."""
    known = [cls for module in paradesc_blender.modules() for cls in module.classes if issubclass(cls, bpy.types.Operator)]
    without = {cls.bl_idname for cls in known if "UNDO" not in getattr(cls, "bl_options", ())}
    views = ("view_colors", "restore_shading", "show_image", "open_image", "show_research", "look_at_buttons")
    files = ("add_preset", "manual", "asset_library", "open_image_folder", "save_images")
    assert without == {f"paradesc.{name}" for name in (*views, *files, "cancel")}


def test_operators_are_grey_without_a_bake():
    add_sphere(steps=2)
    assert recolor.obstacle(bpy.context) == "Bake descriptors on this mesh first"
    for name in ("recolor", "pack", "vertex_group", "sculpt_mask", "make_material", "add_geometry_nodes"):
        with pytest.raises(RuntimeError, match="poll"):
            getattr(bpy.ops.paradesc, name)()


@pytest.mark.parametrize("name", ["bake", "bake_image", "add_wear", "recolor", "make_material"])
def test_an_object_that_was_hidden_in_sculpt_mode_has_to_be_shown(name, baked):
    bpy.ops.object.mode_set(mode="SCULPT")
    baked.hide_viewport = True
    with pytest.raises(RuntimeError, match="Show the hidden object first"):
        getattr(bpy.ops.paradesc, name)()
    baked.hide_viewport = False
    assert getattr(bpy.ops.paradesc, name)() == {"FINISHED"}
    assert baked.mode == "SCULPT"


def test_a_copy_with_values_says_which_mode_to_leave(baked):
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    with pytest.raises(RuntimeError, match="Leave weight paint mode first"):
        bpy.ops.paradesc.make_result_object()


def test_packed_channels_are_the_values_over_their_ranges(baked):
    group().pack_red, group().pack_green, group().pack_blue = "mean_curvature", "curvedness", "coverage"
    bpy.ops.paradesc.pack()
    packed = attribute_values(baked.data, "paradesc_packed")
    for channel, name in enumerate(NAMES):
        values, shown = attribute_values(baked.data, name), recolor.stored_range(baked.data, name)
        expected = np.clip((values - shown.minimum) / (shown.maximum - shown.minimum), 0, 1)
        defined = np.isfinite(values)
        np.testing.assert_allclose(packed[defined, channel], expected[defined], atol=1e-6)
    assert packed[5, 0] == 0.5  # no value: neutral
    assert (packed[:, 2] == 0.75).all()
    assert (packed[:, 3] == 1).all()


def test_packing_to_bytes_on_corners_replaces_what_was_packed_before(baked):
    group().pack_alpha = "curvedness"
    bpy.ops.paradesc.pack()
    expected = attribute_values(baked.data, "paradesc_packed")
    group().pack_kind, group().pack_domain = "BYTE_COLOR", "CORNER"
    bpy.ops.paradesc.pack()
    corners = mesh_io.read_corner_vertices(baked.data)
    found = corner_values(baked.data, "paradesc_packed")
    np.testing.assert_allclose(found[:, 3], expected[corners, 3], atol=0.5 / 255 + 1e-6)


def test_foreign_attribute_is_not_packed_over(baked):
    baked.data.color_attributes.new("paradesc_packed", "FLOAT_COLOR", "POINT")
    group().pack_red = "curvedness"
    before = fingerprint(baked)
    with pytest.raises(RuntimeError, match="not made here"):
        bpy.ops.paradesc.pack()
    assert fingerprint(baked) == before
    group().pack_name, group().pack_red = "mine", "nothing"
    with pytest.raises(RuntimeError, match="no values"):
        bpy.ops.paradesc.pack()


def test_corner_colors_are_those_of_the_vertices(baked):
    bpy.ops.paradesc.corner_colors()
    corners = mesh_io.read_corner_vertices(baked.data)
    found = color_maps.linear_to_srgb(corner_values(baked.data, "mean_curvature_corner_color")[:, :3])
    np.testing.assert_allclose(found, colors_of(baked)[corners], atol=0.5 / 255 + 1e-3)


def test_vertex_group_has_the_values_as_weights_and_leaves_others_alone(baked):
    other = baked.vertex_groups.new(name="arm")
    other.add([0, 1], 0.5, "REPLACE")
    bpy.ops.paradesc.show(name="curvedness")
    for _ in range(2):
        bpy.ops.paradesc.vertex_group()
    made = baked.vertex_groups["curvedness"]
    weights = [made.weight(vertex) for vertex in range(len(baked.data.vertices))]
    np.testing.assert_allclose(weights, channels.shares(baked.data, "curvedness"), atol=1e-6)
    assert [item.name for item in baked.vertex_groups] == ["arm", "curvedness"]
    assert baked.vertex_groups.active.name == "arm"
    assert other.weight(1) == 0.5


def test_foreign_vertex_group_is_refused_and_kept(baked):
    baked.vertex_groups.new(name="mean_curvature").add([3], 0.25, "REPLACE")
    with pytest.raises(RuntimeError, match="not made here"):
        bpy.ops.paradesc.vertex_group()
    assert baked.vertex_groups["mean_curvature"].weight(3) == 0.25


def test_sculpt_mask_is_written_and_a_painted_one_kept_until_allowed(baked):
    assert sculpt_masks.values(baked.data) is None
    bpy.ops.paradesc.sculpt_mask()
    expected = channels.shares(baked.data, "mean_curvature")
    np.testing.assert_allclose(sculpt_masks.values(baked.data), expected, atol=1e-6)
    bpy.ops.paradesc.show(name="curvedness")
    with pytest.raises(RuntimeError, match="sculpt mask"):
        bpy.ops.paradesc.sculpt_mask()
    np.testing.assert_allclose(sculpt_masks.values(baked.data), expected, atol=1e-6)
    bpy.ops.paradesc.sculpt_mask(replace=True)
    np.testing.assert_allclose(sculpt_masks.values(baked.data), channels.shares(baked.data, "curvedness"), atol=1e-6)


def test_making_the_mask_keeps_shape_keys_and_selection(baked):
    baked.shape_key_add(name="Basis")
    key = baked.shape_key_add(name="up")
    key.data[3].co.z += 1.0
    moved = key.data[3].co.copy()
    for vertex in baked.data.vertices:
        vertex.select = vertex.index < 7
    bpy.ops.paradesc.sculpt_mask()
    assert (baked.data.shape_keys.key_blocks["up"].data[3].co - moved).length < 1e-6
    assert baked.mode == "OBJECT"
    if bpy.app.version >= (4, 1, 0):  # before that, edit mode makes the layer and flushes a selection without edges
        assert sum(vertex.select for vertex in baked.data.vertices) == 7


def test_settings_without_the_add_on_are_automatic():
    paradesc_blender.unregister()
    assert looks.scene_look(bpy.context.scene) == color_maps.Look()
    paradesc_blender.register()
