"""Measures of a mask as it is shown: how much of the surface is white or black, and what flat faces have.

Everything is weighted by area, over points of the surface. At vertices the points are the corners of the triangles; of images they
lie evenly on the triangles. numpy and mathutils alone.
"""

from dataclasses import dataclass

import numpy as np
from mathutils.kdtree import KDTree

# Eight bits show this as black.
BLACK = 1 / 255
WHITE, WHITE_PERCENTILE = 0.98, 98.0
BRIGHT, LEAST_BRIGHT, MOST_BRIGHT = 0.5, 0.02, 0.40
DARK, MOST_DARK = 0.05, 0.80
MOST_ON_FLAT = 0.05
# Degrees between the normals of triangles that count as one plane.
COPLANAR = 1.0
# Sides of a round surface bend by less than this, and the next one is at least this share as large: a cylinder has eight sides or
# more, and beside the flat side of a bevel lies a strip.
ROUND, ALIKE = 50.0, 0.5
# Points along a crease stand this share of the radius apart, which makes distances at most half a percent too long.
SPACING = 0.2
# A point is flat only if it is farther than this many radii from every crease: the engine's samples have a size.
CLEAR = 1.05
# A face with such points at fewer places tells nothing of itself: a vertex is one place, however many corners meet there.
FEWEST = 6


@dataclass(frozen=True)
class Surface:
    """The triangles of a mesh."""

    positions: np.ndarray  # (vertex_count, 3) float64
    triangles: np.ndarray  # (triangle_count, 3) int vertices
    corners: np.ndarray  # (triangle_count, 3) int loops of the mesh

    @property
    def areas(self) -> np.ndarray:
        """(triangle_count,) areas."""
        return np.linalg.norm(self.crosses, axis=1) / 2

    @property
    def crosses(self) -> np.ndarray:
        """(triangle_count, 3) normals, twice as long as the areas."""
        corners = self.positions[self.triangles]
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    @property
    def diagonal(self) -> float:
        """The diagonal of the box of what has faces."""
        used = self.positions[self.triangles].reshape(-1, 3)
        return float(np.linalg.norm(used.max(axis=0) - used.min(axis=0)))


@dataclass(frozen=True)
class Points:
    """Points of a surface, each standing for a part of its area."""

    triangles: np.ndarray  # (n,) int the triangle on which each lies
    weights: np.ndarray  # (n, 3) barycentric
    areas: np.ndarray  # (n,) what each stands for

    def places(self, surface: Surface) -> np.ndarray:
        """(n, 3) positions."""
        return self.mixed(surface.positions[surface.triangles])

    def mixed(self, at_corners: np.ndarray) -> np.ndarray:
        """(n, k) values between those of the corners, (triangle_count, 3, k)."""
        return np.einsum("nc,nck->nk", self.weights, at_corners[self.triangles])


@dataclass(frozen=True)
class Measures:
    """The measures of one mask; without flat faces, theirs are missing."""

    white: float  # the value at the 98th percentile of what is not black
    bright: float  # share of the area above 0.5
    dark: float  # share of the area below 0.05
    on_flat: float | None = None  # the largest mean on a flat face
    flat: float = 0.0  # share of the area in flat faces

    def faults(self) -> list[str]:
        """The reasons why an artist could not use the mask."""
        found = []
        if self.white < WHITE:
            found.append("no white")
        if not LEAST_BRIGHT <= self.bright <= MOST_BRIGHT:
            found.append("too little bright" if self.bright < LEAST_BRIGHT else "too much bright")
        if self.dark > MOST_DARK:
            found.append("black")
        if self.on_flat is not None and self.on_flat > MOST_ON_FLAT:
            found.append("flat faces are not black")
        return found


def at_corners(surface: Surface) -> Points:
    """The corners of all triangles, each for a third of its triangle: the vertices, weighted by area."""
    count = len(surface.triangles)
    return Points(np.repeat(np.arange(count), 3), np.tile(np.eye(3), (count, 1)), np.repeat(surface.areas / 3, 3))


def evenly(surface: Surface, count: int) -> Points:
    """About this many points, as many on each triangle as its area asks for, and at least one."""
    areas = surface.areas
    several = np.maximum(np.ceil(count * areas / areas.sum()).astype(int), 1)
    own = np.repeat(np.arange(len(areas)), several)
    number = np.arange(len(own)) - np.repeat(np.cumsum(several) - several, several)
    u, v = np.modf(0.5 + 0.7548776662 * number)[0], np.modf(0.5 + 0.5698402910 * number)[0]  # R2 sequence
    outside = u + v > 1
    u, v = np.where(outside, 1 - u, u), np.where(outside, 1 - v, v)
    alone = several[own] == 1
    u, v = np.where(alone, 1 / 3, u), np.where(alone, 1 / 3, v)
    return Points(own, np.stack([1 - u - v, u, v], axis=1), (areas / several)[own])


def percentile(values: np.ndarray, areas: np.ndarray, percent: float) -> float:
    """The value below which this percentage of the area lies."""
    order = np.argsort(values)
    reached = np.cumsum(areas[order])
    return float(values[order][np.searchsorted(reached, percent / 100 * reached[-1])])


