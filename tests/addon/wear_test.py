"""Wear in one click: what the material had goes through the group, and comes back. Runs inside Blender."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc_blender.scene.node_groups import input_of  # noqa: E402
from paradesc_blender.show import assets, passing, wear  # noqa: E402
from scene import add_sphere, attribute_values, fingerprint, select  # noqa: E402
from writers import node_tree  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")

# A color of the user's, as 32-bit floats hold it.
PAINT = (0.25, 0.5, 0.75, 1.0)
SIDE = 16  # texels of baked images


@pytest.fixture
def target():
    """A sphere that is fine enough for masks at its vertices."""
    return add_sphere(steps=8)


def user_material(name="paint", target=None):
    """A material of the user's: an image gives its base color, a number its roughness."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    shader = shader_of(material)
    image = tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(image.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Base Color"].default_value = PAINT
    shader.inputs["Roughness"].default_value = 0.25
    if target is not None:
        target.data.materials.append(material)
    return material


def shader_of(material):
    return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")


def links_of(material):
    """Every link of a material, by names."""
    return sorted(
        (link.from_node.name, link.from_socket.name, link.to_node.name, link.to_socket.name)
        for link in material.node_tree.links
    )


def everything_in(material):
    """Nodes with what they are set to, and links."""
    return node_tree(material.node_tree), links_of(material)


def wear_nodes(material):
    return passing.own_nodes(material.node_tree, wear.GROUP)


def add_wear(**words):
    assert bpy.ops.paradesc.add_wear(**words) == {"FINISHED"}


# ---- In and out


def test_what_the_material_had_goes_through_the_group_and_comes_back(target):
    material = user_material(target=target)
    before = everything_in(material)
    add_wear()
    (node,), shader = wear_nodes(material), shader_of(material)
    for name, output in wear.PASSED.items():
        assert shader.inputs[name].links[0].from_socket == node.outputs[output]
    assert node.inputs["Base Color"].links[0].from_node.type == "TEX_IMAGE"
    assert node.inputs["Roughness"].default_value == 0.25
    masks = {name: node.inputs[name].links[0].from_node.attribute_name for name in wear.MASKS}
    assert masks == {"Cavity": "cavity_color", "Edges": "convexity_color"}
    assert set(masks.values()) <= set(target.data.attributes.keys())
    assert bpy.ops.paradesc.remove_wear() == {"FINISHED"}
    assert everything_in(material) == before


def test_a_muted_link_stays_muted(target):
    material = user_material(target=target)
    shader_of(material).inputs["Base Color"].links[0].is_muted = True
    add_wear()
    assert wear_nodes(material)[0].inputs["Base Color"].links[0].is_muted
    bpy.ops.paradesc.remove_wear()
    assert shader_of(material).inputs["Base Color"].links[0].is_muted


def test_no_node_of_the_users_moves(target):
    material = user_material(target=target)
    before = {node.name: tuple(node.location) for node in material.node_tree.nodes}
    add_wear()
    assert {name: tuple(material.node_tree.nodes[name].location) for name in before} == before


def test_a_second_click_adds_nothing(target):
    material = user_material(target=target)
    add_wear()
    once = everything_in(material), len(bpy.data.node_groups), len(bpy.data.materials)
    add_wear()
    assert (everything_in(material), len(bpy.data.node_groups), len(bpy.data.materials)) == once


def test_the_panels_settings_and_library_list_stay(target):
    user_material(target=target)
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.write_image = {"gaussian_curvature"}, True
    add_wear()
    assert settings.descriptors == {"gaussian_curvature"}
    assert settings.write_image
    assert len(bpy.data.libraries) == 0
    assert not [block.name for block in (*bpy.data.materials, *bpy.data.node_groups) if block.asset_data is not None]


def test_masks_are_grey_whatever_the_color_map_is(target):
    user_material(target=target)
    bpy.context.scene.paradesc_looks.color_map = "viridis"
    add_wear()
    colors = np.empty(4 * len(target.data.vertices), np.float32)
    target.data.attributes["convexity_color"].data.foreach_get("color", colors)
    colors = colors.reshape(-1, 4)[:, :3]
    # Grey up to the rounding of 32-bit floats.
    assert np.abs(colors - colors[:, :1]).max() < 1e-6


def test_masks_have_the_levels_of_the_panel_from_the_beginning(target):
    user_material(target=target)
    looks = bpy.context.scene.paradesc_looks
    looks.invert = True
    add_wear()
    inverted = attribute_values(target.data, "convexity_color").copy()
    bpy.ops.paradesc.recolor(every=True)
    np.testing.assert_allclose(attribute_values(target.data, "convexity_color"), inverted, atol=1e-6)
    looks.invert = False
    bpy.ops.paradesc.recolor(every=True)
    assert np.abs(attribute_values(target.data, "convexity_color") - inverted).max() > 0.5


def test_materials_that_objects_share_have_one_group(target):
    material = user_material(target=target)
    other = add_sphere("other", steps=8)
    other.data.materials.append(material)
    select(target, other)
    add_wear()
    assert len(wear_nodes(material)) == 1
    assert all("cavity_color" in item.data.attributes for item in (target, other))


def test_of_several_slots_the_active_one_wears(target):
    first, second = user_material("first", target), user_material("second", target)
    before = everything_in(first)
    target.active_material_index = 1
    add_wear()
    assert everything_in(first) == before
    assert len(wear_nodes(second)) == 1
    sentence = "has materials without wear: 1. Make the slot of one active to add it there, too."
    assert wear.add(target) == [f'"{target.name}" {sentence}']
    target.active_material_index = 0
    assert wear.add(target) == []


def test_a_material_that_the_object_itself_has_wears(target):
    material = user_material()
    target.data.materials.append(user_material("of the mesh"))
    target.material_slots[0].link = "OBJECT"
    target.material_slots[0].material = material
    add_wear()
    assert len(wear_nodes(material)) == 1
    assert not wear_nodes(bpy.data.materials["of the mesh"])


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="every material has nodes since Blender 5")
def test_a_material_without_nodes_has_none_again_afterwards(target):
    material = bpy.data.materials.new("plain")
    material.diffuse_color = PAINT
    target.data.materials.append(material)
    add_wear()
    (node,) = wear_nodes(material)
    assert tuple(node.inputs["Base Color"].default_value) == PAINT
    bpy.ops.paradesc.remove_wear()
    assert not material.use_nodes
    material.diffuse_color = (*PAINT[1:], 1.0)
    add_wear()
    assert tuple(wear_nodes(material)[0].inputs["Base Color"].default_value) == (*PAINT[1:], 1.0)


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="every material has nodes since Blender 5")
def test_nodes_that_are_switched_off_keep_their_values_and_are_switched_off_again(target):
    material = user_material(target=target)
    before, material.use_nodes = everything_in(material), False
    add_wear()
    assert wear_nodes(material)[0].inputs["Roughness"].default_value == 0.25
    bpy.ops.paradesc.remove_wear()
    assert everything_in(material) == before
    assert not material.use_nodes


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="every material has nodes since Blender 5")
def test_nodes_that_somebody_has_added_since_still_show(target):
    material = bpy.data.materials.new("plain")
    target.data.materials.append(material)
    add_wear()
    image = material.node_tree.nodes.new("ShaderNodeTexImage")
    material.node_tree.links.new(image.outputs["Color"], wear_nodes(material)[0].inputs["Base Color"])
    bpy.ops.paradesc.remove_wear()
    assert shader_of(material).inputs["Base Color"].links[0].from_node == image
    assert material.use_nodes


