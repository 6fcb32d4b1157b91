"""Holds polygons, and cuts them into triangles: convex ones as fans, others by clipping ears, the best shaped first.

No vertex of a polygon is left on the side of a triangle as long as the polygon has an area, so that what is connected
stays connected. All polygons with the same number of corners are cut together.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..bridge import MeshArrays

# A triangle counts as a line if twice its area is a smaller share than this of its polygon's squared size. Coordinates
# that were 32-bit floats are not straighter than this.
THIN = 1e-7
# So many corners are cut together that their numbers stay in the processor's cache.
BLOCK = 1 << 14


@dataclass
class Polygons:
    """The faces of a mesh, whose corners follow each other."""

    corner_vertices: np.ndarray  # (corner_count,) int32
    sizes: np.ndarray  # (face_count,) int64 numbers of corners


@dataclass(eq=False)
class PolygonMesh:
    """A mesh of polygons as files hold it, whose corners follow each other."""

    positions: np.ndarray  # (vertex_count, 3) float32, or float64 where it lies far from the origin
    corner_vertices: np.ndarray  # (corner_count,) int32
    sizes: np.ndarray  # (face_count,) int64 corners of each face
    corner_uvs: np.ndarray | None = None  # (corner_count, 2) float32
    corner_normals: np.ndarray | None = None  # (corner_count, 3) float32 unit, the file's own
    notes: list[str] = field(default_factory=list)  # what was done to it, and parts of the file that were left out
    name: str = ""
    matrix_world: np.ndarray = field(default_factory=lambda: np.eye(4))  # (4, 4) float64

    @property
    def face_count(self) -> int:
        """The number of faces, with polygons."""
        return len(self.sizes)

    @cached_property
    def arrays(self) -> MeshArrays:
        """The mesh as triangles, which keep its vertices and corners; without its normals."""
        triangles = triangle_corners(self, self.positions.astype(np.float64))
        return MeshArrays(self.positions, self.corner_vertices, triangles, self.corner_uvs)


def listed(places: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The indices of all items of lists that begin at places (n,) and have these lengths (n,)."""
    before = np.cumsum(sizes) - sizes
    return np.repeat(places - before, sizes) + np.arange(int(sizes.sum()))


def vertices_at(corners: np.ndarray, vertex_count: int) -> np.ndarray:
    """(n,) int64 vertices that a file has at corners (n,), numbers of any type; ValueError if one is not there."""
    if corners.size and not 0 <= corners.min() <= corners.max() < vertex_count:
        wrong = corners.min() if corners.min() < 0 else corners.max()
        raise ValueError(f"a face has vertex {wrong:.10g}, counted from 0, and there are {vertex_count}")
    if corners.dtype.kind == "f" and (corners != np.rint(corners)).any():
        raise ValueError("a face has a vertex that is not a whole number")
    return corners.astype(np.int64)


def listed_polygons(table: np.ndarray) -> Polygons | None:
    """The faces of VTK's list (n,) int64, in which the size of each stands before it; None if it ends within one."""
    size = int(table[0]) if len(table) else 0
    if size > 0 and len(table) % (size + 1) == 0 and (table[:: size + 1] == size).all():
        rows = table.reshape(-1, size + 1)
        return Polygons(rows[:, 1:].reshape(-1), np.full(len(rows), size, np.int64))
    heads, at, numbers = [], 0, table.tolist()
    while at < len(numbers) and numbers[at] >= 0:
        heads.append(at)
        at += numbers[at] + 1
    return Polygons(np.delete(table, heads), table[heads]) if at == len(numbers) else None


def triangles_of_strips(vertices: np.ndarray, restart: int | None = None) -> np.ndarray:
    """(m, 3) triangles of a strip of (n,) vertices, or of several with a number between them; none without an area.

    Every other triangle of a strip is turned, so that all of them face the same side.
    """
    if len(vertices) < 3:
        return np.empty((0, 3), vertices.dtype)
    corners = np.lib.stride_tricks.sliding_window_view(vertices, 3)
    ends = np.zeros(len(vertices), bool) if restart is None else vertices == restart
    places = np.arange(len(vertices))
    begin = np.maximum.accumulate(np.where(ends, places + 1, 0))[: len(corners)]
    first, second, third = corners.T
    sound = (first != second) & (second != third) & (third != first)
    sound &= ~(ends[:-2] | ends[1:-1] | ends[2:])
    turned = (places[: len(corners)] - begin) % 2 == 1
    return np.where(turned[:, None], corners[:, [1, 0, 2]], corners)[sound]


