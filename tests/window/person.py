"""A person in Blender's window, who looks, moves the mouse and clicks. Blender handles events and draws at a yield."""

import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import addon_utils
import bpy
import numpy as np

from paradesc.files import png

sys.path.append(str(Path(__file__).resolve().parents[2] / "addon" / "manual" / "pictures"))
import screen  # noqa: E402

PATIENCE = 900.0  # seconds that one step may take
# How far apart the places are at which the mouse looks for a button: less than half a row at Blender's own scale.
ROW = 12
# Shares of the sidebar's width at which it looks.
COLUMNS = (0.3, 0.62, 0.85)
# Pixels from the sidebar's right end to the middle of its tabs.
TAB_FROM_RIGHT = 12
# And from its top to where the add-on's is at first, the last of four.
TAB_FROM_TOP = 172


def window() -> bpy.types.Window:
    """The only window."""
    return bpy.context.window_manager.windows[0]


def viewport() -> bpy.types.Area:
    """The largest 3D viewport."""
    areas = [area for area in window().screen.areas if area.type == "VIEW_3D"]
    return max(areas, key=lambda area: area.width * area.height)


def region(kind: str) -> bpy.types.Region:
    """A region of the viewport: WINDOW, UI (the sidebar), HUD (the panel of the last operator)."""
    return next(item for item in viewport().regions if item.type == kind)


def in_view(operator: Callable[..., object], *words: object, **settings: object) -> object:
    """Runs an operator as if over the viewport."""
    with bpy.context.temp_override(window=window(), area=viewport(), region=region("WINDOW")):
        return operator(*words, **settings)


def wait(condition: Callable[[], object], seconds: float = PATIENCE) -> Iterator[None]:
    """Gives the event loop its turns until the condition holds; fails after some minutes."""
    start = time.monotonic()
    while not condition():
        if time.monotonic() - start > seconds:
            raise AssertionError("it took too long")
        yield


def drawn(turns: int = 5) -> Iterator[None]:
    """Lets Blender draw everything."""
    for _ in range(turns):
        for area in window().screen.areas:
            area.tag_redraw()
        yield


def alone() -> Iterator[None]:
    """Lets the viewport fill the window, with its sidebar open beside it: over it, each move would draw the scene again."""
    bpy.context.preferences.system.use_region_overlap = False
    bpy.context.preferences.system.viewport_aa = "OFF"
    in_view(bpy.ops.screen.screen_full_area, use_hide_panels=False)
    yield
    viewport().spaces[0].show_region_ui = True
    yield from drawn(2)


def seen(kind: str = "") -> np.ndarray:
    """(height, width, 3) uint8 of the window, or of one region of the viewport, top row first."""
    pixels = screen.pixels_of_root()  # Blender's own screenshot is black in some versions
    if not kind:
        return pixels
    there = region(kind)
    top = len(pixels) - (there.y + there.height)
    return pixels[top : top + there.height, there.x : there.x + there.width]


def picture(path: Path, kind: str = "") -> Iterator[None]:
    """Writes what is seen into a file."""
    yield from drawn()
    png.write_png(path, np.ascontiguousarray(seen(kind)))


def move(x: float, y: float) -> Iterator[None]:
    """Moves the mouse there."""
    window().event_simulate("MOUSEMOVE", "NOTHING", x=int(x), y=int(y))
    yield


def click(x: float, y: float, key: str = "LEFTMOUSE", **held: bool) -> Iterator[None]:
    """Moves there, and presses and releases a button of the mouse or a key."""
    yield from move(x + 1, y)
    yield from move(x, y)  # which makes a button active
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(key, value, x=int(x), y=int(y), **held)
        yield


def drag(start: tuple[float, float], shift: tuple[float, float], turns: int = 8) -> Iterator[None]:
    """Presses the left button, moves by so many pixels, and releases it."""
    yield from move(*start)
    window().event_simulate("LEFTMOUSE", "PRESS", x=int(start[0]), y=int(start[1]))
    yield
    for turn in range(1, turns + 1):
        x, y = (int(begin + step * turn / turns) for begin, step in zip(start, shift))
        window().event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
        yield
    window().event_simulate("LEFTMOUSE", "RELEASE", x=x, y=y)
    yield


