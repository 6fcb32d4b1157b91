"""Makes live values wait while frames are evaluated for a bake, and during a stroke.

Live values of frames that are baked are not seen, and would be computed twice.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

_holds: list[object] = []
_pressed: list[str] = []
# Modal operators that change a mesh until their mouse button is released.
DRAGGING = ("SCULPT_OT_", "PAINT_OT_", "TRANSFORM_OT_")
BUTTONS = {"LEFTMOUSE", "RIGHTMOUSE"}


def is_held() -> bool:
    """Returns whether live values wait."""
    return bool(_holds)


@contextmanager
def held() -> Iterator[None]:
    """Makes live values wait inside the with statement."""
    mine = object()
    _holds.append(mine)
    try:
        yield
    finally:
        _holds.remove(mine)


# ---- Strokes


def is_busy() -> bool:
    """Returns whether a stroke or a drag is under way in any window."""
    windows = bpy.context.window_manager.windows
    if "modal_operators" in bpy.types.Window.bl_rna.properties:
        return any(item.bl_idname.startswith(DRAGGING) for window in windows for item in window.modal_operators)
    _pressed.clear()
    for window in windows:
        with bpy.context.temp_override(window=window):
            bpy.ops.paradesc.look_at_buttons("INVOKE_DEFAULT")
    return bool(_pressed)


class PARADESC_OT_look_at_buttons(bpy.types.Operator):
    """Note whether a mouse button is held, which Blender before 4.2 reports to operators only"""

    bl_idname = "paradesc.look_at_buttons"
    bl_label = "Look at Buttons"
    bl_options = {"INTERNAL"}

    def invoke(self, _context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Notes whether the window's last event is a press of a button."""
        if event.type in BUTTONS and event.value == "PRESS":
            _pressed.append(event.type)
        return {"FINISHED"}


classes = (PARADESC_OT_look_at_buttons,)
