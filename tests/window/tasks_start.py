"""The first minute: preferences, the panel, one click, undo and redo, the radius in F9."""

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person
from scenes import as_found, baked, monkey, shading

if TYPE_CHECKING:
    from drive import Run

MOST_PIXELS = 825


def preferences(run: "Run") -> Iterator[None]:
    """The add-on's preferences, with its description and its buttons."""
    area = person.viewport()
    yield from person.preferences()
    file = yield from run.picture("preferences")
    run.saw("C8", "preferences: the description, documentation and bug buttons, what the memory limit says", None, file)
    area.type = "VIEW_3D"
    yield from person.drawn()


def first_click(run: "Run") -> Iterator[None]:
    """The panel as it is found, and one click."""
    monkey()
    yield from person.alone()
    there = yield from person.open_tab()
    run.saw("start", "N and the tab open the panel", there)
    before = person.panel_height()
    file = yield from run.picture("panel", "UI")
    found = yield from person.buttons()
    run.saw("panel", f"{before} px high, {len(found)} buttons: {', '.join(map(short, found))}", before <= MOST_PIXELS, file)
    place = next((place for words, place in found.items() if "paradesc.bake(" in words), None)
    yield from person.click(*place)
    yield from person.wait(lambda: baked("cavity"))
    yield from person.wait(lambda: shading().color_type in ("VERTEX", "ATTRIBUTE"), 30)
    file = yield from run.picture("first_click")
    run.saw("clicks", "a mask takes 1 click", True, file)
    run.saw("B4", f"the viewport's light is {shading().light}", shading().light == "FLAT", file)
    after = person.panel_height()
    file = yield from run.picture("panel_after", "UI")
    run.saw("panel", f"{after} px high after the bake", after <= MOST_PIXELS, file)
    run.saw("C11", "the legend's words", None, file)
    found = yield from person.buttons()
    run.saw("B16", f"levels under the button: {', '.join(short(words) for words in found if 'paradesc_looks' in words)}",
        all(any(f"paradesc_looks.{name}" in words for words in found) for name in ("contrast", "brightness", "invert")), file)  # fmt: skip
    run.saw("B17", "a button for wear on the first level", any("wear" in words and "edge_wear" not in words for words in found), file)
    last = bpy.context.window_manager.operators[-1]
    run.saw("B8", f'F9 and undo say "{last.name}"', "Descriptors" not in last.name, file)
    attributes = [name for name in bpy.context.object.data.attributes.keys() if not name.startswith(".")]
    run.saw("C9", f"attributes after one bake: {', '.join(attributes)}", "paradesc_mask" not in attributes)


def short(words: str) -> str:
    """A command or a path as people would say it."""
    return words.removeprefix("bpy.ops.paradesc.").split('"].')[-1]


def undone(run: "Run") -> Iterator[None]:
    """Ctrl-Z, and what the viewport shows then; redo."""
    person.in_view(bpy.ops.ed.undo)
    yield from person.drawn(10)
    gone = not baked("cavity")
    file = yield from run.picture("undone")
    run.saw("C1", f"after undo: mask gone: {gone}, the viewport shows {shading().color_type}", gone and shading().color_type not in ("VERTEX", "ATTRIBUTE"), file)
    person.in_view(bpy.ops.ed.redo)
    yield from person.drawn(10)
    file = yield from run.picture("redone")
    run.saw("C1", f"after redo: mask there: {baked('cavity')}, the viewport shows {shading().color_type}", baked("cavity"), file)


def last_operator(run: "Run") -> Iterator[None]:
    """F9, and another radius there by dragging."""
    x, y = person.region("WINDOW").width // 3, person.region("WINDOW").height // 2
    yield from person.click(x, y, "F9")
    yield from person.drawn(5)
    file = yield from run.picture("f9")
    run.saw("B16", "what F9 offers", None, file)
    yield from person.click(x, y, "ESC")
    yield from person.move(x + 500, y + 200)
    before = bpy.context.object.data["paradesc"]["field_report"]["radius"]
    last = bpy.context.window_manager.operators[-1]
    last.properties.radius = 2 * last.properties.radius
    person.in_view(bpy.ops.ed.undo_redo, "EXEC_DEFAULT", True)
    yield from person.drawn(8)
    after = bpy.context.object.data["paradesc"]["field_report"]["radius"]
    file = yield from run.picture("f9_other_radius")
    run.saw("F9", f"the radius from {before:.4f} to {after:.4f}", abs(after - 2 * before) < 1e-3 * before, file)


def radius_stays(run: "Run") -> Iterator[None]:
    """A radius that was typed stays when another mask is chosen, and so do samples."""
    group = bpy.context.scene.paradesc
    group.radius_percent, group.samples = 4.0, 200
    yield from person.drawn(2)
    yield from person.press("paradesc.mask(name='edge_wear'")
    run.saw("B7", f"typed 4 % and 200 samples, then Edge Wear: {group.radius_percent:g} %, {group.samples}", abs(group.radius_percent - 4) < 1e-4 and group.samples == 200)
    file = yield from run.picture("typed_radius", "UI")
    yield from person.press("paradesc.mask(name='openness'")
    yield from person.press("paradesc.bake(")
    yield from person.wait(lambda: baked("ambient_openness"))
    file = yield from run.picture("openness")
    run.saw("B11", "openness: the result line and the Show menu", None, file)


def steps(run: "Run") -> Iterator[None]:
    """All of it."""
    run.saw("versions", f"Blender {bpy.app.version_string}, Paradesc {sys.modules['paradesc'].__version__}")
    for point, task in (("C8", preferences), ("panel", first_click), ("F9", last_operator), ("C1", undone), ("B7", radius_stays)):
        yield from run.tried(point, task(run))
    as_found()