def triangles_of(vertices: np.ndarray, sizes: np.ndarray, restart: int | None = None) -> Polygons:
    """The triangles of strips that follow each other among (n,) vertices, as many in each as (m,) sizes say."""
    whole = [triangles_of_strips(part, restart) for part in np.split(vertices, np.cumsum(sizes)[:-1])]
    triangles = np.concatenate([np.empty((0, 3), np.int64), *whole])
    return Polygons(triangles.reshape(-1), np.full(len(triangles), 3, np.int64))


def triangles_of_fan(vertices: np.ndarray) -> np.ndarray:
    """(n - 2, 3) triangles of a fan of (n,) vertices."""
    count = max(len(vertices) - 2, 0)
    return np.column_stack([np.broadcast_to(vertices[:1], (count,)) if count else vertices[:0],
                            vertices[1 : 1 + count], vertices[2 : 2 + count]])  # fmt: skip


def triangle_corners(polygons: Polygons | PolygonMesh, points: np.ndarray) -> np.ndarray:
    """(triangle_count, 3) int32 corners of the triangles of polygons on (n, 3) float64 points, face after face."""
    sizes = polygons.sizes
    if (sizes == 3).all():
        return np.arange(3 * len(sizes), dtype=np.int32).reshape(-1, 3)
    starts = np.cumsum(sizes) - sizes
    first = np.concatenate([[0], np.cumsum(np.maximum(sizes - 2, 0))])
    triangles = np.empty((first[-1], 3), np.int32)
    for size in np.unique(sizes[sizes > 2]):
        alike = np.flatnonzero(sizes == size)
        step = max(1, BLOCK // int(size))
        for begin in range(0, len(alike), step):
            faces = alike[begin : begin + step]
            corners = starts[faces][:, None] + np.arange(size)
            local = cut(points[polygons.corner_vertices[corners]])
            places = first[faces][:, None] + np.arange(size - 2)
            triangles[places] = np.take_along_axis(corners[:, None, :], local, axis=2)
    return triangles


def cut(polygons: np.ndarray) -> np.ndarray:
    """(g, k - 2, 3) int64 places of the corners of triangles in (g, k, 3) polygons."""
    count, size = polygons.shape[:2]
    fan = np.stack([np.zeros(size - 2, np.int64), np.arange(1, size - 1), np.arange(2, size)], axis=1)
    triangles = np.repeat(fan[None], count, axis=0)
    if size == 3:
        return triangles
    flat = flattened(polygons)
    thinnest = areas(flat, fan).min(axis=1)
    if size == 4:
        other = np.array([[0, 1, 3], [1, 2, 3]])
        straight = (np.abs(thinnest) < THIN) & (areas(flat, other).min(axis=1) > thinnest)
        triangles[bends_inwards(polygons) | straight] = other
        return triangles
    bent = np.flatnonzero(thinnest < THIN)
    if bent.size:
        triangles[bent] = Ears(flat[bent]).clip()
    return triangles


def bends_inwards(quads: np.ndarray) -> np.ndarray:
    """(g,) bool: whether the second and fourth of (g, 4, 3) corners lie on one side of the line from first to third.

    Blender divides quads by the same rule, so reading a file with or without it gives the same triangles.
    """
    second, third, fourth = (quads[:, k] - quads[:, 0] for k in (1, 2, 3))
    return (np.cross(second, third) * np.cross(fourth, third)).sum(axis=1) > 0


def flattened(polygons: np.ndarray) -> np.ndarray:
    """(g, k, 2) places of (g, k, 3) polygons in the coordinate plane nearest theirs, counterclockwise, of size 1."""
    offsets = polygons - polygons[:, :1]
    reach = np.abs(offsets).max(axis=(1, 2), keepdims=True)
    offsets = offsets / np.where(reach > 0, reach, 1.0)
    this, after = offsets[:, :-1], offsets[:, 1:]  # the first is the origin, so the last adds nothing
    normals = np.stack(
        [(this[..., k - 2] * after[..., k - 1] - this[..., k - 1] * after[..., k - 2]).sum(1) for k in range(3)], 1
    )
    axis = np.abs(normals).argmax(axis=1)
    rows = np.arange(len(polygons))
    across = np.where(normals[rows, axis] < 0, -1.0, 1.0)
    first = offsets[rows, :, (axis + 1) % 3] * across[:, None]
    return np.stack([first, offsets[rows, :, (axis + 2) % 3]], axis=2)


def turn(first: np.ndarray, second: np.ndarray, third: np.ndarray) -> np.ndarray:
    """(...) twice the signed areas of triangles of (..., 2) points."""
    one, two = second - first, third - first
    return one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]


