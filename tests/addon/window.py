"""Shared by scripts in Blender's window: words for run_in_window.sh, and steps that the event loop takes in turn."""

import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

import paradesc_blender
from paradesc_blender.bake import operators
from paradesc_blender.scene import writing
from scene import measure_curvature

sys.path.append(str(Path(paradesc_blender.__file__).parents[1] / "manual" / "pictures"))
import screen

PATIENCE = 120.0  # seconds that one step may take


def say(text: str) -> None:
    """Prints one line for run_in_window.sh."""
    sys.stdout.write(f"window: {text}\n")
    sys.stdout.flush()


def wait_for(condition) -> Iterator[None]:
    """Gives Blender's event loop its turns until the condition holds."""
    start = time.monotonic()
    while not condition():
        assert time.monotonic() - start < PATIENCE, "took too long"
        yield


def view_context() -> dict[str, object]:
    """The 3D viewport of the only window."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    return {"window": window, "area": area, "region": region}


def run_in_view(operator, *words: object, **settings: object) -> None:
    """Runs an operator as if over the viewport; the last argument of an undoable one is True."""
    with bpy.context.temp_override(**view_context()):
        operator(*words, **settings)


def chosen_brush() -> bool:
    """Returns whether sculpt mode has its brush: since 4.3 brushes are assets, of which none is chosen at first."""
    if bpy.app.version < (4, 3, 0):
        return True
    brush = "brushes/essentials_brushes-mesh_sculpt.blend/Brush/Draw"
    try:
        run_in_view(bpy.ops.brush.asset_activate, asset_library_type="ESSENTIALS", relative_asset_identifier=brush)
    except RuntimeError:
        return False
    return True


def prepare() -> None:
    """Makes a scene without objects and without a splash screen, and enables the add-on."""
    bpy.context.preferences.view.show_splash = False
    paradesc_blender.register()
    measure_curvature()
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)


def start_bake() -> None:
    """Presses the button."""
    with bpy.context.temp_override(**view_context()):
        state = bpy.ops.paradesc.bake("INVOKE_DEFAULT", True)
    assert state == {"RUNNING_MODAL"}, state


def baking() -> bool:
    """Returns whether the operator has not ended yet."""
    return operators.PARADESC_OT_bake.running is not None


def screen_pixels() -> np.ndarray:
    """(height, width, 3) float32 pixels of the window, from the lowest row on."""
    return screen.pixels()[::-1].astype(np.float32) / 255


def begin(steps: Iterator[None], seconds: float) -> None:
    """Takes a step every so many seconds once the window is there, from a scene to which undo can come back.

    Blender ends after the last step or the first failure.
    """
    bpy.ops.ed.undo_push(message="start")

    @writing.allowed
    def turn() -> float | None:
        try:
            next(steps)
        except StopIteration:
            bpy.ops.wm.quit_blender()
            return None
        except Exception:  # noqa: BLE001 (whatever it is, it has to be seen and Blender has to end)
            traceback.print_exc(file=sys.stdout)
            sys.stdout.flush()
            bpy.ops.wm.quit_blender()
            return None
        return seconds

    bpy.app.timers.register(turn, first_interval=1.0)