# ---- Without a material


def test_a_look_reads_the_masks_where_the_bake_left_them(target):
    target.data.attributes.new("cavity", "FLOAT", "FACE")
    target.data.attributes.new("convexity_color", "BYTE_COLOR", "CORNER")
    other = add_sphere("other", steps=8)
    select(other, target)
    add_wear()
    for item, end in ((target, "_2"), (other, "")):
        read = [node.attribute_name for node in wear.vertex_masks(item.active_material)]
        assert sorted(read) == [f"cavity{end}_color", f"convexity{end}_color"]
        assert set(read) <= set(item.data.color_attributes.keys())
    add_wear()
    add_wear(look="OLD_STONE")
    assert {target.active_material, other.active_material} == set(bpy.data.materials)
    assert target.active_material != other.active_material
    assert bpy.ops.paradesc.remove_wear() == {"FINISHED"}
    assert len(bpy.data.materials) == 0


def test_objects_without_a_material_share_painted_metal_which_goes_again(target):
    other = add_sphere("other", steps=8)
    select(other, target)
    before = fingerprint(target), fingerprint(other)
    add_wear()
    assert target.active_material == other.active_material
    assert target.active_material.name == "Painted Metal"
    bpy.ops.paradesc.remove_wear()
    assert len(bpy.data.materials) == 0
    assert len(target.material_slots) == len(other.material_slots) == 0
    assert before[0][1] == fingerprint(target)[1]


