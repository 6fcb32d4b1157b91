"""The subjects of pictures of windows and of the command line, and how the command line draws one."""

import math
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
import picture
import screen
from draw import run

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "blend_samples"))
import models

RADIUS_PERCENT, BUFFER = 2.5, 1024
BACKGROUND = round(255 * picture.BACKGROUND)
MARGIN = 8  # pixels that stay around what is seen


def empty() -> None:
    """Removes all objects of the scene."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)


def monkey() -> bpy.types.Object:
    """Blender's monkey, subdivided twice."""
    empty()
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    bpy.ops.object.shade_smooth()
    made.modifiers.new("subdivision", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="subdivision")
    made.name = "Suzanne"
    made.rotation_euler = (math.radians(-12), 0, math.radians(20))
    return made


def creature(step: float = 0.016) -> bpy.types.Object:
    """A goblin's bust."""
    empty()
    made = models.creature(step)
    made.rotation_euler = (0, 0, math.radians(14))
    return made


def rounded_box() -> bpy.types.Object:
    """A box with rounded edges and corners."""
    empty()
    bpy.ops.mesh.primitive_cube_add(size=1)
    made = bpy.context.active_object
    made.scale = (1.0, 1.0, 0.7)
    bpy.ops.object.transform_apply(scale=True)
    bevel = made.modifiers.new("bevel", "BEVEL")
    bevel.width, bevel.segments = 0.09, 5
    bpy.ops.object.modifier_apply(modifier="bevel")
    for _ in range(4):
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.shade_smooth()
    made.name = "Box"
    return made


def machine_part() -> bpy.types.Object:
    """A turned part with steps, a groove, a chamfer and a bore, in small faces and shaded flat."""
    empty()
    profile = (
        (0.3, 0),
        (1, 0),
        (1, 0.3),
        (0.6, 0.3),
        (0.6, 0.55),
        (0.52, 0.55),
        (0.52, 0.7),
        (0.6, 0.7),
        (0.6, 0.9),
        (0.5, 1),
        (0.3, 1),
        (0.3, 0),
    )
    sides, step = 96, 0.025
    places = [
        np.array(begin) + (np.array(end) - begin) * k / count
        for begin, end in pairwise(profile)
        for count in (max(round(math.dist(begin, end) / step), 1),)
        for k in range(count)
    ]
    turns = 2 * np.pi * np.arange(sides) / sides
    points = [(r * math.cos(turn), r * math.sin(turn), z) for r, z in places for turn in turns]
    rows = len(places)
    faces = [
        (
            row * sides + side,
            row * sides + (side + 1) % sides,
            (row + 1) % rows * sides + (side + 1) % sides,
            (row + 1) % rows * sides + side,
        )
        for row in range(rows)
        for side in range(sides)
    ]
    mesh = bpy.data.meshes.new("Part")
    mesh.from_pydata(points, [], faces)
    made = bpy.data.objects.new("Part", mesh)
    bpy.context.collection.objects.link(made)
    return made


def baked(made: bpy.types.Object, *descriptors: str) -> bpy.types.Object:
    """The active object with these descriptors as attributes and colors, by the panel's button."""
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.buffer_size = set(descriptors), BUFFER
    bpy.ops.paradesc.bake()
    return made


def drawn(made: bpy.types.Object, *words: str) -> np.ndarray:
    """(height, width, 3) uint8: the command line's picture of an object, at half size."""
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "drawn.png")
        if run(["bake", "--object", made.name, *words, "--output", file, "--quiet"]) != 0:
            raise RuntimeError("the mesh was not baked")
        return screen.pixels_of(file)[::2, ::2]


def trimmed(image: np.ndarray) -> np.ndarray:
    """An image without the empty rows and columns around what is seen."""
    seen = (image != BACKGROUND).any(axis=2)
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    top, left = max(rows[0] - MARGIN, 0), max(columns[0] - MARGIN, 0)
    return image[top : rows[-1] + MARGIN, left : columns[-1] + MARGIN]
