"""Solids as distances on a grid → closed meshes of quads, like the result of a voxel remesh. Uses numpy alone.

A part is a function of (x, y, z) that is negative inside, and a box around the part. Distances need not be exact: only
their zeros and the slopes there matter.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Vector = Sequence[float]
Distance = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
FAR = 10.0
CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1]


@dataclass(frozen=True)
class Part:
    """A distance and the corners of a box that holds all of its solid."""

    distance: Distance
    lower: Vector
    upper: Vector


def turned(x: np.ndarray, y: np.ndarray, z: np.ndarray, turn: Vector) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates in a frame that is turned by these degrees around x, then y, then z."""
    for first, second, angle in ((1, 2, turn[0]), (2, 0, turn[1]), (0, 1, turn[2])):
        if angle:
            place = [x, y, z]
            c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            a, b = place[first], place[second]
            place[first], place[second] = c * a + s * b, c * b - s * a
            x, y, z = place
    return x, y, z


def ellipsoid(center: Vector, radii: Vector, turn: Vector = (0, 0, 0), power: float = 2.0) -> Part:
    """An ellipsoid; a power above 2 makes it squarer."""

    def distance(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        place = turned(x - center[0], y - center[1], z - center[2], turn)
        total = sum(np.abs(along / radius) ** power for along, radius in zip(place, radii, strict=True))
        return (total ** (1 / power) - 1) * min(radii)

    reach = np.array(radii) if not any(turn) else np.full(3, max(radii) * (1.3 if power > 2 else 1.0))
    return Part(distance, np.array(center) - reach, np.array(center) + reach)


def cone(begin: Vector, end: Vector, first: float, last: float, flat: Vector = (1, 1, 1)) -> Part:
    """A cone with round ends between two points; flat: factors that make it thinner along the axes."""
    a, b, scale = np.array(begin, float), np.array(end, float), np.array(flat, float)
    way = (b - a) * scale
    length = float(way @ way)

    def distance(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        place = [(along - start) * factor for along, start, factor in zip((x, y, z), a, scale, strict=True)]
        share = np.clip(sum(p * w for p, w in zip(place, way, strict=True)) / length, 0, 1)
        apart = sum((p - share * w) ** 2 for p, w in zip(place, way, strict=True))
        return (np.sqrt(apart) - first - share * (last - first)) / scale.max()

    reach = max(first, last) / scale
    return Part(distance, np.minimum(a, b) - reach, np.maximum(a, b) + reach)


def box(center: Vector, half: Vector, rounding: float = 0.0, turn: Vector = (0, 0, 0)) -> Part:
    """A box with rounded edges."""

    def distance(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        place = turned(x - center[0], y - center[1], z - center[2], turn)
        over = [np.abs(along) - size + rounding for along, size in zip(place, half, strict=True)]
        outside = np.sqrt(sum(np.maximum(part, 0) ** 2 for part in over))
        return outside + np.minimum(np.maximum(np.maximum(over[0], over[1]), over[2]), 0) - rounding

    reach = np.array(half) if not any(turn) else np.full(3, np.linalg.norm(half))
    return Part(distance, np.array(center) - reach, np.array(center) + reach)


def ring(center: Vector, axis: int, radius: float, tube: float) -> Part:
    """A torus around an axis: 0, 1 or 2."""

    def distance(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        place = [x - center[0], y - center[1], z - center[2]]
        along = place.pop(axis)
        return np.sqrt((np.sqrt(place[0] ** 2 + place[1] ** 2) - radius) ** 2 + along**2) - tube

    reach = np.where(np.arange(3) == axis, tube, radius + tube)
    return Part(distance, np.array(center) - reach, np.array(center) + reach)


def disk(center: Vector, axis: int, radius: float, half: float, rounding: float = 0.0) -> Part:
    """A cylinder with rounded rims around an axis: 0, 1 or 2."""

    def distance(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        place = [x - center[0], y - center[1], z - center[2]]
        along = np.abs(place.pop(axis)) - half + rounding
        across = np.sqrt(place[0] ** 2 + place[1] ** 2) - radius + rounding
        outside = np.sqrt(np.maximum(along, 0) ** 2 + np.maximum(across, 0) ** 2)
        return outside + np.minimum(np.maximum(along, across), 0) - rounding

    reach = np.where(np.arange(3) == axis, half, radius)
    return Part(distance, np.array(center) - reach, np.array(center) + reach)


class Solid:
    """Distances at the nodes of a grid. mirrored: x begins at 0, and the other half follows when the mesh is made."""

    def __init__(self, lower: Vector, upper: Vector, step: float, mirrored: bool = False) -> None:
        self.step, self.mirrored = step, mirrored
        self.lower = np.array([0 if mirrored else lower[0], lower[1], lower[2]], float)
        counts = np.ceil((np.array(upper) - self.lower) / step).astype(int) + 1
        self.values = np.full(counts, FAR, np.float32)

    def axes(self, part: tuple[slice, slice, slice] = (slice(None),) * 3) -> list[np.ndarray]:
        """The coordinates of the nodes, each along its own axis."""
        every = [self.lower[axis] + self.step * np.arange(self.values.shape[axis]) for axis in range(3)]
        chosen = [along[where].astype(np.float32) for along, where in zip(every, part, strict=True)]
        return list(np.meshgrid(*chosen, indexing="ij", sparse=True))

    def near(self, part: Part, margin: float) -> tuple[slice, slice, slice]:
        """The nodes in a part's box and a margin around it."""
        margin += 2 * self.step
        first = np.floor((np.array(part.lower) - margin - self.lower) / self.step).astype(int)
        last = np.ceil((np.array(part.upper) + margin - self.lower) / self.step).astype(int) + 1
        first, last = np.maximum(first, 0), np.maximum(last, 0)
        return tuple(slice(a, b) for a, b in zip(first, last, strict=True))

    def add(self, part: Part, blend: float = 0.0) -> None:
        """Unites with a part; blend: how wide the joint is rounded."""
        where = self.near(part, blend)
        here, other = self.values[where], part.distance(*self.axes(where))
        self.values[where] = joined(here, other, blend)

    def cut(self, part: Part, blend: float = 0.0) -> None:
        """Takes a part away."""
        where = self.near(part, blend)
        here, other = self.values[where], part.distance(*self.axes(where))
        self.values[where] = -joined(-here, other, blend)

    def add_common(self, part: Part, kept: Part, blend: float = 0.0) -> None:
        """Unites with what a part and another have in common."""
        where = self.near(part, blend)
        place = self.axes(where)
        common = -joined(-part.distance(*place), -kept.distance(*place), blend)
        self.values[where] = joined(self.values[where], common, blend)

    def even_out(self) -> list[np.ndarray]:
        """Divides the values by their slope, so that they are lengths near the surface; gives the normals."""
        slopes = np.gradient(self.values, self.step)
        length = np.maximum(np.sqrt(sum(along**2 for along in slopes)), 0.25)
        near = (np.abs(self.values) < 0.1) & (length < 2)
        self.values[near] /= length[near]
        return [along / length for along in slopes]

    def at(self, point: np.ndarray) -> float:
        """The distance at the node nearest to a point."""
        return float(self.values[tuple(np.round((point - self.lower) / self.step).astype(int))])

    def front(self, x: float, z: float) -> float:
        """The smallest y of the surface there."""
        column, row = round((x - self.lower[0]) / self.step), round((z - self.lower[2]) / self.step)
        return float(self.lower[1] + self.step * np.argmax(self.values[column, :, row] < 0))

    def sink(self, depth: np.ndarray) -> None:
        """Moves the surface inwards by a depth that fits the grid's shape; a negative one moves it outwards."""
        self.values += depth.astype(np.float32)

    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 3) and quads (m, 4), of which the normals look out."""
        values, lower = self.values, self.lower.copy()
        if self.mirrored:
            values = np.concatenate([values[:0:-1], values])
            lower[0] = -self.step * (self.values.shape[0] - 1)
        values = np.pad(values, 1, constant_values=FAR)
        points, quads = surface_net(values)
        points, quads = largest(points, quads)
        for _ in range(2):
            points = settled(relaxed(points, quads), values)
        return lower + self.step * (points - 1), quads


def joined(a: np.ndarray, b: np.ndarray, blend: float) -> np.ndarray:
    """The smaller of two distances, rounded where they differ by less than blend."""
    if not blend:
        return np.minimum(a, b)
    near = np.maximum(blend - np.abs(a - b), 0) / blend
    return np.minimum(a, b) - near**2 * blend / 4


def surface_net(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A vertex in each cell of the grid that the surface crosses, and a quad around each edge that it crosses."""
    inside = values < 0
    whole = tuple(size - 1 for size in values.shape)
    count = np.zeros(whole, np.int8)
    for corner in CORNERS:
        count += inside[tuple(slice(c, c + size) for c, size in zip(corner, whole, strict=True))]
    cells = np.argwhere((count > 0) & (count < 8))
    numbers = np.full(whole, -1, np.int64)
    numbers[tuple(cells.T)] = np.arange(len(cells))
    at = np.stack([values[tuple((cells + corner).T)] for corner in CORNERS], axis=1).astype(float)
    total, crossed = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for a, b in EDGES:
        here = (at[:, a] < 0) != (at[:, b] < 0)
        share = at[here, a] / (at[here, a] - at[here, b])
        total[here] += CORNERS[a] + share[:, None] * (CORNERS[b] - CORNERS[a])
        crossed[here] += 1
    quads = []
    for axis in range(3):
        before, after = (tuple(slice(k, k - 1 or None) if a == axis else slice(None) for a in range(3)) for k in (0, 1))
        first = inside[before]
        second = inside[after]
        for way, mask in ((1, first & ~second), (-1, second & ~first)):
            nodes = np.argwhere(mask)
            u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
            around = [nodes - u - v, nodes - v, nodes, nodes - u][::way]
            quads.append(np.stack([numbers[tuple(place.T)] for place in around], axis=1))
    return cells + total / crossed[:, None], np.concatenate(quads)


def largest(points: np.ndarray, quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The connected part with the most points, without crumbs and bubbles."""
    part, before = np.arange(len(points)), None
    while before is None or not np.array_equal(part, before):
        before = part.copy()
        np.minimum.at(part, quads.ravel(), np.repeat(before[quads].min(axis=1), 4))
        part = part[part]
    kept = part == np.bincount(part).argmax()
    return points[kept], (np.cumsum(kept) - 1)[quads[kept[quads[:, 0]]]]


def relaxed(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Points halfway to the mean of their neighbors."""
    total, count = np.zeros_like(points), np.zeros(len(points))
    for side in range(4):
        for other in (quads[:, side - 1], quads[:, side - 3]):
            for axis in range(3):
                total[:, axis] += np.bincount(quads[:, side], points[other, axis], len(points))
            count += np.bincount(quads[:, side], minlength=len(points))
    return 0.5 * points + 0.5 * total / count[:, None]


def settled(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Points moved along the slope onto the surface, by at most half a step."""
    first = np.clip(np.floor(points).astype(int), 0, np.array(values.shape) - 2)
    share = points - first
    at = np.zeros(len(points))
    slope = np.zeros_like(points)
    for corner in CORNERS:
        value = values[tuple((first + corner).T)]
        weights = np.where(corner, share, 1 - share)
        at += value * weights.prod(axis=1)
        for axis in range(3):
            others = weights[:, [a for a in range(3) if a != axis]].prod(axis=1)
            slope[:, axis] += value * others * (1 if corner[axis] else -1)
    move = slope * (at / np.maximum((slope**2).sum(axis=1), 1e-12))[:, None]
    length = np.linalg.norm(move, axis=1, keepdims=True)
    return points - move * np.minimum(1, 0.5 / np.maximum(length, 1e-12))
