"""Wear on inputs that are animated, driven, or read by drivers. Runs inside Blender."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from wear_test import add_wear, shader_of, target, user_material, wear_nodes  # noqa: E402, F401

from scene import add_sphere, select  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.mark.parametrize("shared", [False, True])
def test_animated_and_driven_inputs_go_through_the_group_and_come_back(target, shared):
    material, scene = user_material(target=target), bpy.context.scene
    tree, inputs = material.node_tree, shader_of(material).inputs
    for frame, value in ((1, 0.125), (3, 0.875)):
        inputs["Roughness"].default_value = value
        inputs["Roughness"].keyframe_insert("default_value", frame=frame)
    inputs["Metallic"].driver_add("default_value").driver.expression = "frame / 4"
    other = material.copy() if shared else None
    if shared:
        other.node_tree.animation_data.action = tree.animation_data.action
        add_sphere("other").data.materials.append(other)
        select(target)
    add_wear()
    worn = wear_nodes(material)[0].inputs
    for frame, value in ((1, 0.125), (3, 0.875)):
        scene.frame_set(frame)
        shown = worn["Roughness"].default_value, worn["Metallic"].default_value
        assert shown == pytest.approx((value, frame / 4))  # since Blender 5.0 a driver has fewer digits
        assert not shared or shader_of(other).inputs["Roughness"].default_value == value
    assert bpy.ops.paradesc.remove_wear() == {"FINISHED"}
    inputs = shader_of(material).inputs
    for frame, value in ((1, 0.125), (3, 0.875)):
        scene.frame_set(frame)
        shown = inputs["Roughness"].default_value, inputs["Metallic"].default_value
        assert shown == pytest.approx((value, frame / 4))


@pytest.mark.parametrize("of_tree", [False, True])
@pytest.mark.parametrize("member", ['inputs["Roughness"].default_value', 'inputs["Base Color"].default_value[1]'])
def test_a_driver_that_reads_an_input_reads_it_wherever_it_goes(target, member, of_tree):
    material = user_material(target=target)
    driver = target.driver_add("location", 2).driver
    driver.type = "SUM"
    read = driver.variables.new().targets[0]
    read.id_type, read.id = ("NODETREE", material.node_tree) if of_tree else ("MATERIAL", material)
    read.data_path = ("" if of_tree else "node_tree.") + f'nodes["{shader_of(material).name}"].{member}'
    before = read.data_path

    def heights():
        """The height to which the driver moves the object, before and after the input is set."""
        for value in (0.25, 0.75):
            node = next(iter(wear_nodes(material)), shader_of(material))
            node.inputs["Roughness"].default_value = value
            node.inputs["Base Color"].default_value = [value] * 4
            bpy.context.view_layer.update()
            yield target.location.z

    assert list(heights()) == pytest.approx([0.25, 0.75])
    add_wear()
    assert list(heights()) == pytest.approx([0.25, 0.75])
    assert bpy.ops.paradesc.remove_wear() == {"FINISHED"}
    assert list(heights()) == pytest.approx([0.25, 0.75])
    assert read.id.path_resolve(read.data_path) == read.id.path_resolve(before)
