"""Uses the add-on in Blender's window as a person would: cancel with Esc, bake, undo. run_in_window.sh starts it.

Blender draws with OpenGL on the main thread here, which the library's own context must not disturb.
"""

import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

words = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [words[0], str(Path(words[0]).parents[1] / "addon")]
from paradesc.core import job  # noqa: E402
from paradesc.files import png  # noqa: E402
from paradesc_blender.bake import operators  # noqa: E402
from paradesc_blender.scene import mesh_io, record, sculpt_masks  # noqa: E402
from scene import add_sphere, attribute_values, fingerprint  # noqa: E402
from window import (  # noqa: E402
    baking,
    begin,
    chosen_brush,
    prepare,
    run_in_view,
    say,
    screen_pixels,
    start_bake,
    view_context,
    wait_for,
)

STEP = 0.2
# Pixels from the sidebar's top to the middle of the Paradesc tab, for the screenshot.
TAB_BELOW_TOP = 168


def press(key: str, **place: int) -> Iterator[None]:
    """Presses and releases a key or button of the mouse."""
    window = bpy.context.window_manager.windows[0]
    for value in ("PRESS", "RELEASE"):
        window.event_simulate(key, value, **{"x": 700, "y": 500, **place})
        yield


def computing() -> bool:
    """Returns whether a worker's thread is at work."""
    return any(thread.name == "paradesc" for thread in threading.enumerate())


def baked(name: str) -> bool:
    """Returns whether the mesh of that name has values."""
    return "mean_curvature" in bpy.data.meshes[name].attributes


def cancel_and_bake(target) -> Iterator[None]:
    """Checks that Esc leaves everything as it was, and that without it the values are right."""
    mesh_name = target.data.name
    settings = bpy.context.scene.paradesc
    before = fingerprint(target)
    settings.samples, settings.radius_percent = 4096, 15.0  # seconds of work
    start_bake()
    yield
    assert computing(), "ended before it could be cancelled"
    yield from press("ESC")
    yield from wait_for(lambda: not baking())
    assert not computing()
    assert fingerprint(target) == before, "cancelling changed the mesh"
    say("cancelled without a trace")
    settings.samples, settings.radius_percent = 256, 4.0
    start_bake()
    yield from wait_for(lambda: baked(mesh_name))
    values = attribute_values(bpy.data.meshes[mesh_name], "mean_curvature")
    np.testing.assert_allclose(values, 0.5, rtol=0.05)
    say("baked with the right values")


def redone(name: str) -> Iterator[None]:
    """Changes the radius in the panel that Blender shows after a bake (F9): the values are those of the new one."""
    before = record.read(bpy.data.meshes[name])["field_report"]["radius"]
    values = attribute_values(bpy.data.meshes[name], "mean_curvature")
    last = bpy.context.window_manager.operators[-1]
    assert last.bl_idname == "PARADESC_OT_bake", last.bl_idname
    last.properties.radius = 2 * last.properties.radius
    run_in_view(bpy.ops.ed.undo_redo, "EXEC_DEFAULT", True)
    yield
    after = record.read(bpy.data.meshes[name])["field_report"]["radius"]
    np.testing.assert_allclose(after, 2 * before, rtol=1e-5)
    assert not np.array_equal(attribute_values(bpy.data.meshes[name], "mean_curvature"), values), "the same values"
    np.testing.assert_allclose(bpy.context.scene.paradesc.radius_percent, 8.0, rtol=1e-5)
    say("baked again with another radius")


def take_picture(screenshot: str) -> Iterator[None]:
    """Takes a picture of the panel and of the colors in the viewport."""
    area = view_context()["area"]
    sidebar = next(region for region in area.regions if region.type == "UI")
    yield from press("LEFTMOUSE", x=sidebar.x + sidebar.width - 12, y=sidebar.y + sidebar.height - TAB_BELOW_TOP)
    run_in_view(bpy.ops.view3d.view_selected)
    for _ in range(5):
        area.tag_redraw()
        yield
    png.write_png(Path(screenshot), np.round(255 * screen_pixels()[::-1]).astype(np.uint8))
    say(f"wrote {screenshot}")


def undo(*names: str) -> Iterator[None]:
    """Checks that one step of undo removes the values from all of these meshes."""
    run_in_view(bpy.ops.ed.undo)
    yield
    assert not any(map(baked, names)), "undo left an attribute"