def areas(flat: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(g, t) twice the signed areas of (t, 3) triangles in each of (g, k, 2) polygons."""
    return turn(*(flat[:, triangles[:, place]] for place in range(3)))


class Ears:
    """Clips ears from polygons. An ear is a corner whose triangle with both neighbors contains no other corner."""

    def __init__(self, flat: np.ndarray) -> None:
        """Takes (g, k, 2) counterclockwise polygons."""
        self.points = flat
        count, size = flat.shape[:2]
        self.rows = np.arange(count)
        self.before = np.repeat((np.arange(size)[None] - 1) % size, count, axis=0)
        self.after = np.repeat((np.arange(size)[None] + 1) % size, count, axis=0)
        self.alive = np.ones((count, size), bool)
        self.hopeless = np.zeros(count, bool)  # a polygon that crosses itself has no right triangles
        self.scores = np.empty((count, size))
        for corner in range(size):
            self.scores[:, corner] = self.score(self.rows, np.full(count, corner))

    def clip(self) -> np.ndarray:
        """(g, k - 2, 3) int64 places of the corners of triangles."""
        size = self.points.shape[1]
        triangles = np.empty((len(self.rows), size - 2, 3), np.int64)
        for step in range(size - 2):
            tips = self.tips()
            before, after = self.before[self.rows, tips], self.after[self.rows, tips]
            triangles[:, step] = np.stack([before, tips, after], axis=1)
            self.alive[self.rows, tips] = False
            self.scores[self.rows, tips] = -np.inf
            self.after[self.rows, before], self.before[self.rows, after] = after, before
            for neighbors in (before, after):
                self.scores[self.rows, neighbors] = self.score(self.rows, neighbors)
        return triangles

    def tips(self) -> np.ndarray:
        """(g,) the best ear of each polygon; if none is known, all its corners are scored again."""
        unknown = np.flatnonzero((self.scores.max(axis=1) <= 0) & ~self.hopeless)
        if unknown.size:
            for corner in range(self.points.shape[1]):
                rows = unknown[self.alive[unknown, corner]]
                self.scores[rows, corner] = self.score(rows, np.full(len(rows), corner))
            self.hopeless[unknown] = self.scores[unknown].max(axis=1) <= 0
        return self.scores.argmax(axis=1)

    def score(self, rows: np.ndarray, corners: np.ndarray) -> np.ndarray:
        """(r,) how well shaped the triangles at these corners are; at most 0 for corners that are not ears."""
        a = self.points[rows, self.before[rows, corners]][:, None]
        b = self.points[rows, corners][:, None]
        c = self.points[rows, self.after[rows, corners]][:, None]
        size = ((b - a) ** 2 + (c - b) ** 2 + (a - c) ** 2).sum(axis=2)[:, 0]
        shape = turn(a, b, c)[:, 0] / np.where(size > 0, size, 1.0)
        others = self.points[rows]
        inside = (turn(a, b, others) >= 0) & (turn(b, c, others) >= 0) & (turn(c, a, others) >= 0)
        for tip in (a, b, c):  # another corner at the same place is where a polygon touches itself
            inside &= (others != tip).any(axis=2)
        taken = (inside & self.alive[rows]).any(axis=1)
        return np.where(taken | (shape <= 0), shape - 1.0, shape)
