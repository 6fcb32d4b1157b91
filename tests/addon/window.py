"""What scripts in Blender's window share: words for run_in_window.sh, and steps that the event loop takes in turn."""

import sys
import time
import traceback
from collections.abc import Iterator

import bpy

PATIENCE = 120.0  # seconds that one step may take


def say(text: str) -> None:
    """One line for run_in_window.sh."""
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


def begin(steps: Iterator[None], seconds: float) -> None:
    """Takes a step every so many seconds once the window is there; Blender ends after the last or the first failure."""

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
