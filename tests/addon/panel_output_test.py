"""A bake writes nothing beside attributes: settings of earlier versions have no effect."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from scene import add_sphere, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def test_settings_of_earlier_versions_write_no_file_and_stop_no_bake(tmp_path):
    target, settings = add_sphere("ball"), small_bake()
    settings.write_image, settings.image_path = True, str(tmp_path / "curves.png")
    settings.write_buffers, settings.buffers_path = True, str(tmp_path / "buffers")
    settings.write_attributes = False
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert not list(tmp_path.iterdir())
    assert "mean_curvature" in target.data.attributes


def test_blender_knows_of_every_path_that_it_may_be_relative():
    scene = bpy.context.scene
    groups = [getattr(scene, name) for name in dir(scene) if name.startswith("paradesc")]
    found = [item for group in groups for item in group.bl_rna.properties if item.subtype in ("FILE_PATH", "DIR_PATH")]
    assert {item.identifier for item in found} == {"image_path", "buffers_path", "cache_folder"}
    if hasattr(found[0], "is_path_supports_blend_relative"):  # since 4.5; without, // is warned of
        assert all(item.is_path_supports_blend_relative for item in found)
