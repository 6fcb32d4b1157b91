"""The paper's object-space method: mean curvature by sums over the vertices within r, each weighted by its own area.

Fig. 2 shows that this method fails on coarse meshes. The project's reference is another one, which integrates over the
triangles.
"""

import numpy as np
from meshes import area_vectors, edges_of, max_normals

ROWS = 256  # vertices at a time, which bounds the memory


def vertex_areas(points, triangles):
    """(n,) barycentric area: a third of each face at the vertex."""
    share = np.linalg.norm(area_vectors(points, triangles), axis=1) / 6
    return sum(np.bincount(triangles[:, corner], share, len(points)) for corner in range(3))


def mean_curvature(arrays, radius, normals=None):
    """(n,) H by (6, 7, 8) over the vertices that are connected to p within the ball, and their mean number.

    With V_o = (2πr³/3)(1 − Σ w ρ a / Σ w ρ) equation (8) is H = −(8 / 3r) Σ w n·d / Σ w ρ.
    """
    points, triangles = arrays.positions.astype(np.float64), arrays.triangle_vertices
    normals = max_normals(points, triangles) if normals is None else normals
    areas = vertex_areas(points, triangles)
    edges, _ = edges_of(triangles)
    edges = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0)
    starts = np.searchsorted(edges[:, 0], np.arange(len(points)))
    result, found = np.empty(len(points)), 0
    for first in range(0, len(points), ROWS):
        chosen = np.arange(first, min(first + ROWS, len(points)))
        offset = points - points[chosen, None]
        distance = np.linalg.norm(offset, axis=2)
        inside = connected(distance <= radius, chosen, edges[:, 1], starts)
        inside[np.arange(len(chosen)), chosen] = False
        weight = inside * areas
        height = (offset * normals[chosen, None]).sum(2)
        with np.errstate(divide="ignore", invalid="ignore"):
            result[chosen] = -8 / (3 * radius) * (weight * height).sum(1) / (weight * distance).sum(1)
        found += inside.sum()
    return result, found / len(points)


def connected(ball, chosen, neighbors, starts):
    """(rows, n) the part of each ball (rows, n) that edges within the ball connect to its center."""
    reached = np.zeros_like(ball)
    reached[np.arange(len(chosen)), chosen] = True
    while True:
        grown = ball & (reached | np.logical_or.reduceat(reached[:, neighbors], starts, axis=1))
        if np.array_equal(grown, reached):
            return reached
        reached = grown
