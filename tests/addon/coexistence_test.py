"""Blender draws the same before and after the library has used OpenGL in its process."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from render_test import look_at, pixels, render_still  # noqa: E402

from scene import add_sphere, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["CYCLES", "BLENDER_WORKBENCH"])
def test_a_frame_looks_the_same_before_and_after_bakes(engine, tmp_path):
    target = add_sphere(steps=8)
    look_at(bpy.context.scene, engine)
    bpy.context.collection.objects.link(bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN")))
    try:
        render_still(tmp_path / "before.png")
    except RuntimeError as error:
        pytest.skip(f"this Blender cannot render by {engine} without a window: {error}")
    before = pixels(tmp_path / "before.png")
    assert before[..., :3].max() > before[..., :3].min(), "an empty picture shows nothing"
    small_bake()
    for number in range(3):
        assert bpy.ops.paradesc.bake() == {"FINISHED"}
        assert "mean_curvature" in target.data.attributes
        path = tmp_path / f"after{number}.png"
        render_still(path)
        assert (pixels(path) == before).all()
