"""Bake to Image in Blender's window: the texture is seen on the mesh at once, and goes and comes with its button.

run_in_window.sh starts it. It compares the pixels of the viewport.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler

words = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [words[0], str(Path(words[0]).parents[1] / "addon")]
from paradesc_blender.bake.modal import ModalJob  # noqa: E402
from paradesc_blender.scene import image_preview  # noqa: E402
from window import begin, prepare, run_in_view, say, screen_pixels, view_context, wait_for  # noqa: E402

STEP, BLACK, BRIGHT = 0.1, 0.02, 0.5


def seen() -> np.ndarray:
    """(height, width) brightness of the middle of the viewport, where the front of the cube is."""
    area = view_context()["area"]
    pixels = screen_pixels()[area.y : area.y + area.height, area.x : area.x + area.width].mean(axis=2)
    height, width = pixels.shape
    return pixels[height // 10 : 9 * height // 10, width // 2 - 2 * height // 5 : width // 2 + 2 * height // 5]


def shows_mask() -> bool:
    """Returns whether a black face with bright edges is seen."""
    pixels = seen()
    return (pixels < BLACK).mean() > 0.3 and (pixels > BRIGHT).mean() > 0.01


def texture_is_seen() -> Iterator[None]:
    """Bakes a cube, hides and shows its texture, undoes and redoes."""
    bpy.ops.mesh.primitive_cube_add()
    target, settings = bpy.context.object, bpy.context.scene.paradesc
    settings.descriptors, settings.texels = {"convexity"}, 256
    view = view_context()["area"].spaces[0]
    for name in ("show_floor", "show_axis_x", "show_axis_y", "show_text", "show_cursor"):
        setattr(view.overlay, name, False)
    view.show_gizmo = False
    run_in_view(bpy.ops.view3d.view_axis, type="FRONT")
    run_in_view(bpy.ops.view3d.view_selected)
    bpy.ops.ed.undo_push(message="cube")
    for _ in range(10):  # the view turns smoothly
        yield
    assert not shows_mask()
    look, materials = (view.shading.color_type, view.shading.light), len(bpy.data.materials)
    run_in_view(bpy.ops.paradesc.bake_image, "INVOKE_DEFAULT", True)
    yield from wait_for(lambda: ModalJob.running is None)
    yield from wait_for(shows_mask)
    assert (view.shading.color_type, view.shading.light) == look
    assert len(bpy.data.materials) == materials
    assert image_preview.shown(target) == "Cube_edges"
    say("a texture is seen at once, and no material made")
    for there in (False, True):
        run_in_view(bpy.ops.paradesc.show_image)
        yield from wait_for(lambda: shows_mask() == there)  # noqa: B023 (waited for before the next one)
    for step, there in ((bpy.ops.ed.undo, False), (bpy.ops.ed.redo, True)):
        run_in_view(step)
        yield from wait_for(lambda: shows_mask() == there)  # noqa: B023
    say("it goes and comes with its button, and with undo")
    yield from far_texture_is_whole()
    run_in_view(bpy.ops.paradesc.bake, "INVOKE_DEFAULT", True)
    yield from wait_for(lambda: ModalJob.running is None)
    yield from wait_for(lambda: not shows_mask())
    say("vertex colors take its place")
    before = len(bpy.context.window_manager.windows)
    run_in_view(bpy.ops.paradesc.open_image)
    windows = bpy.context.window_manager.windows
    assert len(windows) == before + 1
    assert windows[-1].screen.areas[0].spaces.active.image.name == "Cube_edges"
    say("an image editor opens where there is none")


def far_texture_is_whole() -> Iterator[None]:
    """Shows the cube from near, and one 300 times as large from 300 times as far: the picture is the same.

    One step of the depth buffer is longer than a thousandth of the large one, whose own surface must not show through.
    """
    target, view = bpy.context.object, view_context()["area"].spaces[0]
    view.region_3d.view_perspective, view.clip_end = "PERSP", 20000.0
    view.region_3d.view_rotation, view.region_3d.view_location = Euler((1.1, 0.0, 0.5)).to_quaternion(), (0.0, 0.0, 0.0)
    black = []
    for size in (1.0, 300.0):
        target.scale, view.region_3d.view_distance = (size, size, size), 6.0 * size
        for _ in range(10):
            yield
        black.append((seen() < BLACK).mean())
    assert black[0] > 0.01, black
    assert abs(black[1] - black[0]) < 0.03 * black[0], black
    say("a texture is whole far away")
    target.scale = (1.0, 1.0, 1.0)
    run_in_view(bpy.ops.view3d.view_axis, type="FRONT")
    run_in_view(bpy.ops.view3d.view_selected)
    yield from wait_for(shows_mask)


def steps() -> Iterator[None]:
    """Does what the person does; every yield is a turn of the event loop."""
    yield from texture_is_seen()
    say("all steps passed")


def main() -> None:
    """Prepares the scene and lets the event loop do the rest."""
    prepare()
    begin(steps(), STEP)


main()
