"""A creature: the bust of a goblin with ears, horns, folds of skin and warts."""

import math
from itertools import pairwise

import bpy
import numpy as np

from .parts import build, ramp, rough
from .solids import Solid, box, cone, ellipsoid


def creature(step: float = 0.0125) -> bpy.types.Object:
    """A goblin's bust with ears, horns, fangs, folds of skin and warts, 2 high. It looks along -y."""
    solid = Solid((0, -0.8, -1.1), (1.25, 0.65, 1.1), step, mirrored=True)
    add_head(solid)
    add_face(solid)
    add_ears_and_horns(solid)
    fold_skin(solid)
    points, quads = solid.mesh()
    points = rough(points, quads, ((0.004, 0.06, 3), (0.01, 0.3, 1)))
    return build("creature", points, quads)


def add_head(solid: Solid) -> None:
    """Skull, jaw, neck and shoulders."""
    solid.add(ellipsoid((0, 0.03, 0.18), (0.40, 0.46, 0.47)))
    solid.add(ellipsoid((0, -0.14, -0.2), (0.32, 0.34, 0.27)), 0.15)
    solid.add(cone((0, 0.12, -0.3), (0, 0.16, -0.8), 0.25, 0.3), 0.12)
    solid.add(ellipsoid((0, 0.14, -0.98), (0.68, 0.36, 0.28), power=2.4), 0.16)
    solid.add(cone((0.5, -0.02, -0.84), (0.06, -0.17, -0.83), 0.05, 0.04), 0.06)  # the collar bone
    solid.add(cone((0.2, 0.02, -0.32), (0.08, -0.14, -0.8), 0.075, 0.05), 0.06)  # the neck's cord
    solid.cut(box((0, 0, -1.3), (2, 2, 0.22)))


def add_face(solid: Solid) -> None:
    """Brow, eyes, nose, cheeks and mouth."""
    solid.add(ellipsoid((0.0, -0.36, -0.39), (0.15, 0.13, 0.11)), 0.09)
    solid.add(cone((0.0, -0.41, 0.2), (0.30, -0.31, 0.29), 0.07, 0.07), 0.09)
    solid.cut(ellipsoid((0.17, -0.47, 0.11), (0.12, 0.1, 0.09)), 0.06)
    eye = (0.165, -0.36, 0.11)
    lids = ellipsoid(eye, (0.125, 0.125, 0.125))
    solid.add_common(lids, box((0.165, -0.36, 0.26), (0.2, 0.2, 0.11), turn=(-14, -14, 0)), 0.012)
    solid.add_common(lids, box((0.165, -0.36, -0.04), (0.2, 0.2, 0.1), turn=(12, 6, 0)), 0.012)
    solid.add(ellipsoid(eye, (0.1, 0.1, 0.1)))
    solid.cut(ellipsoid((0.16, -0.463, 0.105), (0.028, 0.02, 0.036)), 0.01)
    solid.add(ellipsoid((0.25, -0.32, -0.04), (0.11, 0.12, 0.09), (0, 20, 0)), 0.09)
    solid.add(cone((0, -0.42, 0.16), (0, -0.63, -0.04), 0.055, 0.08), 0.07)
    solid.add(ellipsoid((0.08, -0.55, -0.05), (0.06, 0.07, 0.05)), 0.04)
    solid.cut(ellipsoid((0.062, -0.6, -0.09), (0.028, 0.04, 0.03)), 0.02)
    fold = [(0.13, -0.04), (0.2, -0.12), (0.27, -0.24)]
    for a, b in pairwise((x, solid.front(x, z) - 0.012, z) for x, z in fold):
        solid.cut(cone(a, b, 0.022, 0.026), 0.05)
    add_mouth(solid)


def add_mouth(solid: Solid) -> None:
    """Lips along the skin, the slit between them, and a fang."""
    line = [(0.0, -0.215), (0.09, -0.22), (0.17, -0.21), (0.235, -0.185)]
    mouth = [np.array((x, solid.front(x, z), z)) for x, z in line]
    for shift, width in ((0.035, 0.036), (-0.042, 0.044)):
        for a, b in pairwise(mouth):
            lip = np.array((0, 0.02, shift))
            solid.add(cone(a + lip, b + lip * (1, 1, 0.7), width, 0.8 * width), 0.045)
    for a, b in pairwise(mouth):
        solid.cut(cone(a - (0, 0.015, 0), b - (0, 0.015, 0), 0.02, 0.018, (1, 0.35, 1)), 0.02)
    solid.add(cone(mouth[2] + (0, -0.01, -0.03), mouth[2] + (0.02, -0.055, 0.11), 0.03, 0.008), 0.008)