@pytest.mark.parametrize("users", [True, False])
def test_only_a_slot_that_wear_has_made_goes_with_it(target, users):
    if users:
        target.data.materials.append(None)
    for _ in range(2):  # the second time the mesh has had ours before
        add_wear()
        assert target.active_material.name == "Painted Metal"
        bpy.ops.paradesc.remove_wear()
        assert [slot.material for slot in target.material_slots] == [None] * users
    assert wear.OWN_SLOT not in target.data


def test_a_slot_that_somebody_has_put_in_place_of_ours_stays(target):
    add_wear()
    target.data.materials.clear()
    target.data.materials.append(None)
    add_wear()
    bpy.ops.paradesc.remove_wear()
    assert len(target.material_slots) == 1


@pytest.mark.parametrize(("look", "name"), wear.LOOKS.items())
def test_an_object_without_a_material_gets_the_look_that_was_chosen(target, look, name):
    add_wear(look=look)
    assert target.active_material.name == name
    add_wear()
    assert [item.name for item in bpy.data.materials] == [name]


def test_another_look_has_its_own_colors_and_takes_the_place_of_one_that_nobody_has_changed(target):
    add_wear()
    for name in ("OLD_STONE", "DUSTY_PLASTIC", "PAINTED_METAL"):
        add_wear(look=name)
        assert [item.name for item in bpy.data.materials] == [wear.LOOKS[name]]
        assert target.active_material.name == wear.LOOKS[name]
    bpy.ops.paradesc.remove_wear()
    assert len(bpy.data.materials) == len(target.material_slots) == 0


def test_another_look_leaves_the_material_of_one_that_somebody_has_changed(target):
    add_wear()
    wear_nodes(target.active_material)[0].inputs["Dirt Amount"].default_value = 0.125
    add_wear(look="OLD_STONE")
    assert target.active_material.name == "Painted Metal"


def test_a_look_that_was_tuned_stays(target):
    add_wear()
    target.active_material.node_tree.nodes[wear.GROUP].inputs["Dirt Amount"].default_value = 0.125
    bpy.ops.paradesc.remove_wear()
    assert target.active_material.name == "Painted Metal"


# ---- Looks and tuning


@pytest.mark.parametrize("look", wear.LOOKS)
def test_a_look_sets_what_is_not_tuned(target, look):
    material = user_material(target=target)
    add_wear()
    (node,) = wear_nodes(material)
    own = wear.values_of(node)
    node.inputs["Dirt Level"].default_value = 0.0625
    add_wear(look=look)
    values = wear.values_of(node)
    assert values == {**wear.look_values(material.node_tree, look), "Dirt Level": 0.0625}
    assert values != {**own, "Dirt Level": 0.0625}
    add_wear(look="AS_IS")
    assert wear.values_of(node) == {**own, "Dirt Level": 0.0625}
    assert [item.name for item in bpy.data.materials] == ["paint"]


def test_wear_that_was_tuned_stays_disconnected_and_comes_back(target):
    material = user_material(target=target)
    before = links_of(material)
    add_wear()
    wear_nodes(material)[0].inputs["Edge Amount"].default_value = 0.125
    bpy.ops.paradesc.remove_wear()
    assert set(before) <= set(links_of(material))
    assert shader_of(material).inputs["Base Color"].links[0].from_node.type == "TEX_IMAGE"
    add_wear()
    (node,) = wear_nodes(material)
    assert node.inputs["Edge Amount"].default_value == 0.125
    assert shader_of(material).inputs["Base Color"].links[0].from_node == node