def several(names: tuple[str, str]) -> Iterator[None]:
    """Bakes two meshes: with a preset, with Esc while the second one is computed, then both, and one step of undo."""
    run_in_view(bpy.ops.paradesc.preset, "INVOKE_DEFAULT", True, name="curvature")
    settings = bpy.context.scene.paradesc
    assert settings.descriptors == {"mean_curvature", "gaussian_curvature"}, "the preset sets what to compute"
    settings.samples, settings.buffer_size = 512, 512
    settings.radius_percent = 15.0
    before = [fingerprint(bpy.data.objects[name]) for name in names]
    run, begun = job.run, []

    def held(arrays, asked, progress):
        begun.append(arrays)
        while len(begun) > 1 and progress("evaluate", 0.5):  # the second one takes until it is cancelled
            time.sleep(0.01)
        return run(arrays, asked, progress)

    job.run = held
    start_bake()
    yield from wait_for(lambda: operators.PARADESC_OT_bake.running.current == 1)
    yield from press("ESC")
    yield from wait_for(lambda: not baking())
    job.run = run
    assert [fingerprint(bpy.data.objects[name]) for name in names] == before, "cancelling left the first mesh's values"
    say("cancelled the second of two meshes without a trace of the first")
    settings.samples, settings.radius_percent = 64, 4.0
    start_bake()
    yield from wait_for(lambda: not baking())
    assert all(map(baked, names)), "not both were baked"
    yield from undo(*names)
    say("baked two meshes and undone both in one step")


def in_edit_mode(name: str) -> Iterator[None]:
    """Bakes in edit mode, which stays, also after undo."""
    run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="EDIT")
    yield
    start_bake()
    yield from wait_for(lambda: not baking())
    assert bpy.data.objects[name].mode == "EDIT", "left edit mode"
    assert baked(name), "not baked in edit mode"
    yield from undo(name)
    assert bpy.data.objects[name].mode == "EDIT", "undo left edit mode"
    run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="OBJECT")
    assert not baked(name), "leaving edit mode brought the values back"
    say("baked and undone in edit mode")


def sculpted(name: str) -> Iterator[None]:
    """Checks that a bake sees a stroke without leaving sculpt mode, and that undo removes values, not the stroke."""
    run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="SCULPT")
    yield
    if not chosen_brush():
        run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="OBJECT")
        say("left strokes out: this Blender was packed without its brushes")
        return
    yield
    before = mesh_io.read_positions(bpy.data.meshes[name])
    region = view_context()["region"]
    middle = (region.width / 2, region.height / 2)
    dot = {"name": "", "location": (0, 0, 2), "mouse": middle, "mouse_event": middle, "pressure": 1.0, "size": 80.0}
    dot.update(pen_flip=False, x_tilt=0.0, y_tilt=0.0, time=0.0)
    stroke = [{**dot, "is_start": start, "time": number * 0.1} for number, start in enumerate((True, False, False))]
    run_in_view(bpy.ops.sculpt.brush_stroke, "EXEC_DEFAULT", True, stroke=stroke)
    yield
    moved = np.abs(mesh_io.read_positions(bpy.data.meshes[name]) - before).max(axis=1)
    assert moved.max() > 1e-3, "the brush did nothing"
    start_bake()
    yield from wait_for(lambda: not baking())
    assert bpy.data.objects[name].mode == "SCULPT", "left sculpt mode"
    values = attribute_values(bpy.data.meshes[name], "mean_curvature")
    np.testing.assert_allclose(np.median(values), 0.5, rtol=0.05)
    assert np.abs(values - 0.5).max() > 0.1, "the sculpted place was not seen"
    yield from undo(name)
    assert bpy.data.objects[name].mode == "SCULPT", "undo left sculpt mode"
    after = np.abs(mesh_io.read_positions(bpy.data.meshes[name]) - before).max(axis=1)
    assert np.array_equal(after, moved), "undo took the stroke as well"
    say("baked what was sculpted, and undone")


def legend_is_drawn(area: bpy.types.Area) -> Iterator[None]:
    """Checks that the legend is in the viewport with the colors of its map while it is switched on, and only then."""
    looks, seen = bpy.context.scene.paradesc_looks, {}
    for shown in (True, False):
        looks.show_legend = shown
        for _ in range(3):
            area.tag_redraw()
            yield
        seen[shown] = screen_pixels()[area.y : area.y + 100, area.x : area.x + area.width]
    looks.show_legend = True
    changed = np.abs(seen[True] - seen[False]).max(axis=2) > 0.02
    colors = seen[True][changed]
    for color in ((0.09, 0.30, 0.71), (0.96, 0.96, 0.96), (0.63, 0.07, 0.11)):  # blue, white, red
        assert np.abs(colors - color).max(axis=1).min() < 0.06, f"no {color} in the legend"
    assert changed.sum() > 2000, "the legend is not there"
    say("drew the legend")


