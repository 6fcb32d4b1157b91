"""A million triangles: a bake, its progress, Esc; and seconds after strokes on a hundred thousand vertices."""

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import numpy as np
import person
from scenes import as_found, baked, idle, imported, monkey
from tasks_live import has_brush, stroke

from paradesc_blender.scene import arrays

if TYPE_CHECKING:
    from drive import Run

FIFTHS = 3  # of the bake that are looked at before Esc
STROKES = 5  # that are timed
PATIENCE = 30  # seconds that the colors after one may take


def million(run: "Run") -> Iterator[None]:
    """The beast twice subdivided by the modifier's defaults."""
    as_found()
    (made,) = imported("beast.obj")
    made.modifiers.new("Subdivision", "SUBSURF").levels = 2
    person.in_view(bpy.ops.object.modifier_apply, modifier="Subdivision")
    yield from person.drawn(2)
    place = yield from person.find("paradesc.bake(")
    yield from person.click(*place)
    yield from person.wait(lambda: not idle(), 30)
    yield from progress(run)
    start = time.monotonic()
    view = person.region("WINDOW")
    yield from person.click(view.x + view.width // 2, view.y + view.height // 2, "ESC")
    yield from person.wait(idle)
    file = yield from run.picture("cancelled")
    run.saw("C3", f"Esc: ended after {time.monotonic() - start:.1f} s, a mask is there: {baked('cavity')}", not baked("cavity"), file)
    longest, last, start, used = 0.0, time.monotonic(), time.monotonic(), time.process_time()
    yield from person.click(*place)
    yield from person.wait(lambda: not idle(), 30)
    while not idle():
        yield
        longest, last = max(longest, time.monotonic() - last), time.monotonic()
    seconds, used = time.monotonic() - start, time.process_time() - used
    file = yield from run.picture("million")
    made.data.calc_loop_triangles()
    text = f"{len(made.data.loop_triangles):,} triangles, {len(made.data.vertices):,} vertices in {seconds:.1f} s ({used:.0f} s of the processor)"
    run.saw("1 M", f"{text}, longest freeze {longest:.1f} s", baked("cavity"), file)


def progress(run: "Run") -> Iterator[None]:
    """Looks at the panel while a bake runs, at the begin and whenever another fifth is done, until three are."""
    from paradesc_blender.bake import modal

    said, wanted = [], 0.0
    while not idle() and wanted < FIFTHS / 5:
        words = modal.progress_text(modal.ModalJob.running)
        said += [words] if words not in said[-1:] else []
        if modal.ModalJob.running.fraction >= wanted:
            file = yield from run.picture("progress", "UI")
            run.saw("C3", f"progress: words, a bar, a button that cancels; at {words}", None, file)
            wanted = 0.2 * (int(5 * modal.ModalJob.running.fraction) + 1) if not idle() else 1.0
        yield
    run.saw("C3", f"what it said: {'; '.join(said[:: max(1, len(said) // 8)])}; it moved {len(said)} times", len(said) > 2)


def stroke_times(run: "Run") -> Iterator[None]:
    """Seconds from the end of a stroke to other colors, on a monkey of some 100,000 vertices."""
    made = monkey(4, applied=True)
    as_found()
    yield from person.press("paradesc_live.follows")
    yield from person.wait(lambda: baked("cavity"), 60)
    person.in_view(bpy.ops.object.mode_set, mode="SCULPT")
    yield from person.drawn(3)
    if not (yield from has_brush(run)):
        person.in_view(bpy.ops.object.mode_set, mode="OBJECT")
        return
    name = made.data.color_attributes.active_color.name
    walls, processor = [], []
    for _ in range(STROKES):
        before = arrays.attribute_values(made.data.attributes[name])
        stroke(made)
        start, used = time.monotonic(), time.process_time()
        while np.array_equal(arrays.attribute_values(made.data.attributes[name]), before) and time.monotonic() - start < PATIENCE:
            yield
        walls.append(time.monotonic() - start)
        processor.append(time.process_time() - used)
        yield from person.drawn(5)
    file = yield from run.picture("strokes")
    text = f"{len(made.data.vertices):,} vertices, radius {bpy.context.scene.paradesc.radius_percent:.2f} %: from the end of a stroke to new colors "
    text += f"{', '.join(f'{seconds:.2f}' for seconds in walls)} s of the clock, {', '.join(f'{seconds:.2f}' for seconds in processor)} s of the "
    run.saw("B3", f"{text}processor; it says {made.paradesc_live.sentence or 'nothing'}", max(walls) < PATIENCE, file)
    person.in_view(bpy.ops.object.mode_set, mode="OBJECT")
    made.paradesc_live.mode = "OFF"


def steps(run: "Run") -> Iterator[None]:
    """Both."""
    yield from person.alone()
    yield from person.open_tab()
    yield from run.tried("1 M", million(run))
    yield from run.tried("B3", stroke_times(run))