def preferences() -> Iterator[None]:
    """Shows the add-on's entry in Blender's preferences, opened, in place of the viewport."""
    area = viewport()
    area.type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Paradesc"
    (entry,) = (addon_utils.module_bl_info(module) for module in addon_utils.modules() if module.__name__ == "paradesc_blender")
    if not entry["show_expanded"]:
        bpy.ops.preferences.addon_expand(module="paradesc_blender")
    yield from drawn(10)


# ---- Buttons, found by what they do


def under_mouse(kind: str) -> str:
    """The Python command, or else the path of the property, of the button under the mouse; "" without one."""
    manager, found = bpy.context.window_manager, ""
    with bpy.context.temp_override(window=window(), area=viewport(), region=region(kind)):
        for operator, options in (("copy_python_command_button", {}), ("copy_data_path_button", {"full_path": True})):
            manager.clipboard = " "
            copy = getattr(bpy.ops.ui, operator)
            try:
                if copy.poll() and copy(**options) == {"FINISHED"}:
                    found = manager.clipboard.strip()
            except RuntimeError:
                found = ""
            if found:
                return found
    return found


def buttons(kind: str = "UI", wanted: str = "", columns: tuple[float, ...] = COLUMNS) -> Iterator[dict[str, tuple[int, int]]]:
    """Moves the mouse over a region from its top, and gives the place of each button by what it does.

    wanted: a part of a command or path, at which it stops; columns: the shares of the width at which it looks.
    """
    there, view, places = region(kind), region("WINDOW"), {}
    top = there.y + there.height
    # Blender still names the button that was pressed last, until the mouse meets another one.
    yield from move(view.x + view.width // 2, view.y + view.height // 2)
    last = under_mouse(kind)
    for y in range(top - 30, top - (panel_height() if kind == "UI" else there.height), -ROW):
        for share in columns:
            x = there.x + int(share * (there.width - 24))
            yield from move(x, y)
            words = under_mouse(kind)
            last = last if words == last else ""
            if words and words != last:
                places.setdefault(words, (x, y))
                if wanted and wanted in words:
                    return places
    return places


def find(wanted: str, kind: str = "UI") -> Iterator[tuple[int, int] | None]:
    """The place of the first button whose command or path has these words; None without one."""
    places = yield from buttons(kind, wanted)
    return next((place for words, place in places.items() if wanted in words), None)


def press(wanted: str, kind: str = "UI") -> Iterator[bool]:
    """Clicks on that button; False without one."""
    place = yield from find(wanted, kind)
    if place is not None:
        yield from click(*place)
        yield
    return place is not None


def open_tab() -> Iterator[bool]:
    """Clicks on the tabs of the sidebar from below until the add-on's panel is there; False without it."""
    there = region("UI")
    top = there.y + there.height
    for y in (top - TAB_FROM_TOP, *range(top - 20, top - 420, -25)):
        if getattr(there, "active_panel_category", "") == "Paradesc":
            return True
        yield from click(there.x + there.width - TAB_FROM_RIGHT, y)
        yield from drawn(1)
        if not hasattr(there, "active_panel_category") and (yield from is_ours()):
            return True
    return getattr(there, "active_panel_category", "") == "Paradesc"


def is_ours() -> Iterator[bool]:
    """Returns whether the sidebar shows the add-on's panel in older Blenders: one of its buttons is near its top."""
    there = region("UI")
    for y in range(there.y + there.height - 40, there.y + there.height - 150, -ROW):
        yield from move(there.x + there.width // 3, y)
        if "paradesc" in under_mouse("UI"):
            return True
    return False


def panel_height() -> int:
    """Pixels from the top of the sidebar to the end of the panels: half a row below the last row of light text."""
    text = (seen("UI")[:, 16 : region("UI").width - 40].min(axis=2) > 150).any(axis=1)
    return int(np.flatnonzero(text).max()) + 10 if text.any() else 0
