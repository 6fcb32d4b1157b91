"""Wear of meshes whose faces are too large for masks at vertices: it reads images. Runs inside Blender."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from wear_test import add_wear, everything_in, target, user_material, wear_nodes  # noqa: E402, F401

from paradesc_blender.show import wear  # noqa: E402
from scene import add_sphere, select  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def crate(name="crate"):
    """A cube of six faces."""
    bpy.context.scene.paradesc.texels = 64
    return add_sphere(name, steps=1)


def sources(material):
    """The kinds of the nodes that give the masks."""
    (node,) = wear_nodes(material)
    return {name: node.inputs[name].links[0].from_node.type for name in wear.MASKS}


def test_a_crate_wears_by_images_which_go_again():
    material = user_material(target=crate())
    before = everything_in(material)
    add_wear()
    assert sources(material) == {"Cavity": "TEX_IMAGE", "Edges": "TEX_IMAGE"}
    assert wear_nodes(material)[0].inputs["Base Color"].links[0].from_node.image is None  # the user's own
    once = everything_in(material)
    add_wear()
    assert everything_in(material) == once
    bpy.ops.paradesc.remove_wear()
    assert everything_in(material) == before


def test_crates_without_a_material_have_one_each_as_their_images_differ():
    first, second = crate("first"), crate("second")
    select(first, second)
    add_wear(look="OLD_STONE")
    assert first.active_material != second.active_material
    for box in (first, second):
        node = wear_nodes(box.active_material)[0].inputs["Edges"].links[0].from_node
        assert node.image.name.startswith(box.name)
    bpy.ops.paradesc.remove_wear()
    assert len(bpy.data.materials) == 0


def test_a_fine_mesh_never_gets_the_look_with_images_of_a_crate(target):  # noqa: F811
    box = crate()
    select(box)
    add_wear()
    select(target)
    add_wear()
    assert target.active_material != box.active_material
    assert sources(target.active_material)["Edges"] == "ATTRIBUTE"


def test_a_material_that_crates_share_has_masks_at_vertices():
    first, second = crate("first"), crate("second")
    material = user_material(target=first)
    second.data.materials.append(material)
    select(first, second)
    add_wear()
    assert sources(material) == {"Cavity": "ATTRIBUTE", "Edges": "ATTRIBUTE"}


def test_a_crate_beside_a_fine_mesh_alone_gets_images(target):  # noqa: F811
    box = crate()
    materials = user_material("of the sphere", target), user_material("of the crate", box)
    select(target, box)
    add_wear()
    assert [sources(material)["Edges"] for material in materials] == ["ATTRIBUTE", "TEX_IMAGE"]


def with_own_materials(box, *materials):
    """Linked duplicates of a crate, each with a material of its own in the slot that the object itself fills."""
    box.data.materials.append(None)
    made = [box]
    for _ in materials[1:]:
        made.append(box.copy())
        bpy.context.collection.objects.link(made[-1])
    for one, material in zip(made, materials, strict=True):
        one.material_slots[0].link, one.material_slots[0].material = "OBJECT", material
    select(*made)
    return made


def test_materials_of_their_own_wear_on_crates_that_share_a_mesh():
    materials = [bpy.data.materials.new(name) for name in ("red", "blue")]
    with_own_materials(crate(), *materials)
    add_wear()
    assert [sources(material)["Edges"] for material in materials] == ["TEX_IMAGE", "TEX_IMAGE"]
    bpy.ops.paradesc.remove_wear()
    assert not any(wear_nodes(material) for material in materials)


def test_beside_a_crate_that_cannot_wear_the_other_one_does():
    red, bare = (bpy.data.materials.new(name) for name in ("red", "bare"))
    bare.use_nodes = True
    bare.node_tree.nodes.clear()
    with_own_materials(crate(), red, bare)
    add_wear()
    assert sources(red)["Edges"] == "TEX_IMAGE"


@pytest.mark.parametrize("mode", ["EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"])
def test_a_crate_wears_by_images_in_each_mode(mode):
    material = user_material(target=crate())
    bpy.ops.object.mode_set(mode=mode)
    add_wear()
    assert bpy.context.object.mode == mode
    assert sources(material) == {"Cavity": "TEX_IMAGE", "Edges": "TEX_IMAGE"}


def test_a_crate_that_was_subdivided_in_edit_mode_wears_by_vertices():
    material = user_material(target=crate())
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=10)
    add_wear()
    assert sources(material) == {"Cavity": "ATTRIBUTE", "Edges": "ATTRIBUTE"}


def test_an_image_goes_into_each_material_of_objects_that_share_a_mesh(capfd):
    materials = [bpy.data.materials.new(name) for name in ("red", "blue")]
    with_own_materials(crate(), *materials)
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.image_to_material = {"cavity"}, True
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    (image,) = bpy.data.images
    for material in materials:
        assert [node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE"] == [image]
    assert 'in the material "blue", "red"' in capfd.readouterr().out
