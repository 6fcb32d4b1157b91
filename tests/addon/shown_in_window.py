"""The colors of viewports in Blender's window: after bakes, with Live, after undo, and after strokes of sculpt mode.

run_in_window.sh starts it. Strokes are those of the mouse, which Blender simulates.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

words = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [words[0], str(Path(words[0]).parents[1] / "addon")]
from paradesc_blender.animation import live, pausing, sessions  # noqa: E402
from paradesc_blender.scene import mesh_io, viewports  # noqa: E402
from scene import add_sphere, attribute_values  # noqa: E402
from window import (  # noqa: E402
    baking,
    begin,
    chosen_brush,
    prepare,
    run_in_view,
    say,
    start_bake,
    view_context,
    wait_for,
)

NAME, STEP = "convexity", 0.02


def shown() -> tuple[object, ...]:
    """All that a bake changes of the viewport, and more of its light."""
    shading = view_context()["area"].spaces[0].shading
    return (*(getattr(shading, name) for name in viewports.PLAIN), shading.studio_light)


def is_plain() -> bool:
    """Returns whether the viewport shows attributes in flat light."""
    return shown()[: len(viewports.PLAIN)] == tuple(viewports.PLAIN.values())


def step_back(operator) -> Iterator[None]:
    """Presses Ctrl-Z or its opposite."""
    run_in_view(operator)
    for _ in range(3):
        yield


def bakes_are_shown(name: str) -> Iterator[None]:
    """Bakes, undoes and redoes; the viewport follows, and the eye brings back what was there."""
    shading = view_context()["area"].spaces[0].shading
    shading.light, shading.show_cavity = "MATCAP", True
    shading.studio_light = "check_normal+y.exr"
    before = shown()
    start_bake()
    yield from wait_for(lambda: not baking())
    assert is_plain(), shown()
    yield from step_back(bpy.ops.ed.undo)
    assert shown() == before, f"undo left {shown()}"
    yield from step_back(bpy.ops.ed.redo)
    assert is_plain(), f"redo left {shown()}"
    shading.light = "STUDIO"
    start_bake()
    yield from wait_for(lambda: not baking())
    assert shading.light == "STUDIO", "another bake took the light that was chosen"
    bpy.context.window_manager.operators[-1].properties.radius = 6.0
    run_in_view(bpy.ops.ed.undo_redo)
    yield
    assert shown()[:2] == (viewports.ATTRIBUTES, "STUDIO"), "another radius took the light that was chosen"
    shading.light = "FLAT"
    run_in_view(bpy.ops.paradesc.restore_shading)
    assert shown() == before, f"the eye left {shown()}"
    say("bakes are shown in flat light, and undo and the eye bring back what was there")
    bpy.data.objects[name].paradesc_live.follows = True
    bpy.ops.ed.undo_push(message="Live")
    yield
    assert is_plain(), "Live shows nothing"
    bpy.data.objects[name].paradesc_live.follows = False
    run_in_view(bpy.ops.paradesc.restore_shading)
    assert shown() == before
    say("live values are shown as those of a bake")


def dragged(name: str, computed: list[int]) -> Iterator[None]:
    """Draws a stroke with the mouse; nothing is computed before the button is released."""
    window, region = bpy.context.window_manager.windows[0], view_context()["region"]
    x, y = region.x + region.width // 2, region.y + region.height // 2
    before = mesh_io.read_positions(bpy.data.objects[name].data)
    window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
    yield
    window.event_simulate("LEFTMOUSE", "PRESS", x=x, y=y)
    for _ in range(4):
        x += 14
        window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
        yield
    for _ in range(int(1 / STEP)):  # holds still, longer than values wait after an edit
        yield
    assert np.abs(mesh_io.read_positions(bpy.data.objects[name].data) - before).max() > 1e-3, "the brush did nothing"
    assert pausing.is_busy()
    assert not computed, "computed in the middle of a stroke"
    window.event_simulate("LEFTMOUSE", "RELEASE", x=x, y=y)
    yield


def strokes_are_followed(name: str) -> Iterator[None]:
    """Sculpts with Live on: values follow each stroke, in the mode and in its light, and undo takes strokes alone."""
    target = bpy.data.objects[name]
    run_in_view(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="SCULPT")
    yield
    if not chosen_brush():
        say("left strokes out: this Blender was packed without its brushes")
        return
    light = view_context()["area"].spaces[0].shading.light
    target.paradesc_live.follows = True
    bpy.ops.ed.undo_push(message="Live")
    assert (target.mode, target.paradesc_live.sentence) == ("SCULPT", "")
    assert shown()[:2] == (viewports.ATTRIBUTES, light), "who sculpts needs the light"
    run_in_view(bpy.ops.view3d.view_selected)
    yield
    computed, compute = [], live.Session.compute
    live.Session.compute = lambda *more: (computed.append(1), compute(*more))[1]
    still, flat = (mesh_io.read_positions(target.data), attribute_values(target.data, NAME))
    yield from dragged(name, computed)
    yield from wait_for(lambda: not np.array_equal(attribute_values(bpy.data.objects[name].data, NAME), flat))
    for _ in range(10):
        yield
    assert len(computed) == 1, f"computed {len(computed)} times for a stroke"
    stroked = attribute_values(bpy.data.objects[name].data, NAME)
    assert np.abs(stroked - flat).max() > 0.02, "the stroke is not seen"
    yield from step_back(bpy.ops.ed.undo)
    yield from wait_for(lambda: not np.array_equal(attribute_values(bpy.data.objects[name].data, NAME), stroked))
    target = bpy.data.objects[name]
    assert np.array_equal(mesh_io.read_positions(target.data), still), "undo left some of the stroke"
    np.testing.assert_allclose(attribute_values(target.data, NAME), flat, atol=1e-5)
    assert (target.mode, target.paradesc_live.mode) == ("SCULPT", "LIVE"), "undo took more than the stroke"
    live.Session.compute = compute
    assert not sessions.session_at(target).busy
    say("values followed a stroke and its undo")


def wear_is_shown(name: str) -> Iterator[None]:
    """Adds wear after a bake, undoes it and redoes it: the viewport shows materials, the bake, and materials again."""
    shading = view_context()["area"].spaces[0].shading
    start_bake()
    yield from wait_for(lambda: not baking())
    run_in_view(bpy.ops.paradesc.add_wear, "EXEC_DEFAULT", True)
    yield
    assert shading.type == "MATERIAL"
    for operator, kind in ((bpy.ops.ed.undo, "SOLID"), (bpy.ops.ed.redo, "MATERIAL"), (bpy.ops.ed.undo, "SOLID")):
        yield from step_back(operator)
        assert shading.type == kind, shading.type
    assert is_plain(), shown()
    assert bpy.data.objects[name].active_material is None
    run_in_view(bpy.ops.paradesc.restore_shading)
    say("wear is shown, undone and redone")


def masks_are_seen(name: str) -> Iterator[None]:
    """Writes sculpt mode's mask, whose shade is not seen on the black of a bake."""
    bpy.data.objects[name].paradesc_live.follows = False
    run_in_view(bpy.ops.paradesc.view_colors)
    assert shown()[0] == viewports.ATTRIBUTES
    run_in_view(bpy.ops.paradesc.mask_from_shape, "INVOKE_DEFAULT", True, mask="openness")
    yield from wait_for(lambda: not baking())
    yield
    assert shown()[0] != viewports.ATTRIBUTES, "the mask is hidden by the colors of a bake"
    say("a sculpt mask is seen")


def steps(name: str) -> Iterator[None]:
    """Does what the person does; every yield is a turn of the event loop."""
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.backend, settings.radius_percent = {NAME}, "cpu", 4.0
    bpy.ops.ed.undo_push(message="settings")
    yield
    yield from bakes_are_shown(name)
    yield from wear_is_shown(name)
    yield from strokes_are_followed(name)
    yield from masks_are_seen(name)
    say("all steps passed")


def main() -> None:
    """Prepares the scene and lets the event loop do the rest."""
    prepare()
    begin(steps(add_sphere(steps=48).name), STEP)


main()
