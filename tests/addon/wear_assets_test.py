"""The looks of wear, and the file of assets that has them. Runs inside Blender."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from wear_test import PAINT, SIDE, add_wear, shader_of, target, user_material, wear_nodes  # noqa: E402, F401

from paradesc_blender.settings import asset_library  # noqa: E402
from paradesc_blender.show import assets, tuned, wear  # noqa: E402
from shapes import ADDON  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


# ---- Values


def baked(ball, material, cavity, edges, output="Color", **inputs):
    """(texels, 3) what the wear of a material gives where the masks have these values, by a bake of Cycles."""
    for name, value in (("cavity_color", cavity), ("convexity_color", edges)):
        content = np.tile(np.array([value, value, value, 1.0], np.float32), len(ball.data.vertices))
        ball.data.attributes[name].data.foreach_set("color", content)
    tree, (node,) = material.node_tree, wear_nodes(material)
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(node.outputs[output], emission.inputs["Color"])
    image = tree.nodes.new("ShaderNodeTexImage")
    image.image = bpy.data.images.new("baked", SIDE, SIDE, float_buffer=True)
    tree.nodes.active = image
    tree.links.new(emission.outputs[0], tree.get_output_node("ALL").inputs["Surface"])
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 4
    scene.cycles.use_denoising = False
    scene.render.bake.margin, scene.render.bake.margin_type = SIDE, "EXTEND"
    bpy.ops.object.bake(type="EMIT")
    return np.array(image.image.pixels[:], np.float32).reshape(-1, 4)[:, :3]


@pytest.mark.parametrize(
    ("cavity", "edges", "source"),
    [(0.0, 0.0, "Base Color"), (1.0, 0.0, "Dirt Color"), (0.0, 1.0, "Edge Color")],
    ids=["flat", "hollow", "edge"],
)
def test_hollows_have_the_color_of_dirt_and_edges_that_of_wear(target, cavity, edges, source):  # noqa: F811
    material = bpy.data.materials.new("paint")
    material.use_nodes = True
    shader_of(material).inputs["Base Color"].default_value = PAINT
    target.data.materials.append(material)
    add_wear(look="OLD_STONE")
    whole = {"Dirt_Amount": 1.0, "Edge_Amount": 1.0, "Noise_Breakup": 0.0}
    color = baked(target, material, cavity, edges, **whole).mean(axis=0)
    expected = wear_nodes(material)[0].inputs[source].default_value[:3]
    np.testing.assert_allclose(color, expected, atol=2e-3)  # the image has half floats at least


def test_own_colors_darken_in_hollows_and_brighten_at_edges(target):  # noqa: F811
    material = bpy.data.materials.new("paint")
    material.use_nodes = True
    shader_of(material).inputs["Base Color"].default_value = PAINT
    target.data.materials.append(material)
    add_wear()
    flat, hollow, edge = (baked(target, material, *masks).mean(axis=0) for masks in ((0, 0), (1, 0), (0, 1)))
    np.testing.assert_allclose(flat, PAINT[:3], atol=2e-3)
    assert (hollow < 0.5 * flat).all()
    assert (edge > flat).all()


def test_scuffed_edges_of_plastic_are_paler_in_the_hue_of_the_material(target):  # noqa: F811
    material = bpy.data.materials.new("blue")
    material.use_nodes = True
    shader_of(material).inputs["Base Color"].default_value = PAINT
    target.data.materials.append(material)
    add_wear(look="DUSTY_PLASTIC")
    clean = {"Noise_Breakup": 0.0, "Dust_on_Top": 0.0}
    flat, edge = (baked(target, material, 0, edges, **clean).mean(axis=0) for edges in (0, 1))
    np.testing.assert_allclose(flat, PAINT[:3], atol=2e-3)  # half floats at least
    assert edge[0] > 1.5 * flat[0]
    assert edge[0] < edge[1] < edge[2]


def test_noise_breaks_up_a_mask_of_one_value(target):  # noqa: F811
    material = user_material(target=target)
    add_wear(look="PAINTED_METAL")
    found = baked(target, material, 0.0, 0.25, "Wear", Edge_Level=0.25)
    assert found.min() < 0.2  # a texel is a mean of some noise
    assert found.max() > 0.8
    even = baked(target, material, 0.0, 0.25, "Wear", Noise_Breakup=0.0)
    assert np.ptp(even) < 1e-3  # half floats


# ---- Assets


def listed():
    """The assets of the add-on's file, each with kind and name."""
    with bpy.data.libraries.load(str(asset_library.FILE), assets_only=True) as (there, _):
        return {("node_groups", name) for name in there.node_groups} | {("materials", name) for name in there.materials}


def test_the_file_of_assets_has_looks_and_groups_and_is_small():
    names = {name for _, name in listed()}
    assert {*wear.LOOKS.values(), wear.GROUP, "Curvature", "Paradesc Cavity"} <= names
    assert asset_library.FILE.stat().st_size < 300_000


def test_assets_are_described_in_a_catalog_that_is_there_and_have_thumbnails():
    catalogs = (asset_library.FOLDER / "blender_assets.cats.txt").read_text()
    with bpy.data.libraries.load(str(asset_library.FILE), link=True, assets_only=True) as (there, wanted):
        wanted.node_groups, wanted.materials = there.node_groups, there.materials
    for block in (*wanted.node_groups, *wanted.materials):
        data = block.asset_data
        assert data.description.endswith("."), block.name
        assert len(data.tags) > 0
        assert f"{data.catalog_id}:Paradesc:" in catalogs
        preview = block.preview
        assert preview is not None, block.name
        assert min(preview.image_size) >= 128
        pixels = np.array(preview.image_pixels_float[:]).reshape(-1, 4)
        assert pixels[:, 3].max() > 0.9
        assert np.ptp(pixels[:, :3]) > 0.2  # no even square


def test_curvature_has_the_sockets_of_blenders_own_node():
    group = assets.append("node_groups", "Curvature")
    node = bpy.data.materials.new("any")
    node.use_nodes = True
    made = node.node_tree.nodes.new("ShaderNodeGroup")
    made.node_tree = group
    assert [socket.name for socket in made.inputs] == ["Radius", "Bias"]
    assert [socket.name for socket in made.outputs] == ["Curvature", "Convexity", "Concavity", "Both"]


def test_the_asset_browser_gets_the_folder_only_when_asked_and_loses_it_again():
    libraries = bpy.context.preferences.filepaths.asset_libraries
    before = [one.path for one in libraries]
    assert asset_library.place() < 0
    assert bpy.ops.paradesc.asset_library() == {"FINISHED"}
    assert libraries[asset_library.place()].name == "Paradesc"
    assert bpy.ops.paradesc.asset_library() == {"FINISHED"}
    assert [one.path for one in libraries] == before


@pytest.mark.skipif(bpy.app.version >= (3, 5), reason="Blender 3.4 makes the file of assets")
def test_the_file_of_assets_is_what_the_script_makes(monkeypatch):
    monkeypatch.syspath_prepend(str(ADDON / "assets"))
    import make_assets

    made = {block.name: (block, tuned.fingerprint(block)) for block in make_assets.build()}
    assert {name for _, name in listed()} == set(made)
    for kind, name in listed():
        block, expected = made[name]
        block.name = "made anew"
        found = assets.append(kind, name)
        assert tuned.fingerprint(found) == expected, name
        getattr(bpy.data, kind).remove(found)
        block.name = name
