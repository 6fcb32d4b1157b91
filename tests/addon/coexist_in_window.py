"""Bakes again and again in Blender's window while the viewport redraws, then quits while a bake runs.

run_in_window.sh starts it. It bakes a hundred times with PARADESC_LONG_TESTS, else three times. Blender draws by OpenGL
on the main thread and the library on its own; the picture of the viewport has to be the same after all bakes.
"""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

words = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [words[0], str(Path(words[0]).parents[1] / "addon")]
from scene import add_sphere, attribute_values, small_bake  # noqa: E402
from window import baking, begin, prepare, say, screen_pixels, start_bake, view_context, wait_for  # noqa: E402

BAKES = 100 if os.environ.get("PARADESC_LONG_TESTS") else 3
STEP = 0.05


def picture() -> np.ndarray:
    """(height, width, 3) pixels of the middle of the viewport on the screen."""
    area = view_context()["area"]
    x, y = area.x + area.width // 2, area.y + area.height // 2
    return screen_pixels()[y - 100 : y + 100, x - 100 : x + 100]


def redraws(count: int) -> Iterator[None]:
    """Draws the viewport anew in every turn."""
    for _ in range(count):
        view_context()["area"].tag_redraw()
        yield


def steps(name: str) -> Iterator[None]:
    """The actions of the person; every yield is a turn of the event loop."""
    view_context()["area"].spaces[0].shading.type = "SOLID"
    bpy.context.scene.paradesc_looks.show_legend = False
    settings = small_bake()
    start_bake()
    yield from wait_for(lambda: not baking())
    yield from redraws(5)
    expected, before = attribute_values(bpy.data.meshes[name], "mean_curvature"), picture()
    assert np.ptp(before) > 0.1, "an empty picture shows nothing"
    for _ in range(BAKES):
        start_bake()
        while baking():
            yield from redraws(1)
        assert np.array_equal(attribute_values(bpy.data.meshes[name], "mean_curvature"), expected)
    yield from redraws(5)
    assert np.abs(picture() - before).max() < 0.02, "the viewport looks different"
    say(f"baked {BAKES} times while the viewport was drawn, all alike")
    settings.samples, settings.radius_percent, settings.buffer_size = 4096, 15.0, 1024
    settings.evaluate, settings.texels = "texel", 1024  # minutes of work
    start_bake()
    yield from redraws(6)
    assert baking(), "ended before Blender could be quit"
    say("quits while a bake runs")
    say("all steps passed")


def main() -> None:
    """Prepares the scene and lets the event loop do the rest."""
    prepare()
    made = add_sphere(steps=24)
    begin(steps(made.data.name), STEP)


main()
