"""Masks of sculpt mode: what they hold, what they leave alone, and where they are refused."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc_blender.bake import sculpt_mask as masking  # noqa: E402
from paradesc_blender.scene import sculpt_masks  # noqa: E402
from paradesc_blender.show import recolor  # noqa: E402
from scene import add_sphere, attribute_values, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
RADIUS = 12.0


@pytest.fixture
def wavy():
    """A sphere with dents, in sculpt mode."""
    small_bake()
    bpy.context.scene.paradesc.radius_percent = RADIUS
    target = add_sphere(steps=16)
    points = np.empty(3 * len(target.data.vertices), np.float32)
    target.data.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    points *= 1 + 0.15 * np.cos(5 * points[:, :1])
    target.data.vertices.foreach_set("co", points.ravel())
    target.data.update()
    bpy.ops.object.mode_set(mode="SCULPT")
    return target


def baked_values(target, descriptor):
    """The values of a descriptor by a bake of the panel."""
    bpy.context.scene.paradesc.descriptors = {descriptor}
    bpy.ops.paradesc.bake()
    return attribute_values(target.data, descriptor)


def shown_values(target, descriptor):
    """The same over the range of its colors."""
    values = baked_values(target, descriptor)
    return recolor.stored_range(target.data, descriptor).shares(values)


@pytest.mark.parametrize(
    ("mask", "descriptor"), [("cavity", "cavity"), ("edge_wear", "convexity"), ("openness", "ambient_openness")]
)
def test_the_mask_is_what_a_bake_of_the_panel_gives(wavy, mask, descriptor):
    assert bpy.ops.paradesc.mask_from_shape(mask=mask) == {"FINISHED"}
    assert wavy.mode == "SCULPT"
    found = sculpt_masks.values(wavy.data)
    assert np.ptp(found) > 0.1
    np.testing.assert_allclose(found, shown_values(wavy, descriptor), atol=1e-6)  # of 32-bit floats


def test_a_mask_leaves_settings_and_attributes_as_they_were(wavy):
    before = bpy.context.scene.paradesc.descriptors
    names = {item.name for item in wavy.data.attributes}
    bpy.ops.paradesc.mask_from_shape()
    assert bpy.context.scene.paradesc.descriptors == before
    assert {item.name for item in wavy.data.attributes} - names <= {sculpt_masks.NAME}


def test_a_mask_replaces_the_one_before_and_its_inverse_is_the_rest(wavy):
    bpy.ops.paradesc.mask_from_shape(mask="cavity")
    cavity = sculpt_masks.values(wavy.data)
    bpy.ops.paradesc.mask_from_shape(mask="cavity", invert=True)
    np.testing.assert_array_equal(sculpt_masks.values(wavy.data), 1 - cavity)


def test_another_radius_gives_another_mask_and_is_the_panels_from_then_on(wavy):
    bpy.ops.paradesc.mask_from_shape()
    first = sculpt_masks.values(wavy.data)
    bpy.ops.paradesc.mask_from_shape(radius=2 * RADIUS)
    assert bpy.context.scene.paradesc.radius_percent == 2 * RADIUS
    assert np.abs(sculpt_masks.values(wavy.data) - first).max() > 0.05


def test_hidden_vertices_keep_their_mask(wavy):
    painted = np.linspace(0, 1, len(wavy.data.vertices), dtype=np.float32)
    sculpt_masks.write_shown(wavy, painted)
    bpy.ops.object.mode_set(mode="OBJECT")
    hidden = np.arange(len(painted)) % 3 == 0
    wavy.data.vertices.foreach_set("hide", hidden)
    bpy.ops.object.mode_set(mode="SCULPT")
    bpy.ops.paradesc.mask_from_shape(mask="openness")
    found = sculpt_masks.values(wavy.data)
    np.testing.assert_array_equal(found[hidden], painted[hidden])
    np.testing.assert_allclose(found[~hidden], shown_values(wavy, "ambient_openness")[~hidden], atol=1e-6)


def test_vertices_without_a_value_stay_unmasked(wavy):
    bpy.ops.object.mode_set(mode="OBJECT")
    wavy.data.vertices.add(1)
    bpy.ops.object.mode_set(mode="SCULPT")
    bpy.ops.paradesc.mask_from_shape(mask="openness")
    assert sculpt_masks.values(wavy.data)[-1] == 0


def test_the_shape_key_that_is_sculpted_is_measured(wavy):
    bpy.ops.object.mode_set(mode="OBJECT")
    wavy.shape_key_add(name="Basis")
    key = wavy.shape_key_add(name="Round")
    points = np.empty(3 * len(key.data), np.float32)
    key.data.foreach_get("co", points)
    points = points.reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    key.data.foreach_set("co", points.ravel())
    wavy.active_shape_key_index = 1
    bpy.ops.object.mode_set(mode="SCULPT")
    bpy.ops.paradesc.mask_from_shape(mask="cavity")
    assert sculpt_masks.values(wavy.data).max() == 0, "a sphere has no cavity, but its basis has"


def test_fine_meshes_are_masked_as_with_fitted_normals_but_for_what_is_not_seen(wavy, monkeypatch):
    bpy.context.scene.paradesc.backend = "cpu"
    bpy.ops.paradesc.mask_from_shape(mask="edge_wear")
    fitted = sculpt_masks.values(wavy.data)
    monkeypatch.setattr(masking, "FINE", 1)
    bpy.ops.paradesc.mask_from_shape(mask="edge_wear")
    quick = sculpt_masks.values(wavy.data)
    assert np.abs(quick - fitted).max() > 0
    # The sphere has three edges within the radius, not ten: normals by weights err by more here.
    assert np.abs(quick - fitted).mean() < 0.03


def refusal(target):
    """Why the operator cannot run; it says so itself."""
    sentence = masking.PARADESC_OT_mask_from_shape.obstacle(bpy.context)
    assert bpy.ops.paradesc.mask_from_shape.poll() == (not sentence)
    return sentence


def test_other_modes_and_dynamic_topology_are_refused_by_a_sentence(wavy):
    assert refusal(wavy) == ""
    bpy.ops.sculpt.dynamic_topology_toggle()
    assert refusal(wavy).startswith("Turn off Dyntopo")
    bpy.ops.sculpt.dynamic_topology_toggle()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert refusal(wavy).startswith("Enter sculpt mode first")


def test_multires_is_refused_with_what_can_be_done_and_taken_at_its_base(wavy):
    bpy.ops.object.mode_set(mode="OBJECT")
    modifier = wavy.modifiers.new("multires", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier="multires")
    bpy.ops.object.mode_set(mode="SCULPT")
    assert (
        refusal(wavy) == "Add-ons cannot reach the mask of Multires: apply the modifier, or set its Sculpt level to 0"
    )
    modifier.sculpt_levels = 0
    assert refusal(wavy) == ""
    assert bpy.ops.paradesc.mask_from_shape() == {"FINISHED"}


def test_a_mesh_that_cannot_be_measured_keeps_its_mask_and_says_why(wavy):
    sculpt_masks.write_shown(wavy, np.ones(len(wavy.data.vertices)))
    bpy.context.scene.paradesc.backend, bpy.context.scene.paradesc.radius_percent = "cpu", 100.0
    bpy.context.scene.paradesc.radius_unit, bpy.context.scene.paradesc.radius_absolute = "absolute", 1e6
    with pytest.raises(RuntimeError, match="radius"):
        bpy.ops.paradesc.mask_from_shape()
    assert sculpt_masks.values(wavy.data).min() == 1
