"""A Blender without NumPy: what ticking the add-on shows, and what the preferences and the sidebar say."""

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person

if TYPE_CHECKING:
    from drive import Run


def without_numpy(run: "Run") -> Iterator[None]:
    """Ticks the add-on where numpy cannot be imported; nothing else can be tried in this Blender afterwards."""
    bpy.ops.preferences.addon_disable(module="paradesc_blender")
    for name in [name for name in sys.modules if name.partition(".")[0] in ("paradesc", "paradesc_blender")]:
        del sys.modules[name]
    kept, sys.modules["numpy"] = sys.modules["numpy"], None
    try:
        bpy.ops.preferences.addon_enable(module="paradesc_blender")
    finally:
        sys.modules["numpy"] = kept
    for _ in range(20):  # it pops up once Blender is at rest
        yield
    file = yield from run.picture("without_numpy")
    run.saw("A5", "the add-on is ticked in a Blender without NumPy: what pops up", hasattr(bpy.types, "PARADESC_PT_failure"), file)
    yield from person.move(300, 300)
    area = person.viewport()
    yield from person.preferences()
    file = yield from run.picture("without_numpy_preferences")
    run.saw("A5", "the preferences without NumPy", None, file)
    area.type = "VIEW_3D"
    yield from person.alone()
    there = yield from person.open_tab()
    file = yield from run.picture("without_numpy_sidebar")
    run.saw("A5", f"the sidebar without NumPy; in its tab: {there}", None, file)


def steps(run: "Run") -> Iterator[None]:
    """All of it."""
    yield from run.tried("A5", without_numpy(run))
