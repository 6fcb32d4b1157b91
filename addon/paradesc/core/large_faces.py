"""Tells whether faces are too large for values at vertices to show a mask on them. Never imports bpy.

A wall between two edges has both edges' values at its corners, so that all of it looks like an edge.
"""

import numpy as np

from ..bridge import MeshArrays
from . import advice

# A vertex counts as one on an edge from this angle between two of its faces on, so that those of a rounded edge do too.
BEND = np.radians(10.0)
# A face is large if its longest edge is so many times the radius of the mesh's masks.
LARGE = 4.0
# From this share of the area on, large faces with such corners are what one sees: a fort has 0.3, a beveled crate 1, a
# head of 500 vertices 0.12, and a cartoon fox 0.01.
TOO_MUCH = 0.2


def are_too_large(positions: np.ndarray, triangles: np.ndarray) -> bool:
    """Returns whether a mask of (n, 3) triangles belongs into an image, and not to the (vertex_count, 3) positions."""
    return share(positions, triangles) > TOO_MUCH


def share(positions: np.ndarray, triangles: np.ndarray) -> float:
    """The share of the area in large triangles whose corners all lie on edges; vertices at one place count as one."""
    points, place = np.unique(positions, axis=0, return_inverse=True)
    triangles = place.reshape(-1)[triangles].astype(np.int32)
    areas = advice.double_areas(points[triangles])
    triangles, areas = triangles[areas > 0], areas[areas > 0]
    if not len(triangles) or not np.isfinite(points).all():
        return 0.0
    corners = np.arange(triangles.size, dtype=np.int32).reshape(-1, 3)
    arrays = MeshArrays(points, triangles.reshape(-1), corners)
    radius, _, _ = advice.fitted_radius(arrays, ("cavity",), "medium")
    lengths = np.linalg.norm(points[triangles] - points[np.roll(triangles, 1, axis=1)], axis=2)
    large = lengths.max(axis=1) > LARGE * radius
    on_edge = np.zeros(len(points), bool)
    on_edge[bent_edges(points, triangles)] = True
    return float(areas[large & on_edge[triangles].all(axis=1)].sum() / areas.sum())


def bent_edges(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(k, 2) vertices of the edges at which two of (n, 3) triangles with an area bend by BEND or more."""
    corners = positions[triangles].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    face = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, face = edges[order], face[order]
    shared = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    alike = (normals[face[shared]] * normals[face[shared + 1]]).sum(axis=1)
    return edges[shared[alike < np.cos(BEND)]]
