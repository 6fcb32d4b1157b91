"""A million triangles: a bake, its progress, Esc, and the button that cancels."""

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person
from scenes import as_found, baked, idle, imported

if TYPE_CHECKING:
    from drive import Run


def million(run: "Run") -> Iterator[None]:
    """The beast twice subdivided."""
    as_found()
    (made,) = imported("beast.obj")
    made.modifiers.new("Subdivision", "SUBSURF").levels = 2
    made.modifiers["Subdivision"].subdivision_type = "SIMPLE"
    person.in_view(bpy.ops.object.modifier_apply, modifier="Subdivision")
    yield from person.drawn(2)
    place = yield from person.find("paradesc.bake(")
    yield from person.click(*place)
    yield from person.wait(lambda: not idle(), 30)
    yield from person.drawn(6)
    file = yield from run.picture("progress", "UI")
    run.saw("C3", "progress: words, a bar, a button that cancels", None, file)
    start = time.monotonic()
    view = person.region("WINDOW")
    yield from person.click(view.x + view.width // 2, view.y + view.height // 2, "ESC")
    yield from person.wait(idle)
    file = yield from run.picture("cancelled")
    run.saw("C3", f"Esc: ended after {time.monotonic() - start:.1f} s, a mask is there: {baked('cavity')}", not baked("cavity"), file)
    longest, last, start = 0.0, time.monotonic(), time.monotonic()
    yield from person.click(*place)
    yield from person.wait(lambda: not idle(), 30)
    while not idle():
        yield
        longest, last = max(longest, time.monotonic() - last), time.monotonic()
    file = yield from run.picture("million")
    run.saw("1 M", f"{len(made.data.polygons) * 2:,} triangles in {time.monotonic() - start:.0f} s, longest freeze {longest:.1f} s", baked("cavity"), file)


def steps(run: "Run") -> Iterator[None]:
    """All of it."""
    yield from person.alone()
    yield from person.open_tab()
    yield from run.tried("1 M", million(run))
