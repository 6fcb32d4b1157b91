"""Values on the mesh that modifiers make: exact, side by side, without a second object; what is the user's stays."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import switch  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.core import color_maps, job, source_kinds  # noqa: E402
from paradesc_blender.scene import carrying, delivery, mesh_io, record, source_meshes, targets  # noqa: E402
from paradesc_blender.show import recolor  # noqa: E402
from scene import attribute_values, select, small_bake, subdivide  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
QUICK = job.Settings(("convexity",), bridge.Options(radius=0.1, samples=64), "cpu")
STACKS = {
    "bevel": [("BEVEL", {"segments": 3, "width": 0.2})],
    "subdivision": [("SUBSURF", {"levels": 2})],
    "mirror and solidify": [("MIRROR", {}), ("SOLIDIFY", {"thickness": 0.1})],
    "array": [("ARRAY", {"count": 2})],
    "bevel of a bent mesh": [("SIMPLE_DEFORM", {"deform_method": "BEND"}), ("BEVEL", {"segments": 2, "width": 0.2})],
    "remesh": [("REMESH", {"voxel_size": 0.3})],
}


def box(stack="bevel", name="box"):
    """A cube with these modifiers, the active object."""
    bpy.ops.mesh.primitive_cube_add()
    made = bpy.context.view_layer.objects.active
    made.name = made.data.name = name
    for kind, settings in STACKS.get(stack, []):
        modifier = made.modifiers.new(kind, kind)
        for member, value in settings.items():
            setattr(modifier, member, value)
    bpy.context.view_layer.update()
    return made


def bake(*names, source=source_kinds.AUTOMATIC):
    """Bakes these descriptors on what is selected."""
    small_bake("cpu").descriptors = set(names)
    bpy.context.scene.paradesc_animation.source = source
    assert bpy.ops.paradesc.bake() == {"FINISHED"}


def shown(target, name):
    """The values of an attribute that the viewport, materials and exporters get."""
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=bpy.context.evaluated_depsgraph_get())
    found = attribute_values(mesh, name)
    evaluated.to_mesh_clear()
    return found


def ours(target):
    """The modifiers that carry values."""
    return [item for item in target.modifiers if carrying.is_ours(item)]


def stock():
    """How much there is of all that carrying needs."""
    return tuple(len(kind) for kind in (bpy.data.objects, bpy.data.meshes, bpy.data.node_groups))


# ---- What is seen


@pytest.mark.parametrize("stack", STACKS)
def test_the_evaluated_mesh_has_the_values_that_were_measured(stack):
    target = box(stack)
    reading = source_meshes.read(target, "evaluated")
    results = job.run(reading.arrays, QUICK)
    assert delivery.deliver(target, results, reading) == []
    np.testing.assert_array_equal(shown(target, "convexity"), results.values["convexity"])
    colors = color_maps.linear_rgba(color_maps.colors(results.values["convexity"], results.shown("convexity")))
    np.testing.assert_array_equal(shown(target, "convexity_color"), colors.astype(np.float32))
    np.testing.assert_array_equal(shown(target, "coverage"), results.coverage)


def test_the_colors_are_the_active_ones_of_the_evaluated_mesh():
    target = box()
    bake("convexity")
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=bpy.context.evaluated_depsgraph_get())
    assert mesh.color_attributes.active_color.name == "convexity_color"
    assert mesh.color_attributes[mesh.color_attributes.render_color_index].name == "convexity_color"
    evaluated.to_mesh_clear()
    assert recolor.baked_names(target.data) == ["convexity"]
    assert recolor.shown_name(target.data) == "convexity"


def test_no_second_object_is_in_the_scene():
    target = box()
    bake("convexity")
    assert list(bpy.context.scene.objects) == [target]
    assert list(bpy.context.view_layer.objects) == [target]
    assert list(bpy.context.view_layer.objects.selected) == [target]


@pytest.mark.parametrize("stack", ["bevel", "subdivision"])
def test_earlier_masks_stay_to_the_bit(stack):
    target = box(stack)
    bake("convexity")
    before = [shown(target, name) for name in ("convexity", "convexity_color")]
    bake("cavity")
    for name, values in zip(("convexity", "convexity_color"), before, strict=True):
        np.testing.assert_array_equal(shown(target, name), values)
    assert recolor.baked_names(target.data) == ["cavity", "convexity"]
    assert np.ptp(shown(target, "convexity")) > 0.01  # they are not all one value


def test_own_vertices_have_the_values_of_the_nearest_vertices_in_the_same_range():
    target = box()
    bake("convexity")
    carrier = carrying.carrier_of(target)
    own, made = (mesh_io.read_positions(mesh) for mesh in (target.data, carrier))
    distance = np.linalg.norm(own[:, None] - made[None], axis=2)
    values, found = attribute_values(target.data, "convexity"), attribute_values(carrier, "convexity")
    for row, value in zip(distance, values, strict=True):
        assert value in found[row < row.min() + 1e-6]
    assert record.read(target.data)["ranges"] == record.read(carrier)["ranges"]


def test_baking_again_piles_nothing_up():
    target = box()
    bake("convexity")
    before = stock()
    for _ in range(2):
        bake("convexity")
        bake("cavity")
    assert stock() == before
    assert [item.name for item in target.modifiers] == ["BEVEL", carrying.MODIFIER]


# ---- Modifiers that change afterwards


def test_a_changed_width_moves_the_values_along():
    target = box()
    bake("convexity")
    before = shown(target, "convexity")
    target.modifiers["BEVEL"].width = 0.5
    np.testing.assert_array_equal(shown(target, "convexity"), before)


def test_more_segments_take_the_values_of_the_nearest_places():
    target = box()
    bake("convexity")
    before = shown(target, "convexity")
    target.modifiers["BEVEL"].segments = 7
    after = shown(target, "convexity")
    assert len(after) > 2 * len(before)
    # On a flat face between values, and no place of the surface has others.
    assert after.min() >= before.min() - 1e-6
    assert after.max() <= before.max() + 1e-6
    assert np.unique(after.round(4)).size > np.unique(before.round(4)).size


def test_another_level_in_another_pose_has_what_blender_mixes_of_the_own_vertices():
    target = box("subdivision")
    bake("convexity")
    target.modifiers["SUBSURF"].levels = 3  # renders have a level of their own
    target.modifiers.new("Bend", "SIMPLE_DEFORM").deform_method = "BEND"
    bpy.ops.object.modifier_move_to_index(modifier="Bend", index=1)
    found = shown(target, "convexity")
    ours(target)[0].show_viewport = False
    bpy.context.view_layer.update()
    np.testing.assert_array_equal(found, shown(target, "convexity"))
    assert np.ptp(found) > 0


def test_a_modifier_that_is_added_behind_is_measured_by_the_next_bake():
    target = box()
    bake("convexity")
    target.modifiers.new("Subdivision", "SUBSURF").levels = 1
    bake("cavity")
    assert target.modifiers[-1] == ours(target)[0]
    count = len(source_meshes.read(target, "evaluated").arrays.positions)
    assert len(carrying.carrier_of(target).vertices) == count == len(shown(target, "cavity"))


def test_values_for_the_base_mesh_are_shown_from_then_on():
    target = box()
    bake("convexity")
    bake("cavity")
    bake("convexity", source="original")
    assert carrying.carried_names(target) == ["cavity", "cavity_color"]
    # The corners are all alike, and Bevel mixes their values in floats.
    assert np.ptp(attribute_values(target.data, "convexity")) == 0
    np.testing.assert_allclose(shown(target, "convexity"), attribute_values(target.data, "convexity")[0], rtol=1e-6)
    before = stock()
    bake("cavity", source="original")
    assert ours(target) == []
    assert stock() == tuple(np.array(before) - 1)  # the carrier, its mesh and the group are gone


@pytest.mark.parametrize("stack", ["bevel", "subdivision"])
def test_what_is_measured_does_not_depend_on_ours(stack):
    target = box(stack)
    before = [source_meshes.read(target, source) for source in source_kinds.NAMES]
    bake("convexity")
    for former in before:
        reading = source_meshes.read(target, former.source)
        np.testing.assert_array_equal(reading.arrays.positions, former.arrays.positions)
        np.testing.assert_array_equal(reading.arrays.corner_vertices, former.arrays.corner_vertices)
        assert (reading.own, reading.notes) == (former.own, former.notes)


def test_ours_alone_does_not_make_a_surface_shown_otherwise():
    target = box()
    bake("convexity")
    target.modifiers.remove(target.modifiers["BEVEL"])
    assert targets.shown_source(target) == source_kinds.ORIGINAL
    assert ours(target)


def test_live_values_of_the_base_mesh_are_shown_instead_of_carried_ones():
    target = box("subdivision")
    bake("convexity")
    bpy.context.scene.paradesc.descriptors = {"convexity"}
    bpy.context.scene.paradesc_animation.source = "original"
    assert switch(target) == ""
    bpy.context.view_layer.update()
    assert carrying.carried_names(target) == []
    own = attribute_values(target.data, "convexity")
    assert shown(target, "convexity").max() <= own.max() + 1e-6
    switch(target, "OFF")


# ---- Ours and the user's


def muted(group):
    group.nodes["Switch"].mute = True


def cut(group):
    group.links.remove(group.nodes["Sample Index"].inputs["Index"].links[0])


def with_a_node(group):
    group.nodes.new("GeometryNodeSetPosition")


def of_an_own_object(group):
    other = bpy.data.objects.new("mine", bpy.data.meshes.new("mine"))
    group.nodes[carrying.CARRIER].inputs["Object"].default_value = other


@pytest.mark.parametrize("change", [muted, cut, with_a_node, of_an_own_object])
def test_nodes_that_were_edited_stay_and_others_are_made(change):
    target = box()
    bake("convexity")
    group = target.modifiers[-1].node_group
    change(group)
    nodes, count = group.nodes.keys(), len(group.links)
    assert ours(target) == []
    for _ in range(2):
        bake("cavity")
        assert [item.node_group == group for item in target.modifiers if item.type == "NODES"] == [True, False]
        assert (group.nodes.keys(), len(group.links)) == (nodes, count)
    assert len(bpy.data.objects.get("mine", target).data.vertices) in (0, 8)
    assert len(shown(target, "cavity")) == len(source_meshes.read(target, "evaluated").arrays.positions)


@pytest.mark.parametrize("deleted", ["modifier", "carrier"])
@pytest.mark.parametrize("source", [source_kinds.AUTOMATIC, source_kinds.ORIGINAL])
def test_what_somebody_has_deleted_by_hand_leaves_nothing_behind_at_the_next_bake(deleted, source):
    target = box()
    before = stock()
    bake("convexity")
    if deleted == "modifier":
        target.modifiers.remove(target.modifiers[-1])
    else:
        bpy.data.objects.remove(carrying.held_by(target.modifiers[-1].node_group))
    bake("convexity", source=source)
    if source == source_kinds.AUTOMATIC:
        assert len(ours(target)) == 1
        assert len(shown(target, "convexity")) == len(source_meshes.read(target, "evaluated").arrays.positions)
    else:
        assert ours(target) == []
    bpy.data.orphans_purge()  # the mesh of a deleted object, as saving does
    assert stock() == tuple(count + (source == source_kinds.AUTOMATIC) for count in before)


def test_a_carrier_that_somebody_uses_stays_as_it_is():
    target = box()
    bake("convexity")
    carrier = carrying.held_by(ours(target)[0].node_group)
    bpy.context.collection.objects.link(carrier)
    mesh = carrier.data
    bake("cavity")
    assert carrier.data == mesh
    assert "cavity" not in mesh.attributes
    assert carrying.held_by(ours(target)[0].node_group) != carrier
    assert recolor.baked_names(target.data) == ["cavity", "convexity"]
    assert len(ours(target)) == 1


def copied(target):
    """A copy with its own mesh, as Duplicate Objects makes it: its modifier has the nodes of the first."""
    copy = target.copy()
    copy.data = target.data.copy()
    bpy.context.collection.objects.link(copy)
    return copy


def test_a_copy_keeps_what_it_shows_when_the_first_is_baked_again():
    target = box()
    bake("convexity")
    copy = copied(target)
    before = shown(copy, "convexity")
    select(target)
    target.modifiers["BEVEL"].segments = 5
    bake("convexity")
    np.testing.assert_array_equal(shown(copy, "convexity"), before)
    assert len(shown(target, "convexity")) > len(before)


@pytest.mark.parametrize("stack", ["bevel", "subdivision"])
def test_live_values_of_a_copy_leave_those_of_the_first_alone(stack):
    target = box(stack)
    bake("convexity")
    before = [shown(target, name) for name in ("convexity", "convexity_color")]
    copy = copied(target)
    for vertex in copy.data.vertices:
        vertex.co.z *= 3.0
    bpy.context.view_layer.update()
    assert switch(copy) == ""
    assert not np.array_equal(shown(copy, "convexity"), before[0])
    for name, values in zip(("convexity", "convexity_color"), before, strict=True):
        np.testing.assert_array_equal(shown(target, name), values)


def test_other_colors_of_a_copy_leave_those_of_the_first_alone():
    target = box()
    bake("convexity")
    before = shown(target, "convexity_color")
    select(copied(target))
    for color_map in ("viridis", "heat"):  # the second needs no further carrier
        bpy.context.scene.paradesc_looks.color_map = color_map
        assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    np.testing.assert_array_equal(shown(target, "convexity_color"), before)
    assert not np.array_equal(shown(bpy.context.object, "convexity_color"), before)
    assert stock() == (4, 4, 2)


def test_objects_that_share_a_mesh_show_the_same():
    target = box()
    other = target.copy()
    bpy.context.collection.objects.link(other)
    for _ in range(2):
        bake("convexity")
        np.testing.assert_array_equal(shown(other, "convexity"), shown(target, "convexity"))
    assert len(ours(other)) == len(ours(target)) == 1
    assert stock() == (3, 2, 1)
    bake("convexity", source="original")
    assert ours(other) == ours(target) == []


def test_a_bake_that_cannot_be_written_leaves_no_trace():
    target = box("subdivision")
    reading = source_meshes.read(target, "evaluated")
    results, before = job.run(reading.arrays, QUICK), stock()
    subdivide()
    with pytest.raises(bridge.ParadescError, match="was changed while"):
        delivery.deliver(target, results, reading)
    assert stock() == before
    assert "convexity" not in target.data.attributes
    assert ours(target) == []


def test_a_stack_that_changed_during_a_bake_shows_the_nearest_values():
    target = box()
    reading = source_meshes.read(target, "evaluated")
    results = job.run(reading.arrays, QUICK)
    target.modifiers["BEVEL"].segments = 5
    delivery.deliver(target, results, reading)
    found = shown(target, "convexity")
    assert len(found) > len(reading.arrays.positions)
    assert 0 < np.ptp(found) <= np.ptp(results.values["convexity"])


def test_in_edit_mode_the_base_mesh_is_measured_and_shown():
    target = box()
    bake("convexity")
    bpy.ops.object.mode_set(mode="EDIT")
    bake("convexity")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert ours(target) == []
    assert len(attribute_values(target.data, "convexity")) == 8
