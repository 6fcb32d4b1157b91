"""Making and removing our materials keeps slots, what faces were given since, and what was tuned."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from writers import bake, click, materials, tuned_material  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def slots_and_faces(target):
    """The slots of an object's faces, and the materials in these."""
    slots = [(item.link, item.material.name) for item in target.material_slots]
    return slots, [slots[face.material_index] for face in target.data.polygons]


def test_removing_our_material_keeps_what_objects_have_in_slots_behind_it(target):
    bake(target)
    materials(target)
    click("make_material")(target)
    target.data.materials.append(bpy.data.materials["cloth"])
    target.material_slots[3].link = "OBJECT"
    target.material_slots[3].material = bpy.data.materials["skin"]
    assert bpy.ops.paradesc.remove_material() == {"FINISHED"}
    slots, _ = slots_and_faces(target)
    assert slots == [("DATA", "skin"), ("OBJECT", "skin"), ("OBJECT", "skin")]


def test_removing_our_material_leaves_no_slot_where_there_was_none(target):
    click("make_material")(target)
    bpy.ops.paradesc.remove_material()
    assert len(target.material_slots) == len(target.data.materials) == 0


def other_way(target):
    click("make_material", kind="flat")(target)


@pytest.mark.parametrize("between", [lambda _target: None, other_way])
def test_removing_our_material_keeps_what_faces_were_given_since(between, target):
    bake(target)
    materials(target)
    click("make_material")(target)
    target.data.polygons[0].material_index = 1
    between(target)
    bpy.ops.paradesc.remove_material()
    found = [face.material_index for face in target.data.polygons]
    assert found == [1, *(number % 2 for number in range(1, len(found)))]


def test_removing_our_material_finds_slots_that_were_moved(target):
    bake(target)
    materials(target)
    target.material_slots[1].link = "DATA"
    _, before = slots_and_faces(target)
    click("make_material")(target)
    target.active_material_index = 1
    bpy.ops.object.material_slot_move(direction="UP")
    bpy.ops.paradesc.remove_material()
    _, after = slots_and_faces(target)
    assert after == before


def test_a_material_of_ours_that_was_tuned_stays_and_is_saved(target):
    bake(target)
    tuned_material(target)
    target.data.materials[0].name = "mine"
    bpy.ops.paradesc.remove_material()
    assert bpy.data.materials["mine"].use_fake_user
    assert len(target.data.materials) == 0


def test_the_base_color_that_was_set_on_the_cavity_group_comes_back(target):
    bake(target)
    materials(target)
    material = target.data.materials[0]
    target.active_material_index = 0
    bpy.ops.paradesc.plug_cavity()
    node = next(node for node in material.node_tree.nodes if node.type == "GROUP")
    node.inputs["Base Color"].default_value = (0.25, 0.5, 0.75, 1.0)
    bpy.ops.paradesc.remove_material()
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    assert tuple(shader.inputs["Base Color"].default_value) == (0.25, 0.5, 0.75, 1.0)
