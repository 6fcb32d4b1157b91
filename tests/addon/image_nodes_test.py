"""Add to Material: labelled nodes in a frame, which a second bake finds again, linked to groups of ours alone."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from image_operator_test import folder, settings  # noqa: E402, F401
from image_uv_test import add_map  # noqa: E402

from paradesc.core import udim  # noqa: E402
from paradesc.files import map_images, png  # noqa: E402
from paradesc_blender.scene import image_nodes, images, node_groups, uv_maps  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def material(folder, settings):  # noqa: F811
    """The user's own material of the ball, and cavity and edges as images."""
    settings.image_to_material, settings.descriptors = True, {"cavity", "convexity"}
    made = bpy.data.materials.new("mine")
    made.use_nodes = True
    bpy.data.objects["ball"].data.materials.append(made)
    return made


def kinds(material, kind):
    return [node for node in material.node_tree.nodes if node.bl_idname == kind]


def image_nodes_of(material):
    return kinds(material, "ShaderNodeTexImage")


def with_group(material, *names):
    """Adds a group of ours with these inputs to a material, as the assets have them."""
    group = bpy.data.node_groups.new("Wear", "ShaderNodeTree")
    group[node_groups.MARK] = "Paradesc Wear"
    for name in names:
        if hasattr(group, "interface"):
            group.interface.new_socket(name=name, in_out="INPUT", socket_type="NodeSocketFloat")
        else:
            group.inputs.new("NodeSocketFloat", name)
    node = material.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    return node


def origin(socket):
    """The node that an input comes from, and the name of its output."""
    (link,) = socket.links
    return link.from_node, link.from_socket.name


def test_nodes_are_labelled_and_stand_in_a_frame(material):
    bpy.ops.paradesc.bake_image()
    nodes = image_nodes_of(material)
    (frame,) = kinds(material, "NodeFrame")
    assert frame.label == "Paradesc"
    assert [node.label for node in nodes] == [image_nodes.legend.label(name) for name in ("cavity", "convexity")]
    assert {node.parent for node in nodes} == {frame}
    assert {node.image.colorspace_settings.name for node in nodes} == {"Non-Color"}
    places = [image_nodes.place_of(node) for node in material.node_tree.nodes if node.type != "FRAME"]
    assert len({(round(x), round(y)) for x, y in places}) == len(places)  # none lies on another


def test_a_second_bake_adds_nothing(material):
    bpy.ops.paradesc.bake_image()
    count, links = len(material.node_tree.nodes), len(material.node_tree.links)
    bpy.ops.paradesc.bake_image()
    assert (len(material.node_tree.nodes), len(material.node_tree.links)) == (count, links)


def test_a_node_of_ours_gets_the_image_of_the_next_bake_unless_somebody_gave_it_another(material):
    bpy.ops.paradesc.bake_image()
    cavity, edges = image_nodes_of(material)
    for node in (cavity, edges):
        node.image.pixels[0] = 0.5  # painted on: the next bake leaves these images alone
        node.image.update()
    mine = bpy.data.images.new("mine", 8, 8)
    edges.image = mine
    bpy.ops.paradesc.bake_image()
    assert cavity.image.name == "ball_2_cavity.png"
    assert edges.image == mine
    assert [node.image.name for node in image_nodes_of(material)][2:] == ["ball_2_edges.png"]


@pytest.mark.parametrize("name", ["Edges", "Edge Wear"])
def test_masks_are_linked_to_a_group_of_ours(material, name):
    group = with_group(material, "Cavity", name, "Noise")
    links = len(material.node_tree.links)
    bpy.ops.paradesc.bake_image()
    cavity, edges = image_nodes_of(material)
    assert origin(group.inputs["Cavity"]) == (cavity, "Color")
    assert origin(group.inputs[name]) == (edges, "Color")
    assert not group.inputs["Noise"].is_linked
    assert len(material.node_tree.links) == links + 2


