"""Divides the polygons of a mesh into triangles of their own corners, as Blender does with quads. Never imports bpy."""

from dataclasses import dataclass

import numpy as np

from ..bridge import MeshArrays


@dataclass
class Polygons:
    """A mesh of polygons, whose corners follow each other."""

    positions: np.ndarray  # (vertex_count, 3) float32
    corner_vertices: np.ndarray  # (corner_count,) int32
    sizes: np.ndarray  # (face_count,) int64 corners of each face
    corner_uvs: np.ndarray | None = None  # (corner_count, 2) float32
    corner_normals: np.ndarray | None = None  # (corner_count, 3) float32 unit

    def arrays(self) -> MeshArrays:
        """The mesh as triangles, which keep its vertices and corners; without its normals."""
        triangles = triangulated(self.positions, self.corner_vertices, self.sizes)
        return MeshArrays(self.positions, self.corner_vertices, triangles, self.corner_uvs)


def triangulated(positions: np.ndarray, corner_vertices: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(triangle_count, 3) int32 corners, face after face; faces of fewer than three corners have no triangle.

    Quads are divided between their first and third corner unless they bend inwards there. Larger faces become fans, or
    lose ear after ear where a fan would fold over. positions (n, 3), corner_vertices (c,), sizes (face_count,).
    """
    sizes = np.asarray(sizes, np.int64)
    starts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    face = np.repeat(np.arange(len(sizes)), counts)
    before = np.cumsum(counts) - counts
    along = np.arange(len(face)) - before[face]
    first = starts[face]
    triangles = np.stack([first, first + along + 1, first + along + 2], axis=1)
    quads = np.flatnonzero(sizes == 4)
    bent = quads[bends_inwards(positions[corner_vertices[starts[quads, None] + np.arange(4)]])]
    triangles[before[bent], 2] = starts[bent] + 3
    triangles[before[bent] + 1, 0] = starts[bent] + 1
    for one in folded_fans(positions, corner_vertices, starts, sizes):
        own = corner_vertices[starts[one] : starts[one] + sizes[one]]
        ears = starts[one] + without_ears(flattened(positions[own]))
        triangles[before[one] : before[one] + counts[one]] = ears
    return triangles.astype(np.int32)


def bends_inwards(corners: np.ndarray) -> np.ndarray:
    """(n,) bool: the second and fourth of (n, 4, 3) corners lie on one side of the line from first to third."""
    second, third, fourth = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    return (np.cross(second, third) * np.cross(fourth, third)).sum(axis=1) > 0


def folded_fans(
    positions: np.ndarray, corner_vertices: np.ndarray, starts: np.ndarray, sizes: np.ndarray
) -> list[np.intp]:
    """The faces of five or more corners whose fan has a triangle that looks the other way."""
    found: list[np.intp] = []
    for size in np.unique(sizes[sizes > 4]):
        faces = np.flatnonzero(sizes == size)
        corners = positions[corner_vertices[starts[faces, None] + np.arange(size)]].astype(np.float64)
        corners -= corners[:, :1]
        normals = np.cross(corners[:, 1:-1], corners[:, 2:])
        folds = (normals * normals.sum(axis=1, keepdims=True)).sum(axis=2) < 0
        found += list(faces[folds.any(axis=1)])
    return found


def flattened(corners: np.ndarray) -> np.ndarray:
    """(n, 2) float64 of a polygon (n, 3), seen along its normal so that it runs counterclockwise."""
    around = corners.astype(np.float64) - corners[0]
    normal = np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
    axis = int(np.argmax(np.abs(normal)))
    flat = around[:, [(axis + 1) % 3, (axis + 2) % 3]]
    return flat if normal[axis] >= 0 else flat[:, ::-1]


def without_ears(points: np.ndarray) -> np.ndarray:
    """(n - 2, 3) triangles of a counterclockwise polygon (n, 2): ears are cut off until three corners are left."""
    left = list(range(len(points)))
    triangles = []
    at = 0
    tried = 0
    while len(left) > 3:
        before, here, after = left[at - 1], left[at], left[(at + 1) % len(left)]
        if tried >= len(left) or is_ear(points, left, (before, here, after)):  # crossing itself, it has no ear
            triangles.append((before, here, after))
            del left[at]
            at, tried = at % len(left), 0
        else:
            at, tried = (at + 1) % len(left), tried + 1
    return np.array([*triangles, tuple(left)], np.int64)


def is_ear(points: np.ndarray, left: list[int], corners: tuple[int, int, int]) -> bool:
    """Whether the triangle turns left and holds no other corner of the polygon that is left."""
    a, b, c = points[list(corners)]
    if turn(a, b, c) <= 0:
        return False
    others = points[[corner for corner in left if corner not in corners]]
    inside = (turn(a, b, others) >= 0) & (turn(b, c, others) >= 0) & (turn(c, a, others) >= 0)
    same = (others[:, None] == points[list(corners)]).all(axis=2).any(axis=1)
    return not (inside & ~same).any()


def turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Twice the signed area of triangles a, b, c, each (2,) or (n, 2)."""
    return (b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0])