def test_a_mask_of_the_users_stays_linked(target):
    material = user_material(target=target)
    add_wear()
    (node,) = wear_nodes(material)
    image = next(item for item in material.node_tree.nodes if item.type == "TEX_IMAGE")
    material.node_tree.links.new(image.outputs["Alpha"], node.inputs["Edges"])
    add_wear()
    assert node.inputs["Edges"].links[0].from_node == image
    bpy.ops.paradesc.remove_wear()
    assert image.name in material.node_tree.nodes


def test_wear_whose_masks_other_nodes_use_stays_with_a_sentence(target):
    material = user_material(target=target)
    add_wear()
    (node,) = wear_nodes(material)
    material.node_tree.links.new(node.outputs["Dirt"], shader_of(material).inputs["Alpha"])
    before = links_of(material)
    (sentence,) = wear.remove(target)
    assert "Dirt" in sentence
    assert links_of(material) == before


def test_a_group_from_which_somebody_took_an_input_still_goes_in_and_out(target):
    material = user_material(target=target)
    before = everything_in(material)
    group = assets.shared_group(wear.GROUP)
    for name in ("Metallic", "Dirt Level", "Proportions"):
        (group.interface if hasattr(group, "interface") else group.inputs).remove(input_of(group, name))
    add_wear(look="OLD_STONE")
    assert len(wear_nodes(material)) == 1
    bpy.ops.paradesc.remove_wear()
    assert everything_in(material) == before


# ---- What stands in the way


def linked_target(tmp_path):
    """An object of another file, linked."""
    made = add_sphere("from elsewhere", steps=8)
    user_material("theirs", made)
    path = tmp_path / "library.blend"
    bpy.data.libraries.write(str(path), {made})
    bpy.data.objects.remove(made)
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.objects = ["from elsewhere"]
    bpy.context.collection.objects.link(wanted.objects[0])
    select(wanted.objects[0])
    return wanted.objects[0]


def test_a_linked_object_is_one_sentence(tmp_path):
    target = linked_target(tmp_path)
    with pytest.raises(RuntimeError, match="linked"):
        bpy.ops.paradesc.add_wear()
    assert not wear_nodes(target.active_material)


def test_beside_a_linked_object_the_others_wear(tmp_path):
    linked, target = linked_target(tmp_path), add_sphere(steps=8)
    material = user_material(target=target)
    select(linked, target)
    add_wear()
    assert len(wear_nodes(material)) == 1
    assert not wear_nodes(linked.active_material)


def test_a_look_in_another_file_is_not_given_to_objects_of_this_one(target, tmp_path):
    add_wear()
    path = tmp_path / "library.blend"
    bpy.data.libraries.write(str(path), {target.active_material})
    bpy.ops.paradesc.remove_wear()
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.materials = ["Painted Metal"]
    add_wear()
    assert target.active_material.library is None


@pytest.mark.parametrize("on", [True, False])
def test_a_material_without_a_principled_shader_is_one_sentence_and_bakes_nothing(target, on):
    material = user_material(target=target)
    material.node_tree.nodes.remove(shader_of(material))
    material.use_nodes = on
    before = everything_in(material)
    with pytest.raises(RuntimeError, match="no Principled BSDF"):
        bpy.ops.paradesc.add_wear()
    assert everything_in(material) == before
    assert "cavity" not in target.data.attributes


def test_there_is_nothing_to_remove_where_nothing_wears(target):
    user_material(target=target)
    with pytest.raises(RuntimeError, match="has wear"):
        bpy.ops.paradesc.remove_wear()


def test_a_slot_that_is_empty_beside_others_is_said_to_be_so(target, capfd):
    paint = user_material(target=target)
    target.data.materials.append(None)
    target.active_material_index = 1
    add_wear()
    said = capfd.readouterr().out
    assert '"sphere" had no active material' in said
    assert '"sphere" has materials without wear: 1.' in said
    assert not wear_nodes(paint)
