"""Draws one picture of the manual inside Blender, for make.sh: make.py -- KIND PLACE, kinds as in KINDS and STEPS."""

import sys
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
import addon  # noqa: F401 (first, see there)
import beside
import drawings
import onto
import pages
import renders
import worn

import window

KINDS = {
    "hero": renders.render_hero,
    "cavity": renders.render_cavity,
    "descriptors": drawings.draw_descriptors,
    "radii": drawings.draw_radii,
    "creases": drawings.draw_creases,
    "frames": drawings.draw_frames,
    "maps": drawings.draw_maps,
    "wear": worn.render_wear,
    "beside": beside.render_beside,
    "onto": onto.render_onto,
    "presets": pages.draw_presets,
    "textures": pages.draw_textures,
    "export": pages.draw_export,
    "trouble": pages.draw_trouble,
}
STEPS = {"legend": window.legend_steps, "panel": window.panel_steps, "sculpting": window.sculpting_steps}


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
    """The picture that was asked for."""
    kind, place = sys.argv[sys.argv.index("--") + 1 :]
    if kind in KINDS:
        KINDS[kind](place)
        return
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.smooth_view = 0
    iterator = STEPS[kind](place)
    bpy.app.timers.register(lambda: turn(iterator), first_interval=1.0)


main()
