"""The add-on's preferences: what holds for this machine, whatever scene is open."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.scene import record  # noqa: E402
from paradesc.settings import properties  # noqa: E402
from scene import add_sphere, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def preferences():
    """The preferences of the add-on as if it were enabled."""
    addon = bpy.context.preferences.addons.new()
    addon.module = "paradesc"
    yield addon.preferences
    bpy.context.preferences.addons.remove(addon)


def test_without_a_limit_the_library_takes_its_own(preferences):
    assert preferences.memory_limit == 0
    assert properties.job_settings(bpy.context.scene.paradesc).memory_limit == 0


def test_a_limit_refuses_the_bake_in_one_sentence_and_is_no_part_of_the_scene(preferences):
    target = add_sphere()
    small_bake()
    preferences.memory_limit = 0.001
    with pytest.raises(RuntimeError, match="memory limit"):
        bpy.ops.paradesc.bake()
    assert not record.attributes_of(target.data)
    preferences.memory_limit = 2.5
    settings = properties.job_settings(bpy.context.scene.paradesc)
    assert settings.memory_limit == 2_500_000_000
    assert "memory_limit" not in settings.as_dict()
    assert bpy.ops.paradesc.bake() == {"FINISHED"}


def test_without_the_add_on_enabled_there_is_none():
    assert properties.job_settings(bpy.context.scene.paradesc).memory_limit == 0
