"""A carved stone: a hewn slab with a triskele, rings, runes and a zigzag cut into its front, chipped and cracked."""

import math
from itertools import pairwise

import bpy
import numpy as np

from .parts import build, ramp, rough
from .solids import Part, Solid, box, ellipsoid

WHEEL = (0.0, 1.16)  # the middle of the carved wheel: x, z
# Strokes of runes in a field 1 wide and 1 high.
RUNES = (
    ((0.2, 0, 0.2, 1), (0.2, 0.9, 0.8, 0.7), (0.8, 0.7, 0.2, 0.5)),
    ((0.2, 0, 0.2, 1), (0.2, 1, 0.8, 0.75), (0.2, 0.65, 0.8, 0.4)),
    ((0.2, 0, 0.2, 1), (0.2, 0.95, 0.75, 0.7), (0.75, 0.7, 0.2, 0.45), (0.2, 0.45, 0.8, 0)),
    ((0.1, 0, 0.1, 1), (0.9, 0, 0.9, 1), (0.1, 1, 0.9, 0.4), (0.9, 1, 0.1, 0.4)),
    ((0.5, 0, 0.5, 1), (0.5, 0.55, 0.1, 1), (0.5, 0.55, 0.9, 1)),
)


def stone(step: float = 0.0115) -> bpy.types.Object:
    """A standing stone 1.8 high on a rough base; its carved front looks along -y."""
    solid = Solid((-0.72, -0.5, -0.02), (0.72, 0.5, 1.86), step)
    solid.add(hewn())
    solid.even_out()
    carve(solid)
    generator = np.random.default_rng(3)
    for _ in range(26):  # chips along the edges
        side, height, depth = generator.choice([-1, 1]), generator.uniform(0.42, 1.75), generator.choice([-1, 1])
        width = 0.5 - 0.06 * height - 0.2 * max(height - 1.35, 0)
        radii = generator.uniform(0.03, 0.1, 3)
        solid.cut(ellipsoid((side * width, depth * 0.175, height), radii, generator.uniform(-40, 40, 3)), 0.02)
    solid.add(box((0, 0, 0.1), (0.62, 0.4, 0.11), 0.05), 0.03)
    points, quads = solid.mesh()
    points = rough(points, quads, ((0.006, 0.06, 4), (0.016, 0.35, 2)))
    return build("stone", points, quads)


def hewn() -> Part:
    """A slab between planes that are not quite straight, its top broken round."""
    planes = [(0, -1, 0, 0.17), (0.03, 1, 0.02, 0.17), (0.1, 0.9, 0.3, 0.66), (0, 0, -1, 0.0)]
    for side in (-1, 1):
        planes += [(side, 0.1 * side, 0.06, 0.5), (side, 0.9, 0.05, 0.56), (side, -1.1, 0.05, 0.62)]
        planes += [(side * 0.9, 0, 0.5, 1.12 + 0.02 * side), (side * 0.5, 0, 0.9, 1.6)]
    planes += [(0.1, 0, 1, 1.74), (0.05, -1, 0.6, 1.11), (-0.1, 1, 0.7, 1.2)]

    def distance(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        deepest = np.float32(-1)
        for a, b, c, height in planes:
            length = math.sqrt(a * a + b * b + c * c)
            face = (a * x + b * y + c * z - height) / length
            near = np.maximum(0.03 - np.abs(face - deepest), 0) / 0.03
            deepest = np.maximum(face, deepest) + near**2 * 0.0075
        return deepest

    return Part(distance, (-0.7, -0.4, 0), (0.7, 0.4, 1.8))


def carve(solid: Solid) -> None:
    """Cuts the pattern, and a crack, into the surface that looks to the front."""
    x, y, z = solid.axes()
    front = ramp(y, 0.0, -0.06)
    strokes = [line for turn in (0, 120, 240) for line in pairwise(spiral(turn))] + runes() + zigzag()
    depth = groove(distance_to(strokes, x, z), 0.026, 0.026)
    reach = np.sqrt((x - WHEEL[0]) ** 2 + (z - WHEEL[1]) ** 2)
    for radius in (0.345, 0.41):
        depth = np.maximum(depth, groove(np.abs(reach - radius), 0.02, 0.022))
    crack = [(0.33, 0.24), (0.27, 0.36), (0.3, 0.45), (0.22, 0.56), (0.24, 0.66), (0.39, 0.75), (0.41, 0.9), (0.5, 1.0)]
    cracked = groove(distance_to([(*a, *b) for a, b in pairwise(crack)], x, z), 0.018, 0.03)
    solid.sink(front * np.maximum(depth, cracked))


def groove(apart: np.ndarray, width: float, depth: float) -> np.ndarray:
    """How deep a groove is at these distances from its middle: flat there, with slanted sides."""
    return depth * np.clip(1.5 * (1 - apart / width), 0, 1)


def spiral(turn: float) -> list[tuple[float, float]]:
    """Points of one arm of the triskele: from its middle to the end of a spiral."""
    angle = np.linspace(0, 1, 60)
    middle = 0.17 * np.array([math.cos(math.radians(turn)), math.sin(math.radians(turn))])
    radius, around = 0.13 * angle + 0.012, math.radians(turn) + 2 * np.pi * 1.9 * angle + 3.6
    points = middle + np.stack([radius * np.cos(around), radius * np.sin(around)], axis=1)
    points = [tuple(np.array(WHEEL) + point) for point in points]
    return [(*a,) for a in points]


def runes() -> list[tuple[float, float, float, float]]:
    """A row of runes below the wheel."""
    found = []
    for k, strokes in enumerate(RUNES):
        left, low, width, height = -0.36 + 0.15 * k, 0.47, 0.105, 0.17
        found += [(left + width * a, low + height * b, left + width * c, low + height * d) for a, b, c, d in strokes]
    return found


def zigzag() -> list[tuple[float, float, float, float]]:
    """A band at the foot, between two lines."""
    points = [(-0.4 + 0.08 * k, 0.3 + 0.07 * (k % 2)) for k in range(11)]
    return [(*a, *b) for a, b in pairwise(points)] + [(-0.42, 0.42, 0.42, 0.42)]


def distance_to(lines: list, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The distance from (x, z) to the nearest of lines (x, z, x, z), or pairs of points."""
    nearest = np.full(np.broadcast_shapes(x.shape, z.shape), 10.0, np.float32)
    for line in lines:
        a, b, c, d = np.ravel(line)
        u, v = c - a, d - b
        share = np.clip(((x - a) * u + (z - b) * v) / max(u * u + v * v, 1e-12), 0, 1)
        nearest = np.minimum(nearest, np.hypot(x - a - share * u, z - b - share * v))
    return nearest