def measured(values: np.ndarray, points: Points, faces: np.ndarray | None = None) -> Measures:
    """Measures (n,) shown values at points; faces: (n,) what flat_faces() gives, or None if the surface is no hard one."""
    total, lit = points.areas.sum(), values > BLACK
    white = percentile(values[lit], points.areas[lit], WHITE_PERCENTILE) if lit.any() else 0.0
    on_flat, share = None, 0.0
    if faces is not None and (faces >= 0).any():
        flat = faces >= 0
        areas = points.areas[flat]
        share = float(areas.sum() / total)
        means = np.bincount(faces[flat], values[flat] * areas) / np.maximum(np.bincount(faces[flat], areas), 1e-300)
        on_flat = float(means.max())
    bright, dark = (float(points.areas[there].sum() / total) for there in (values > BRIGHT, values < DARK))
    return Measures(white, bright, dark, on_flat, share)


# ---- Flat faces


def flat_faces(surface: Surface, points: Points, radius: float) -> np.ndarray:
    """(n,) the flat face on which each point lies farther than the radius from every edge around it; -1 elsewhere.

    A flat face is what triangles joined by edges of less than 1 degree make, of which none differs by more from their mean. Sides
    of a round surface are none: a mask has the curvature of the whole there.
    """
    welded = np.unique(np.round(surface.positions / surface.diagonal, 6), axis=0, return_inverse=True)[1].reshape(-1)
    first, second, ends, open_ends = neighbors(welded[surface.triangles], surface.triangles)
    length = np.linalg.norm(surface.crosses, axis=1)
    normals = surface.crosses / np.maximum(length, 1e-300)[:, None]
    cosine = np.einsum("ij,ij->i", normals[first], normals[second])
    bent = cosine < np.cos(np.radians(COPLANAR))
    plane = joined(len(normals), first[~bent], second[~bent])
    mean = np.stack([np.bincount(plane, surface.crosses[:, axis]) for axis in range(3)], axis=1)
    mean /= np.maximum(np.linalg.norm(mean, axis=1), 1e-300)[:, None]
    off = np.einsum("ij,ij->i", normals, mean[plane]) < np.cos(np.radians(COPLANAR))
    sound = np.bincount(plane, off & (length > 0)) == 0
    little = bent & (cosine > np.cos(np.radians(ROUND)))
    middles = surface.positions[surface.triangles].mean(axis=1)
    hollow = np.einsum("ij,ij->i", normals[first], middles[second] - middles[first]) > 0
    sound &= ~sides_of_round(np.bincount(plane, length), plane[first[little]], plane[second[little]], hollow[little])
    around = along(surface.positions[np.concatenate([ends[bent], open_ends])], SPACING * radius)
    flat = np.flatnonzero(sound[plane][points.triangles])
    flat = flat[distances(points.places(surface)[flat], around) > CLEAR * radius]
    faces = np.full(len(points.triangles), -1)
    faces[flat] = plane[points.triangles[flat]]
    places = np.round(points.places(surface)[flat] / surface.diagonal, 6)
    apart = np.unique(np.column_stack([faces[flat], places]), axis=0)[:, 0].astype(int)
    few = np.bincount(apart, minlength=1) < FEWEST
    faces[flat] = np.where(few[faces[flat]], -1, faces[flat])
    return faces


def sides_of_round(areas: np.ndarray, first: np.ndarray, second: np.ndarray, hollow: np.ndarray) -> np.ndarray:
    """(n,) whether a plane goes on as a round surface does: into two others that bend the same way and are as large.

    areas: (n,) of planes; first, second: (m,) those on the two sides of edges that bend little; hollow: (m,) whether upwards.
    """
    pairs = np.concatenate([np.stack([first, second, hollow], axis=1), np.stack([second, first, hollow], axis=1)])
    own, other = pairs[:, 0], pairs[:, 1]
    beside = np.unique(pairs[(own != other) & (areas[other] >= ALIKE * areas[own])], axis=0)
    ways = np.bincount(2 * beside[:, 0] + beside[:, 2], minlength=2 * len(areas)).reshape(-1, 2)
    return (ways > 1).any(axis=1)


def neighbors(welded: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(m,) and (m,) triangles on the two sides of edges, and (m, 2) their ends; (k, 2) ends of edges with one triangle.

    Three triangles at one edge are two pairs.
    """
    edges = np.stack([welded, np.roll(welded, -1, axis=1)], axis=2).reshape(-1, 2)
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    key = np.sort(edges, axis=1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    same = (key[order[1:]] == key[order[:-1]]).all(axis=1)
    one, other = order[:-1][same], order[1:][same]
    alone = np.setdiff1d(order, np.concatenate([one, other]))
    return one // 3, other // 3, ends[one], ends[alone]


def joined(count: int, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(count,) numbers of the parts that pairs join."""
    label = np.arange(count)
    while True:
        least = label.copy()
        low = np.minimum(label[first], label[second])
        np.minimum.at(least, first, low)
        np.minimum.at(least, second, low)
        least = least[least]
        if np.array_equal(least, label):
            return np.unique(label, return_inverse=True)[1].reshape(-1)
        label = least


def along(ends: np.ndarray, spacing: float) -> np.ndarray:
    """(n, 3) places along (m, 2, 3) lines, not farther apart than the spacing."""
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    several = np.ceil(lengths / spacing).astype(int) + 1
    own = np.repeat(np.arange(len(ends)), several)
    number = np.arange(len(own)) - np.repeat(np.cumsum(several) - several, several)
    share = (number / np.maximum(several[own] - 1, 1))[:, None]
    return ends[own, 0] * (1 - share) + ends[own, 1] * share


def distances(places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(n,) distances to the nearest of the others; infinite where there is none."""
    if not len(others):
        return np.full(len(places), np.inf)
    tree = KDTree(len(others))
    for number, place in enumerate(others):
        tree.insert(place, number)
    tree.balance()
    return np.array([tree.find(place)[2] for place in places])
