"""Uses the add-on in Blender's window as a person would: cancel with Esc, bake, undo. Started by run_in_window.sh.

Blender draws with OpenGL on the main thread here, which is what the library's own context must not disturb.
"""

import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

words = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [words[0], str(Path(words[0]).parents[1] / "addon")]
import paradesc  # noqa: E402
from scene import add_sphere, attribute_values, fingerprint  # noqa: E402

STEP = 0.2
PATIENCE = 120.0
# Pixels from the sidebar's top to the middle of the Paradesc tab, for the screenshot.
TAB_BELOW_TOP = 168


def view_context() -> dict[str, object]:
    """The 3D viewport of the only window."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    return {"window": window, "area": area, "region": region}


def start_bake() -> None:
    """Presses the button."""
    with bpy.context.temp_override(**view_context()):
        state = bpy.ops.paradesc.bake("INVOKE_DEFAULT", True)
    assert state == {"RUNNING_MODAL"}, state


def computing() -> bool:
    """The worker's thread is at work."""
    return any(thread.name == "paradesc" for thread in threading.enumerate())


def say(text: str) -> None:
    """One line for run_in_window.sh."""
    print(f"window: {text}", flush=True)


def wait_for(condition) -> Iterator[None]:
    """Gives Blender's event loop its turns until the condition holds."""
    start = time.monotonic()
    while not condition():
        assert time.monotonic() - start < PATIENCE, "took too long"
        yield


def legend_is_drawn(area: bpy.types.Area) -> Iterator[None]:
    """The legend's bar is in the viewport with the colors of its map while it is switched on, and only then."""
    looks, seen = bpy.context.scene.paradesc_looks, {}
    for shown in (True, False):
        looks.show_legend = shown
        for _ in range(3):
            area.tag_redraw()
            yield
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "screen.png")
            bpy.ops.screen.screenshot(filepath=path)
            image = bpy.data.images.load(path)
            width, height = image.size
            pixels = np.array(image.pixels[:], np.float32).reshape(height, width, 4)[..., :3]
            bpy.data.images.remove(image)
        seen[shown] = pixels[area.y : area.y + 100, area.x : area.x + area.width]
    looks.show_legend = True
    changed = np.abs(seen[True] - seen[False]).max(axis=2) > 0.02
    colors = seen[True][changed]
    for color in ((0.09, 0.30, 0.71), (0.96, 0.96, 0.96), (0.63, 0.07, 0.11)):  # blue, white, red
        assert np.abs(colors - color).max(axis=1).min() < 0.06, f"no {color} in the legend"
    assert changed.sum() > 2000, "the legend is not there"
    say("drew the legend")


def steps(target, screenshot: str) -> Iterator[None]:
    """What the person does; every yield is a turn of the event loop."""
    mesh_name = target.data.name
    area = view_context()["area"]
    area.spaces[0].show_region_ui = True
    area.spaces[0].shading.type = "SOLID"
    area.spaces[0].shading.color_type = "VERTEX"
    settings = bpy.context.scene.paradesc
    settings.descriptors = {"mean_curvature", "shape_index"}
    settings.radius_percent, settings.samples, settings.buffer_size = 4.0, 256, 1024
    settings.backend = "software"
    yield
    before = fingerprint(target)
    settings.samples, settings.radius_percent = 4096, 15.0  # seconds of work
    start_bake()
    yield
    assert computing(), "ended before it could be cancelled"
    window = bpy.context.window_manager.windows[0]
    window.event_simulate("ESC", "PRESS", x=700, y=500)
    window.event_simulate("ESC", "RELEASE", x=700, y=500)
    yield from wait_for(lambda: not computing())
    for _ in range(5):
        yield
    assert fingerprint(target) == before, "cancelling changed the mesh"
    say("cancelled without a trace")
    settings.samples, settings.radius_percent = 256, 4.0
    start_bake()
    yield from wait_for(lambda: "mean_curvature" in bpy.data.meshes[mesh_name].attributes)
    values = attribute_values(bpy.data.meshes[mesh_name], "mean_curvature")
    np.testing.assert_allclose(values, 0.5, rtol=0.05)
    say("baked with the right values")
    yield from legend_is_drawn(area)
    if screenshot:
        sidebar = next(region for region in area.regions if region.type == "UI")
        place = {"x": sidebar.x + sidebar.width - 12, "y": sidebar.y + sidebar.height - TAB_BELOW_TOP}
        for value in ("PRESS", "RELEASE"):
            window.event_simulate("LEFTMOUSE", value, **place)
            yield
        with bpy.context.temp_override(**view_context()):
            bpy.ops.view3d.view_selected()
        for _ in range(5):
            area.tag_redraw()
            yield
        bpy.ops.screen.screenshot(filepath=screenshot)
        say(f"wrote {screenshot}")
    with bpy.context.temp_override(**view_context()):
        bpy.ops.ed.undo()
    yield
    assert "mean_curvature" not in bpy.data.meshes[mesh_name].attributes, "undo left the attribute"
    say("undone")
    say("all steps passed")


def run_steps(iterator: Iterator[None]) -> float | None:
    """One turn; Blender ends after the last one or the first failure."""
    try:
        next(iterator)
    except StopIteration:
        bpy.ops.wm.quit_blender()
        return None
    except Exception:  # noqa: BLE001 (whatever it is, it has to be seen and Blender has to end)
        traceback.print_exc(file=sys.stdout)
        sys.stdout.flush()
        bpy.ops.wm.quit_blender()
        return None
    return STEP


def main() -> None:
    """Prepares the scene and lets the event loop do the rest."""
    bpy.context.preferences.view.show_splash = False
    paradesc.register()
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    made = add_sphere(steps=24)
    bpy.ops.ed.undo_push(message="start")
    iterator = steps(made, words[1] if len(words) > 1 else "")
    bpy.app.timers.register(lambda: run_steps(iterator), first_interval=1.0)


main()
