"""Draws one picture of the manual inside Blender, for make.sh: make.py [--] KIND PLACE."""

import sys
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
import addon  # noqa: F401 (first, see there)


def turn(iterator: Iterator[None]) -> float | None:
    """One step; Blender ends after the last one or the first failure."""
    try:
        next(iterator)
    except StopIteration:
        bpy.ops.wm.quit_blender()
        return None
    except Exception:  # noqa: BLE001 (Blender has to end)
        traceback.print_exc()
        bpy.ops.wm.quit_blender()
        return None
    return 0.3


def main() -> None:
    """The picture that was asked for: in the window that is there, or by a render."""
    kind, place = sys.argv[-2:]
    if bpy.app.background:
        import beside
        import drawings
        import shots

        drawn = {**shots.KINDS, **drawings.KINDS, "beside": beside.draw_beside}
        drawn[kind](place)
        return
    import window

    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.smooth_view = 0
    iterator = window.STEPS[kind](place)
    bpy.app.timers.register(lambda: turn(iterator), first_interval=1.0)


main()
