"""Finds corners: vertices whose Harris response no vertex around exceeds. Never imports bpy."""

from dataclasses import dataclass

import numpy as np

THRESHOLD = 0.05  # of the largest response
ATTRIBUTE = "harris_corner"
WINDOW_REACH = 2.0  # in sigma; how far the response looks: nearer corners cannot be told apart


@dataclass
class Corners:
    """The corners of one mesh, the strongest first."""

    vertices: np.ndarray  # (corner_count,) int32, one of each corner's vertices
    painted: np.ndarray  # (vertex_count,) float32: 1 at every vertex that lies at a corner, else 0


def find_corners(
    positions: np.ndarray, triangles: np.ndarray, response: np.ndarray, radius: float, threshold: float = THRESHOLD
) -> Corners:
    """Vertices whose response is above threshold times the largest, and that no other exceeds within the radius.

    Within means in the part of the mesh that edges in the ball connect to them. Of equal vertices the first counts.
    Even a surface without corners has a largest response: compare responses if that matters. positions (n, 3),
    triangles (m, 3), response (n,) with NaN if there is none.
    """
    _, first, point = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    point = point.reshape(-1)
    places = positions[first].astype(np.float64)
    value = np.full(len(first), -np.inf)
    np.maximum.at(value, point, np.where(np.isfinite(response), response, -np.inf))
    rank = np.empty(len(value), np.int64)
    rank[np.lexsort((first, -value))] = np.arange(len(value))  # 0: the highest
    begin, neighbors = adjacency(point[triangles], len(value))
    highest = value.max(initial=-np.inf)
    candidates = np.flatnonzero((value > threshold * highest) & (value > 0))
    candidates = candidates[is_peak(candidates, rank, begin, neighbors)]
    kept = candidates[~has_higher(candidates, rank, begin, neighbors, places, radius)]
    kept = kept[np.argsort(rank[kept])]
    painted = np.zeros(len(value), np.float32)
    painted[kept] = 1.0
    return Corners(first[kept].astype(np.int32), painted[point])


def adjacency(triangles: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The neighbors of vertex i are neighbors[begin[i] : begin[i + 1]]."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    ends = ends[ends[:, 0] != ends[:, 1]]
    keys = np.unique(np.concatenate([ends[:, 0] * count + ends[:, 1], ends[:, 1] * count + ends[:, 0]]))
    begin = np.searchsorted(keys, np.arange(count + 1) * count)
    return begin, keys % count


def spread_out(vertices: np.ndarray, begin: np.ndarray, neighbors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All neighbors of all vertices, and to which row of vertices each belongs."""
    counts = begin[vertices + 1] - begin[vertices]
    rows = np.repeat(np.arange(len(vertices)), counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return rows, neighbors[begin[vertices][rows] + within]


def is_peak(candidates: np.ndarray, rank: np.ndarray, begin: np.ndarray, neighbors: np.ndarray) -> np.ndarray:
    """(candidates,) bool: no neighbor ranks higher."""
    rows, beside = spread_out(candidates, begin, neighbors)
    peak = np.ones(len(candidates), bool)
    peak[rows[rank[beside] < rank[candidates[rows]]]] = False
    return peak


def has_higher(
    candidates: np.ndarray,
    rank: np.ndarray,
    begin: np.ndarray,
    neighbors: np.ndarray,
    places: np.ndarray,
    radius: float,
) -> np.ndarray:
    """(candidates,) bool: a vertex that ranks higher is reached by edges that stay in the ball around the candidate."""
    count = len(places)
    higher = np.zeros(len(candidates), bool)
    rows, reached = np.arange(len(candidates)), candidates
    seen = rows * count + reached
    while len(rows):
        back, beside = spread_out(reached, begin, neighbors)
        keys = np.unique(rows[back] * count + beside)
        rows, beside = keys // count, keys % count
        near = np.linalg.norm(places[beside] - places[candidates[rows]], axis=1) <= radius
        higher[rows[near & (rank[beside] < rank[candidates[rows]])]] = True
        fresh = near & ~higher[rows] & ~np.isin(keys, seen, assume_unique=True)
        rows, reached = rows[fresh], beside[fresh]
        seen = np.concatenate([seen, keys[fresh]])
    return higher


def listed(corners: Corners, positions: np.ndarray, response: np.ndarray) -> list[dict[str, object]]:
    """Plain numbers for a file, one row for each corner: vertex, position, response."""
    return [
        {"vertex": int(vertex), "position": [float(x) for x in positions[vertex]], "response": float(response[vertex])}
        for vertex in corners.vertices
    ]
