"""A bake that comes to nothing leaves all settings as they were, and a mask changes no others."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc_blender.bake import batch  # noqa: E402
from paradesc_blender.settings import snapshot  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def settings_of(scene):
    """Every setting and color, and whether it is stored."""
    groups = (scene.paradesc, scene.paradesc_looks)
    names = [(group, item.identifier) for group in groups for item in group.bl_rna.properties]
    return {
        (type(group).__name__, name): (str(getattr(group, name)), group.is_property_set(name))
        for group, name in names
        if name != "rna_type"
    }


def tuned_settings(scene):
    """Settings as somebody has tuned them."""
    settings = scene.paradesc
    settings.samples, settings.radius_percent, settings.creases = 999, 4.0, "none"
    scene.paradesc_looks.color_map, scene.paradesc_looks.show_legend = "heat", False
    settings.property_unset("descriptors")


def without_faces(target):
    target.data.clear_geometry()


@pytest.mark.parametrize("spoil", [without_faces])
@pytest.mark.parametrize("words", [{"mask": "edge_wear"}, {"mask": "curvature", "radius": 7.0}, {"radius": 7.0}])
def test_a_bake_that_fails_leaves_all_settings_as_they_were(spoil, words, target):
    tuned_settings(bpy.context.scene)
    spoil(target)
    before = settings_of(bpy.context.scene)
    with pytest.raises(RuntimeError, match="Error"):
        bpy.ops.paradesc.bake(**words)
    assert settings_of(bpy.context.scene) == before


def test_a_bake_that_is_cancelled_leaves_all_settings_as_they_were(target, monkeypatch):
    tuned_settings(bpy.context.scene)
    before = settings_of(bpy.context.scene)
    step = batch.Batch.step
    monkeypatch.setattr(batch.Batch, "step", lambda made, wait=False: (made.cancel(), step(made, wait)))
    assert bpy.ops.paradesc.bake(mask="edge_wear", radius=7.0) == {"CANCELLED"}
    assert settings_of(bpy.context.scene) == before


def test_a_mask_chooses_its_descriptors_and_leaves_all_else(target):
    scene = bpy.context.scene
    tuned_settings(scene)
    before = settings_of(scene)
    assert bpy.ops.paradesc.mask(name="edge_wear") == {"FINISHED"}
    assert scene.paradesc.descriptors == {"convexity"}
    after = settings_of(scene)
    assert {key[1] for key, value in after.items() if before[key] != value} == {"descriptors"}
    assert bpy.ops.paradesc.bake(mask="cavity") == {"FINISHED"}
    assert (scene.paradesc.samples, scene.paradesc.radius_percent) == (999, 4.0)


def test_a_mask_leaves_the_unit_and_a_typed_radius(target):
    settings = bpy.context.scene.paradesc
    settings.radius_unit, settings.radius_absolute = "absolute", 2.0
    bpy.ops.paradesc.mask(name="openness")
    assert (settings.radius_unit, settings.radius_absolute, settings.radius_fit) == ("absolute", 2.0, "typed")


def test_settings_of_a_file_that_is_gone_are_brought_to_no_other(target):
    tuned_settings(bpy.context.scene)
    kept = snapshot.Snapshot(bpy.context.scene)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    before = settings_of(bpy.context.scene)
    kept.restore()
    assert settings_of(bpy.context.scene) == before
