"""Values on the mesh that modifiers make, in files and for exporters, in other colors, and as a copy on request."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from carrying_test import bake, box, ours, shown, stock  # noqa: E402
from export_test import enable, nearest, primitive  # noqa: E402

from paradesc.core import color_maps, source_kinds  # noqa: E402
from paradesc_blender.scene import carrying, mesh_io, scene_io, targets  # noqa: E402
from paradesc_blender.show import recolor  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene, saved_scene, select, subdivide  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


# ---- Files


def test_a_file_keeps_what_is_carried(tmp_path):
    target = box()
    bake("convexity")
    bake("cavity")
    expected = {name: shown(target, name) for name in carrying.carried_names(target)}
    assert len(expected) == 5  # two masks, their colors, and the coverage
    for _ in range(2):  # what nothing used would be lost by the second time
        bpy.ops.wm.open_mainfile(filepath=str(saved_scene(tmp_path / "box.blend")))
    target = bpy.data.objects["box"]
    for name, values in expected.items():
        np.testing.assert_array_equal(shown(target, name), values)
    assert len(ours(target)) == 1
    before = stock()
    bake("convexity")
    assert stock() == before


def test_objects_of_a_file_come_without_carriers_in_the_scene(tmp_path):
    box()
    bake("convexity")
    path = saved_scene(tmp_path / "box.blend")
    empty_scene()
    add_sphere()
    (found,) = scene_io.add_objects(path)
    assert sorted(item.name for item in bpy.context.scene.objects) == ["box", "sphere"]
    assert len(ours(found)) == 1
    assert len(shown(found, "convexity")) == len(carrying.carrier_of(found).vertices)


@pytest.mark.parametrize("way", ["append", "paste"])
def test_an_object_that_is_appended_or_pasted_brings_no_carrier_into_the_scene(tmp_path, way):
    box()
    bake("convexity")
    expected = shown(bpy.context.object, "convexity")
    if way == "append":
        path = saved_scene(tmp_path / "file.blend")
        empty_scene()
        bpy.context.view_layer.update()
        bpy.ops.wm.append(directory=f"{path}/Object/", filename="box")
    else:
        select(bpy.context.object)
        bpy.ops.view3d.copybuffer()
        bpy.ops.view3d.pastebuffer()
    bpy.context.view_layer.update()
    there = list(bpy.context.scene.objects)
    assert sorted(item.name for item in there) == (["box"] if way == "append" else ["box", "box.001"])
    for item in there:
        np.testing.assert_array_equal(shown(item, "convexity"), expected)
    select(*there)
    before = stock()
    bake("convexity")
    assert stock() == before


def test_a_carrier_that_somebody_puts_into_the_scene_stays_and_is_not_measured(tmp_path):
    target = box()
    bake("convexity")
    carrier = carrying.held_by(ours(target)[0].node_group)
    bpy.context.scene.collection.objects.link(carrier)
    bpy.ops.mesh.primitive_cube_add()
    select(target, carrier)
    assert targets.chosen(bpy.context) == [target]
    bake("cavity")
    bpy.ops.wm.open_mainfile(filepath=str(saved_scene(tmp_path / "file.blend")))
    bpy.ops.mesh.primitive_cube_add()
    assert "box Values" in bpy.context.scene.objects


def made_local(folder):
    """The box of another file with a bake, linked and made local."""
    box()
    bake("convexity")
    path = saved_scene(folder / "box.blend")
    empty_scene()
    with bpy.data.libraries.load(str(path), link=True) as (_there, here):
        here.objects = ["box"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    select(here.objects[0])
    assert bpy.ops.paradesc.make_local() == {"FINISHED"}
    return bpy.context.view_layer.objects.active


@pytest.mark.parametrize("source", [source_kinds.AUTOMATIC, source_kinds.ORIGINAL])
def test_a_linked_object_that_is_made_local_shows_its_next_bake(tmp_path, source):
    target = made_local(tmp_path)
    before = shown(target, "convexity")
    bake("convexity", source=source)
    expected = [item.name for item in target.modifiers if item.type != "NODES"]
    expected += [carrying.MODIFIER] if source == source_kinds.AUTOMATIC else []
    assert [item.name for item in target.modifiers] == expected
    assert len(shown(target, "convexity")) == len(before)
    assert np.array_equal(shown(target, "convexity"), before) == (source == source_kinds.AUTOMATIC)
    assert all(item.library is None for item in [carrying.carrier_of(target)] if item is not None)


def test_colors_of_a_linked_bake_that_is_made_local_are_made_on_a_carrier_of_this_file(tmp_path):
    target = made_local(tmp_path)
    bpy.context.scene.paradesc_looks.color_map = "viridis"
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    colors = shown(target, "convexity_color")
    assert np.ptp(colors[:, 0]) != np.ptp(colors[:, 2])
    bpy.ops.wm.open_mainfile(filepath=str(saved_scene(tmp_path / "other.blend")))
    np.testing.assert_array_equal(shown(bpy.context.view_layer.objects.active, "convexity_color"), colors)


def test_gltf_gets_the_colors_of_the_evaluated_mesh(tmp_path):
    target = box()
    bake("convexity")
    expected = shown(target, "convexity_color")
    carrier = carrying.carrier_of(target)
    points = mesh_io.read_positions(carrier)[:, [0, 2, 1]] * [1, 1, -1]  # glTF's y is up
    enable("io_scene_gltf2")
    options = {"export_all_vertex_colors": True} if "export_all_vertex_colors" in dir(gltf_options()) else {}
    if "export_vertex_color" in dir(gltf_options()):
        options["export_vertex_color"] = "ACTIVE"
    with scene_io.numpy_bool():
        bpy.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"), export_apply=True, **options)
    found = primitive(tmp_path / "a.glb")
    at = nearest(points, found["POSITION"])
    colors = found["COLOR_0"][:, :3]
    scale = 65535 if colors.dtype == np.uint16 else 1
    np.testing.assert_allclose(colors / scale, expected[at, :3], atol=1 / 65535)  # a step of 16 bits


def gltf_options():
    """The settings of Blender's glTF exporter, which differ from version to version."""
    return bpy.ops.export_scene.gltf.get_rna_type().properties


