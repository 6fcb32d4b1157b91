"""The command line with one more output of bake, .png: a picture with a view and a legend for each descriptor.

python draw.py bake FILE … --output picture.png
"""

import sys
from pathlib import Path

import numpy as np
import picture

from paradesc.commands import outputs
from paradesc.commands.main import main
from paradesc.core import color_maps, legend
from paradesc.files import png
from paradesc.files.results import Baked


def write_picture(path: Path, baked: Baked) -> None:
    """Writes a PNG with one view for each descriptor, in world space."""
    matrix = baked.matrix_world
    points = baked.arrays.positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    views = []
    for name in baked.results.values:
        shown = baked.results.shown(name) if baked.results.values[name].ndim == 1 else None
        colors = color_maps.colors(baked.results.values[name], baked.results.shown(name))
        views.append(picture.View(colors, legend.title(name, baked.unit(name)), shown, name))
    png.write_png(path, picture.compose(points, baked.arrays.triangle_vertices, views))


def run(words: list[str]) -> int:
    """Runs a command; returns its exit code."""
    outputs.WRITERS[".png"] = write_picture
    return main(words)


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
