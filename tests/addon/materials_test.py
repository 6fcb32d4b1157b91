"""Materials and nodes show what was baked, and the user's own come back. Runs inside Blender."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from mesh_io_test import made_up_results  # noqa: E402

from paradesc_blender.scene import delivery, mesh_io  # noqa: E402
from paradesc_blender.show import recolor  # noqa: E402
from scene import add_sphere, attribute_values, fingerprint  # noqa: E402

NAMES = ("mean_curvature", "cavity", "convexity")
SIDE = 32


pytestmark = pytest.mark.usefixtures("registered")


def baked_sphere(names=NAMES):
    """A sphere with two materials of the user's and made-up values."""
    target = add_sphere(steps=4)
    for name in ("skin", "cloth"):
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        target.data.materials.append(material)
    target.data.polygons.foreach_set("material_index", np.arange(len(target.data.polygons), dtype=np.int32) % 2)
    delivery.deliver(target, made_up_results(target, names))
    return target


def fill(target, **values):
    """Gives attributes one value everywhere."""
    for name, value in values.items():
        content = np.full(len(target.data.vertices), value, np.float32)
        target.data.attributes[name].data.foreach_set("value", content)
    target.data.update()


def slots_of(target):
    """Which material each face has, and which slots there are."""
    names = [None if item is None else item.name for item in target.data.materials]
    return mesh_io.read_array(target.data.polygons, "material_index", np.int32).tolist(), names