def steps(target, screenshot: str) -> Iterator[None]:
    """Does what the person does; every yield is a turn of the event loop."""
    first, second = target.data.name, "second"
    area = view_context()["area"]
    area.spaces[0].show_region_ui = True
    area.spaces[0].shading.type = "SOLID"
    area.spaces[0].shading.color_type = "VERTEX"
    settings = bpy.context.scene.paradesc
    settings.descriptors = {"mean_curvature", "shape_index"}
    settings.buffer_size = 1024
    settings.backend = "software"
    yield
    yield from cancel_and_bake(target)
    yield from redone(first)
    yield from legend_is_drawn(area)
    if screenshot:
        yield from take_picture(screenshot)
    yield from undo(first)
    say("undone")
    add_sphere(second, steps=48).location.x = 5.0
    bpy.ops.ed.undo_push(message="two spheres")
    yield
    yield from several((first, second))
    bpy.data.objects[second].select_set(False)
    bpy.context.view_layer.objects.active = bpy.data.objects[first]
    bpy.ops.ed.undo_push(message="one sphere")
    yield
    yield from in_edit_mode(first)
    yield from sculpted(first)
    yield from first_mask(first)
    yield from masked(first)
    say("all steps passed")


def first_mask(name: str) -> Iterator[None]:
    """Masks a mesh without a mask after a bake in sculpt mode; Blender 3 would crash where redo comes to such a mask."""
    run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="SCULPT")
    yield
    start_bake()
    yield from wait_for(lambda: not baking())
    yield
    assert sculpt_masks.values(bpy.data.objects[name].data) is None
    run_in_view(bpy.ops.paradesc.mask_from_shape, "EXEC_DEFAULT", True, mask="openness")
    yield
    expected = sculpt_masks.values(bpy.data.objects[name].data)
    for operator, is_there in ((bpy.ops.ed.undo, False), (bpy.ops.ed.redo, True)):
        run_in_view(operator)
        yield
        assert sculpt_masks.is_painted(bpy.data.objects[name].data) == is_there
    np.testing.assert_allclose(sculpt_masks.values(bpy.data.objects[name].data), expected, atol=1e-6)
    run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="OBJECT")
    yield
    say("a first mask undone and redone")


def masked(name: str) -> Iterator[None]:
    """Masks in sculpt mode: one step of undo brings back the mask before, and what is masked stays when brushed."""
    run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="SCULPT")
    yield
    settings, mesh = bpy.context.scene.paradesc, bpy.data.objects[name].data
    settings.samples, settings.radius_percent = 64, 4.0
    run_in_view(bpy.ops.paint.mask_flood_fill, "EXEC_DEFAULT", True, mode="VALUE", value=0.25)
    yield
    for invert in (True, False):
        run_in_view(bpy.ops.paradesc.mask_from_shape, "INVOKE_DEFAULT", True, mask="openness", invert=invert)
        yield from wait_for(lambda: not baking())
        yield
    # The ball is about as open everywhere, which is nearly the largest value of its range.
    expected = sculpt_masks.values(mesh)
    assert 0.9 < np.median(expected) <= 1, np.median(expected)
    for wanted in (1 - expected, np.full(len(expected), 0.25)):
        run_in_view(bpy.ops.ed.undo)
        yield
        found = sculpt_masks.values(bpy.data.objects[name].data)
        np.testing.assert_allclose(found, wanted, atol=1e-6, err_msg="undo gave another mask")
    run_in_view(bpy.ops.ed.redo)
    yield
    np.testing.assert_allclose(sculpt_masks.values(bpy.data.objects[name].data), 1 - expected, atol=1e-6)
    assert bpy.data.objects[name].mode == "SCULPT", "undo left sculpt mode"
    say("masked in sculpt mode, undone and redone")


def main() -> None:
    """Prepares the scene and lets the event loop do the rest."""
    prepare()
    made = add_sphere(steps=24)
    begin(steps(made, words[1] if len(words) > 1 else ""), STEP)


main()