# ---- Colors, copies


def test_new_colors_are_those_of_the_carried_values():
    target = box()
    bake("convexity")
    looks = bpy.context.scene.paradesc_looks
    looks.color_map = "viridis"
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    values, carrier = shown(target, "convexity"), carrying.carrier_of(target)
    colors = color_maps.colors(values, recolor.stored_range(carrier, "convexity"))
    np.testing.assert_array_equal(shown(target, "convexity_color"), color_maps.linear_rgba(colors).astype(np.float32))
    assert np.ptp(shown(target, "convexity_color")[:, 0]) > 0.1  # they are no greys of one kind
    assert recolor.stored_range(target.data, "convexity") == recolor.stored_range(carrier, "convexity")


def test_a_copy_on_request_has_all_masks_is_selected_and_hides_the_original():
    target = box()
    bake("convexity")
    bake("cavity")
    expected = {name: shown(target, name) for name in carrying.carried_names(target)}
    target.location.x = 3.0
    target.data.materials.append(bpy.data.materials.new("of the mesh"))
    target.material_slots[0].link, target.material_slots[0].material = "OBJECT", bpy.data.materials.new("own")
    assert bpy.ops.paradesc.make_result_object() == {"FINISHED"}
    copy = bpy.context.view_layer.objects.active
    assert copy.name == "box_paradesc"
    assert list(bpy.context.view_layer.objects.selected) == [copy]
    assert (target.hide_get(), target.hide_render, copy.hide_get(), copy.hide_render) == (True, True, False, False)
    assert len(copy.modifiers) == 0
    assert copy.location.x == 3.0
    assert copy.active_material.name == "own"
    for name, values in expected.items():
        np.testing.assert_array_equal(attribute_values(copy.data, name), values)
    assert recolor.baked_names(copy.data) == ["cavity", "convexity"]
    assert recolor.shown_name(copy.data) == "cavity"
    bake("cavity")  # it is an object like any other
    assert recolor.baked_names(copy.data) == ["cavity", "convexity"]


def test_a_copy_is_made_in_object_mode_of_what_was_baked():
    box()
    assert not bpy.ops.paradesc.make_result_object.poll()
    bake("convexity")
    subdivide()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.paradesc.make_result_object.poll()