def rendered(tmp_path):
    """(4,) display color in the middle of a picture of the object by Cycles, in plain white light."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.data.lens = (0, 0, 4), 60
    scene.collection.objects.link(camera)
    scene.camera, scene.world = camera, bpy.data.worlds.new("white")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 16
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = str(tmp_path / "picture.png")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels[:], np.float32).reshape(SIDE, SIDE, 4)
    return pixels[SIDE // 2 - 2 : SIDE // 2 + 2, SIDE // 2 - 2 : SIDE // 2 + 2].mean(axis=(0, 1))


def assert_base_color(tmp_path, target, name):
    """Checks that the color that our material gives its shader, seen without light, is that of this input."""
    material = target.data.materials[2]
    expected = next(node for node in material.node_tree.nodes if node.type == "GROUP").inputs[name].default_value
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    emission = material.node_tree.nodes.new("ShaderNodeEmission")
    material.node_tree.links.new(shader.inputs["Base Color"].links[0].from_socket, emission.inputs[0])
    output = next(node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL")
    material.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
    from paradesc.core import color_maps

    np.testing.assert_allclose(
        rendered(tmp_path)[:3], color_maps.linear_to_srgb(np.array(expected[:3])), atol=2.1 / 255
    )


@pytest.mark.parametrize("kind", ["colors", "flat", "cavity"])
def test_materials_of_the_user_come_back_by_one_click(kind):
    target = baked_sphere()
    before, faces = fingerprint(target), slots_of(target)
    assert bpy.ops.paradesc.make_material(kind=kind) == {"FINISHED"}
    indices, names = slots_of(target)
    assert set(indices) == {2}
    assert names[:2] == ["skin", "cloth"]
    bpy.ops.paradesc.make_material(kind="colors")  # another click takes the same slot
    assert len(target.data.materials) == 3
    assert bpy.ops.paradesc.remove_material() == {"FINISHED"}
    assert slots_of(target) == faces
    assert fingerprint(target) == before
    assert sorted(item.name for item in bpy.data.materials) == ["cloth", "skin"]


def test_material_in_edit_mode_leaves_it_as_it_was():
    target = baked_sphere()
    faces = slots_of(target)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.paradesc.make_material(kind="colors")
    bpy.ops.paradesc.remove_material()
    assert target.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert slots_of(target) == faces


def test_flat_material_renders_the_color_itself(tmp_path):
    target = baked_sphere()
    color = np.tile(np.array([0.8, 0.1, 0.3, 1.0], np.float32), len(target.data.vertices))
    target.data.attributes["mean_curvature_color"].data.foreach_set("color", color)
    bpy.ops.paradesc.make_material(kind="flat")
    # Two steps of 8 bits.
    np.testing.assert_allclose(rendered(tmp_path)[:3], [0.9063, 0.3492, 0.5838], atol=2.1 / 255)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"cavity": 0.0, "convexity": 0.0}, "Base Color"),
        ({"cavity": 1.0, "convexity": 0.0}, "Cavity Color"),
        ({"cavity": 0.0, "convexity": 1.0}, "Edge Color"),
        ({"cavity": np.nan, "convexity": np.nan}, "Base Color"),
    ],
    ids=["flat", "hollow", "edge", "undefined"],
)
def test_cavity_material_is_dirty_in_hollows_and_worn_at_edges(tmp_path, values, expected):
    target = baked_sphere()
    fill(target, **values)
    bpy.ops.paradesc.make_material(kind="cavity")
    assert_base_color(tmp_path, target, expected)


def test_cavity_falls_back_to_mean_curvature_times_radius():
    target = baked_sphere(("mean_curvature",))
    bpy.ops.paradesc.make_material(kind="cavity")
    node = next(node for node in target.data.materials[2].node_tree.nodes if node.type == "GROUP")
    np.testing.assert_allclose(node.inputs["Radius"].default_value, 0.1, rtol=1e-6)
    names = {item.attribute_name for item in node.node_tree.nodes if item.type == "ATTRIBUTE"}
    assert names == {"mean_curvature"}


@pytest.mark.parametrize(
    ("name", "expected"), [("cavity", "Cavity Color"), ("convexity", "Edge Color")], ids=["hollow", "edge"]
)
def test_cavity_material_shows_the_one_mask_that_a_preset_bakes(tmp_path, name, expected):
    target = baked_sphere((name,))
    fill(target, **{name: 1.0})
    bpy.ops.paradesc.make_material(kind="cavity")
    assert_base_color(tmp_path, target, expected)


def test_cavity_without_anything_to_make_it_of_is_one_sentence():
    target = baked_sphere(("shape_index",))
    before = fingerprint(target), slots_of(target)
    with pytest.raises(RuntimeError, match="bake those first"):
        bpy.ops.paradesc.make_material(kind="cavity")
    assert (fingerprint(target), slots_of(target)) == before


def test_cavity_group_goes_into_the_users_material_and_out_again():
    target = baked_sphere()
    target.active_material_index = 1
    tree = bpy.data.materials["cloth"].node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    image = tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(image.outputs["Color"], shader.inputs["Base Color"])
    assert bpy.ops.paradesc.plug_cavity() == {"FINISHED"}
    group = shader.inputs["Base Color"].links[0].from_node
    assert group.node_tree.name == "Paradesc Cavity"
    assert group.inputs["Base Color"].links[0].from_node == image
    with pytest.raises(RuntimeError, match="already"):
        bpy.ops.paradesc.plug_cavity()
    bpy.ops.paradesc.remove_material()
    assert shader.inputs["Base Color"].links[0].from_node == image
    assert not [node for node in tree.nodes if node.type == "GROUP"]


def evaluated(target):
    """The mesh after its modifiers."""
    return target.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def test_geometry_nodes_move_vertices_by_the_value_and_leave_undefined_ones():
    target = baked_sphere()
    values = attribute_values(target.data, "mean_curvature")
    shown = recolor.stored_range(target.data, "mean_curvature")
    mask = target.data.attributes.new("paradesc_mask", "FLOAT", "POINT")  # a bake writes it where a value is missing
    mask.data.foreach_set("value", (np.arange(len(values)) == 3).astype(np.float32))
    bpy.ops.paradesc.add_geometry_nodes(kind="swell")
    lengths = np.linalg.norm(mesh_io.read_array(evaluated(target).vertices, "co", np.float32, 3), axis=1)
    moved = np.clip((values - shown.minimum) / (shown.maximum - shown.minimum), 0, 1) * 0.02
    moved[3] = 0.0
    np.testing.assert_allclose(lengths, 2.0 + moved, atol=2e-3)  # coarse vertex normals are not quite radial


def test_nodes_and_materials_are_named_as_the_panel_names_masks():
    bpy.context.scene.paradesc.descriptors = {"convexity"}
    target = add_sphere()
    bpy.ops.paradesc.bake()
    bpy.ops.paradesc.add_geometry_nodes(kind="swell")
    bpy.ops.paradesc.add_geometry_nodes(kind="swell")
    groups = {item.node_group.name for item in target.modifiers}
    for kind in ("flat", "cavity"):
        bpy.ops.paradesc.make_material(kind=kind)
        assert target.active_material.name == {"flat": "Paradesc Edge Wear Flat", "cavity": "Paradesc Cavity"}[kind]
    assert groups == {"Paradesc Swell by Edge Wear"}  # the second modifier shares the group of the first


def test_geometry_nodes_keep_what_lies_above_a_value():
    target = baked_sphere()
    shown = recolor.stored_range(target.data, "mean_curvature")
    above = attribute_values(target.data, "mean_curvature") > shown.minimum + 0.75 * (shown.maximum - shown.minimum)
    bpy.ops.paradesc.add_geometry_nodes(kind="keep")
    assert len(evaluated(target).vertices) == above.sum() > 0


def test_the_cavity_group_says_from_where_to_where_its_masks_rise():
    target = baked_sphere()
    bpy.ops.paradesc.make_material(kind="cavity")
    tree = target.material_slots[-1].material.node_tree
    (node,) = (item for item in tree.nodes if item.type == "GROUP")
    ends = [node.inputs[f"{word} {end}"].default_value for word in ("Cavity", "Edge") for end in ("Begin", "End")]
    assert ends == pytest.approx([0.03, 0.4, 0.2, 0.7])  # most of a surface is a little convex


def test_geometry_nodes_scatter_where_the_value_is_high():
    target = baked_sphere()
    mesh, shown = target.data, recolor.stored_range(target.data, "mean_curvature")
    high = np.arange(len(mesh.vertices)) < 20
    values = np.where(high, shown.maximum, shown.minimum).astype(np.float32)
    mesh.attributes["mean_curvature"].data.foreach_set("value", values)
    bpy.ops.paradesc.add_geometry_nodes(kind="scatter")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    places = np.array([tuple(item.matrix_world.translation) for item in depsgraph.object_instances if item.is_instance])
    assert len(places) > 100
    positions = mesh_io.read_array(mesh.vertices, "co", np.float32, 3)
    edge = max(np.linalg.norm(positions[a] - positions[b]) for a, b in mesh.edge_keys)
    assert np.linalg.norm(places[:, None] - positions[high][None], axis=2).min(axis=1).max() < 1.5 * edge
    assert len(evaluated(target).vertices) == len(values)  # what is measured stays as it is


def test_geometry_nodes_mark_what_lies_above_a_value():
    target = baked_sphere()
    shown = recolor.stored_range(target.data, "mean_curvature")
    above = attribute_values(target.data, "mean_curvature") > shown.minimum + 0.75 * (shown.maximum - shown.minimum)
    bpy.ops.paradesc.add_geometry_nodes(kind="mark")
    marked = mesh_io.read_array(evaluated(target).attributes["paradesc_selection"].data, "value", bool)
    assert np.array_equal(marked, above)
    assert [item.type for item in target.modifiers] == ["NODES"]