def test_an_image_takes_the_place_of_vertices_but_not_of_what_the_user_has_linked(material):
    group, tree = with_group(material, "Cavity", "Edges"), material.node_tree
    of_vertices, own = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeValue")
    of_vertices[image_nodes.OF_VERTICES] = "cavity"
    tree.links.new(of_vertices.outputs["Color"], group.inputs["Cavity"])
    tree.links.new(own.outputs[0], group.inputs["Edges"])
    bpy.ops.paradesc.bake_image()
    assert origin(group.inputs["Cavity"])[0] == image_nodes_of(material)[0]
    assert kinds(material, "ShaderNodeAttribute") == []
    assert origin(group.inputs["Edges"])[0] == own


def test_groups_of_others_are_left_alone(material):
    group = with_group(material, "Cavity")
    del group.node_tree[node_groups.MARK]
    bpy.ops.paradesc.bake_image()
    assert not group.inputs["Cavity"].is_linked


def test_packed_channels_are_taken_apart_for_a_group(material, settings):  # noqa: F811
    settings.image_packed = True
    group = with_group(material, "Cavity", "Edges")
    bpy.ops.paradesc.bake_image()
    bpy.ops.paradesc.bake_image()
    (apart,) = kinds(material, "ShaderNodeSeparateColor")
    assert [origin(group.inputs[name]) for name in ("Cavity", "Edges")] == [(apart, "Red"), (apart, "Green")]
    assert origin(apart.inputs[0])[0] == image_nodes_of(material)[0]


def test_a_map_that_renders_do_not_use_is_named_by_a_node(material):
    ball = bpy.data.objects["ball"]
    unwrapped = ball.data.uv_layers[0].name
    add_map("mine", np.zeros((len(ball.data.loops), 2)))
    ball.data.uv_layers.remove(ball.data.uv_layers[unwrapped])
    bpy.ops.paradesc.bake_image()
    named = kinds(material, "ShaderNodeUVMap")
    assert [node.uv_map for node in named] == [uv_maps.NAME] * 2
    assert [origin(node.inputs["Vector"])[0] for node in image_nodes_of(material)] == named


# ---- Borders of tiles


def ramp(tile):
    """A tile that goes from black to white over the first tile, and stays white on the second."""
    values = np.linspace(0, 65535, 64) if tile == udim.FIRST else np.full(64, 65535.0)
    return png.encode_png(np.repeat(values.astype(np.uint16)[None, :, None], 64, axis=0), {})


def rendered(path):
    """(height, width) values of a strip over two tiles, as Cycles renders its material without light."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.render.filepath = "CYCLES", 1, str(path)
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 512, 8, 100
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.color_depth, scene.render.image_settings.color_mode = "16", "RGB"
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera, camera.location = camera, (1.0, 0.5, 1.0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    bpy.ops.render.render(write_still=True)
    return map_images.as_stored(path)[0][:, :, 0] / 65535


def test_no_line_shows_where_a_surface_crosses_from_tile_to_tile(tmp_path):
    mesh = bpy.data.meshes.new("strip")
    mesh.from_pydata([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 2, 0, 2, 1, 0, 1])
    strip = bpy.data.objects.new("strip", mesh)
    bpy.context.collection.objects.link(strip)
    image = images.from_memory("strip", {tile: ramp(tile) for tile in (1001, 1002)}, "strip")
    material = image_nodes.add_to_material(strip, [image_nodes.Texture(image, ("cavity",))])
    tree = material.node_tree
    light = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(image_nodes_of(material)[0].outputs["Color"], light.inputs["Color"])
    tree.links.new(light.outputs[0], next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL").inputs[0])
    seen = rendered(tmp_path / "strip.png").mean(axis=0)
    assert seen[16] < 0.1  # the ramp's beginning is dark
    np.testing.assert_allclose(seen[252:260], 1.0, atol=0.02)  # a texel of the ramp is 1/63
