"""Draws all panels, open, at several scales of the interface and in its languages, as pictures for people to look at.

bash tests/addon/run_in_window.sh build/panels panel_in_window.py 640 9900
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

words = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [words[0], str(Path(words[0]).parents[1] / "addon")]
from paradesc.files import png  # noqa: E402
from scene import add_sphere  # noqa: E402
from window import baking, begin, prepare, say, screen, screen_pixels, start_bake, view_context, wait_for  # noqa: E402

SCALES = (1.0, 1.5, 2.0)
LANGUAGES = ("en_US", "de_DE", "ja_JP", "zh_CN", "zh_HANS", "fr_FR")  # we have no French; one name of Chinese is older
# Pixels from the sidebar's top to the middle of the add-on's tab, which is the last.
TAB_BELOW_TOP = 175
# Higher pictures go on in another column.
MOST_PIXELS = 1300


def sidebar() -> bpy.types.Region:
    """The region with the panels."""
    return next(region for region in view_context()["area"].regions if region.type == "UI")


def click(x: int, y: int) -> Iterator[None]:
    """Presses and releases the left button of the mouse."""
    window = view_context()["window"]
    for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
        window.event_simulate(kind, value, x=int(x), y=int(y))
        yield


def take(path: Path) -> Iterator[None]:
    """Takes the picture of the sidebar."""
    area = view_context()["area"]
    for _ in range(4):
        area.tag_redraw()
        yield
    region = sidebar()
    pixels = screen_pixels()[region.y : region.y + region.height, region.x : region.x + region.width][::-1]
    height = np.flatnonzero(pixels[:, : region.width * 3 // 4].max(axis=(1, 2)) > 0.6).max() + 20
    shown = pixels[:height]
    columns = [shown[top : top + MOST_PIXELS] for top in range(0, height, MOST_PIXELS)]
    columns[-1] = np.pad(columns[-1], ((0, len(columns[0]) - len(columns[-1])), (0, 0), (0, 0)))
    folded = np.hstack(columns)
    png.write_png(path, np.ascontiguousarray(np.round(255 * folded).astype(np.uint8)))
    say(f"wrote {path.name}: {region.width} pixels wide, {height} high")


def steps(target: bpy.types.Object, folder: Path) -> Iterator[None]:
    """Every language, the longest at every scale."""
    folder.mkdir(parents=True, exist_ok=True)
    settings, preferences = bpy.context.scene.paradesc, bpy.context.preferences
    settings.radius_percent, settings.samples, settings.descriptors = 0.3, 16, {"cavity", "harris"}
    start_bake()
    yield from wait_for(lambda: not baking())
    screen.open_panels()
    preferences.system.use_region_overlap = False
    with bpy.context.temp_override(**view_context()):
        bpy.ops.screen.screen_full_area(use_hide_panels=True)
    yield
    view_context()["area"].spaces[0].show_region_ui = True
    yield
    region = sidebar()
    yield from click(region.x + region.width - 12, region.y + region.height - TAB_BELOW_TOP)
    settings.descriptors = {"harris"}
    target.scale = (2, 1, 1)
    target.paradesc_live.mode = "LIVE"
    target.data.shape_keys or target.shape_key_add(name="Basis")
    bpy.context.scene.paradesc_looks.span = "percentile"
    bpy.context.scene.paradesc_animation.use_scene_range = False
    for language in [name for name in LANGUAGES if name in bpy.app.translations.locales]:
        preferences.view.language = language
        preferences.view.use_translate_interface = preferences.view.use_translate_tooltips = True
        for scale in SCALES if language in ("en_US", "de_DE") else SCALES[:1]:
            preferences.view.ui_scale = scale
            yield
            yield from take(folder / f"panel_{scale:g}_{language}.png")
    say("all steps passed")


def main() -> None:
    """Prepares the scene and lets the event loop do the rest."""
    prepare()
    begin(steps(add_sphere(steps=24), Path(words[1])), 0.3)


main()