def add_ears_and_horns(solid: Solid) -> None:
    """Flat, hollow ears with a ridge, and horns of rings that become smaller."""
    flat = (1, 2.6, 1)
    solid.add(cone((0.36, 0.06, 0.08), (0.72, 0.12, 0.24), 0.17, 0.15, flat), 0.06)
    solid.add(cone((0.72, 0.12, 0.24), (1.16, 0.2, 0.5), 0.15, 0.012, flat), 0.03)
    solid.cut(cone((0.48, -0.0, 0.12), (0.74, 0.05, 0.25), 0.10, 0.095, flat), 0.03)
    solid.cut(cone((0.74, 0.05, 0.25), (1.05, 0.13, 0.44), 0.095, 0.012, flat), 0.03)
    solid.add(cone((0.42, 0.01, 0.07), (0.88, 0.12, 0.33), 0.03, 0.012), 0.03)
    solid.add(cone((0.4, -0.03, 0.02), (0.47, -0.02, -0.1), 0.05, 0.045), 0.05)  # the lobe
    turns = np.linspace(0, 2.0, 13)
    line = [(0.2 + 0.08 * turn, -0.14 + 0.22 * (1 - math.cos(turn)), 0.5 + 0.38 * math.sin(turn)) for turn in turns]
    widths = 0.1 - 0.043 * turns
    for k, ((a, b), width) in enumerate(zip(pairwise(line), widths, strict=False)):
        solid.add(cone(a, b, width, 0.8 * width), 0.012 if k else 0.04)


def fold_skin(solid: Solid) -> None:
    """Wrinkles across the forehead and around the neck, and warts."""
    solid.even_out()
    x, y, z = solid.axes()
    forehead = ramp(y, -0.1, -0.25) * ramp(z, 0.3, 0.38) * ramp(z, 0.62, 0.5) * ramp(x, 0.32, 0.15)
    solid.sink(0.009 * forehead * np.cos(85 * (z - 0.25 * x**2) + 1.0))
    neck = ramp(z, -0.82, -0.72) * ramp(z, -0.36, -0.46)
    solid.sink(0.011 * neck * np.cos(62 * z + 5 * np.sin(6 * y) + 9 * x**2))
    generator = np.random.default_rng(11)
    spots = generator.uniform((0.03, -0.6, -0.42), (0.42, 0.1, 0.56), (500, 3))
    near = [spot for spot in spots if abs(solid.at(spot)) < 0.012 and abs(spot[2] + 0.2) > 0.12]
    for spot in near[:14]:
        radius = generator.uniform(0.016, 0.03)
        solid.add(ellipsoid(spot, (radius, radius, radius)), 0.025)


def caterpillar(step: float = 0.02) -> bpy.types.Object:
    """A caterpillar 2.6 long, along z, with folds between its rings; its legs look along x."""
    solid = Solid((-0.5, -0.45, -1.4), (0.6, 0.45, 1.5), step)
    for k in range(10):
        width = 0.27 + 0.05 * math.sin(0.35 * k + 0.4)
        solid.add(ellipsoid((0, 0, 0.25 * k - 1.15), (width, width, 0.19)), 0.05)
        for y in (-0.13, 0.13):
            if 1 <= k <= 8:
                solid.add(cone((0.2, y, 0.25 * k - 1.15), (0.38, 1.15 * y, 0.25 * k - 1.15), 0.075, 0.05), 0.04)
    solid.add(ellipsoid((-0.03, 0, 1.2), (0.3, 0.3, 0.26)), 0.03)
    for y in (-0.14, 0.14):
        solid.add(ellipsoid((-0.12, y, 1.4), (0.1, 0.08, 0.08)), 0.01)
        solid.add(cone((-0.27, 0.6 * y, 1.25), (-0.44, 1.3 * y, 1.36), 0.035, 0.05), 0.02)
    return build("caterpillar", *solid.mesh())
