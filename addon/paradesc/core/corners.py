"""Finds corners: vertices whose Harris response no vertex around exceeds. Never imports bpy."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..bridge import ProgressFunction, origin, unusable
from .polygons import listed
from .threads import go_on

THRESHOLD = 0.05  # of the largest response
ATTRIBUTE = "harris_corner"
WINDOW_REACH = 2.0  # in sigma; how far the response looks: nearer corners cannot be told apart
# The sizes of one step, which is short so that it can be cancelled: vertices or triangles, places, places of rings.
PART, GROUP, RING = 1 << 16, 1 << 14, 1 << 14


@dataclass
class Corners:
    """The corners of one mesh, the strongest first."""

    vertices: np.ndarray  # (corner_count,) int32, one of each corner's vertices
    painted: np.ndarray  # (vertex_count,) float32: 1 at every vertex that lies at a corner, else 0


def check_threshold(threshold: float) -> None:
    """Refuses a threshold that is not a share of the largest response; the library, which does not know it, cannot."""
    if not 0 < threshold <= 1:
        raise unusable(f"The corner threshold is {threshold:g}; it must be above 0 and at most 1.")


def find_corners(
    positions: np.ndarray,
    triangles: np.ndarray,
    response: np.ndarray,
    radius: float,
    threshold: float = THRESHOLD,
    progress: ProgressFunction | None = None,
) -> Corners:
    """Vertices whose response is above threshold times the largest, and that no other exceeds within the radius.

    Within means in the part of the mesh that edges in the ball connect to them. Among equal vertices the first counts.
    Even a surface without corners has a largest response: compare responses if that matters. positions (n, 3),
    triangles (m, 3), response (n,) with NaN if there is none. Cancelled as a bake is, between short steps.
    """

    def step() -> None:
        go_on(progress, "corners", 1.0)

    step()
    order, begin, point = places(positions)
    first = order[begin]
    value = np.maximum.reduceat(np.where(np.isfinite(response), response, -np.inf).astype(np.float64)[order], begin)
    # A place is higher than another if its value is larger, or if it is equal and its vertex comes first.
    rank = np.empty(len(first), np.int64)
    rank[np.lexsort((-first, value))] = np.arange(len(first))
    of_places = point[triangles]
    step()
    highest = value.max(initial=-np.inf)
    peak = (value > threshold * highest) & (value > 0)
    leave_peaks(peak, rank, of_places, step)
    candidates = np.flatnonzero(peak)
    where = positions[first].astype(np.float64)
    kept = candidates[~has_higher(candidates, rank, around(of_places, len(first), step), where, radius, step)]
    kept = kept[np.argsort(-rank[kept])]
    painted = np.zeros(len(value), np.float32)
    painted[kept] = 1.0
    return Corners(first[kept].astype(np.int32), painted[point])


def places(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n,) sorted so that those at one place follow each other, where each place begins, the place of each."""
    keys = origin.place_keys(origin.columns_of(positions))
    order = np.argsort(keys, kind="stable")
    new = np.ones(len(order), bool)
    new[1:] = np.diff(keys[order]) != 0
    point = np.empty(len(order), np.int64)
    point[order] = np.cumsum(new) - 1
    return order, np.flatnonzero(new), point


def leave_peaks(peak: np.ndarray, rank: np.ndarray, triangles: np.ndarray, step: Callable[[], None]) -> None:
    """Unmarks in peak (place_count,) bool every place that has a higher neighbor."""
    for start in range(0, len(triangles), PART):
        part = triangles[start : start + PART]
        for corner in range(3):
            ones, others = part[:, corner], part[:, corner - 1]
            peak[np.where(rank[ones] > rank[others], others, ones)[ones != others]] = False
        step()


@dataclass
class Around:
    """The corners of triangles by place: those of place i are corners[begin[i] : begin[i + 1]]."""

    begin: np.ndarray  # (place_count + 1,)
    corners: np.ndarray  # (corner_count,) numbers of corners
    of_corners: np.ndarray  # (corner_count,) the place of each corner

    def neighbors(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The neighbors of places, some of them twice, as two arrays: the row in places, and the neighbor."""
        counts = self.begin[places + 1] - self.begin[places]
        rows = np.repeat(np.arange(len(places)), counts)
        corners = self.corners[listed(self.begin[places], counts)]
        own = corners % 3
        ahead, behind = corners - own + (own + 1) % 3, corners - own + (own + 2) % 3
        return np.concatenate([rows, rows]), self.of_corners[np.concatenate([ahead, behind])]


def around(triangles: np.ndarray, count: int, step: Callable[[], None]) -> Around:
    """Sorts the corners of triangles (m, 3) by place, first into groups of GROUP places and then within each."""
    of_corners = triangles.reshape(-1)
    begin = np.concatenate([[0], np.cumsum(np.bincount(of_corners, minlength=count))])
    free = begin[:-1:GROUP].copy()  # of each group
    corners = np.empty(len(of_corners), np.int64)
    for start in range(0, len(of_corners), PART):
        group = (of_corners[start : start + PART] // GROUP).astype(np.uint16)
        order, counts = np.argsort(group, kind="stable"), np.bincount(group, minlength=len(free))
        corners[listed(free, counts)] = start + order
        free += counts
        step()
    for place in range(0, count, GROUP):
        own = corners[begin[place] : begin[min(place + GROUP, count)]]
        own[:] = own[np.argsort((of_corners[own] - place).astype(np.uint16), kind="stable")]
        step()
    return Around(begin, corners, of_corners)


def has_higher(
    candidates: np.ndarray,
    rank: np.ndarray,
    beside: Around,
    where: np.ndarray,
    radius: float,
    step: Callable[[], None],
) -> np.ndarray:
    """(candidates,) bool: whether a higher place can be reached by edges inside the ball around the candidate.

    Places (n,) are reached ring by ring, for many candidates at once; a neighbor of a ring is in it or beside it.
    """
    count = len(where)
    higher = np.zeros(len(candidates), bool)
    start = np.arange(len(candidates)) * count + candidates
    waiting = [(start, start[:0])] if len(start) else []  # keys of a ring, candidate and place, and of the one before
    while waiting:
        ring, before = waiting.pop()
        rows, reached = np.divmod(ring, count)
        cut = rows[len(rows) // 2] * count  # between candidates
        if len(ring) > RING and cut > ring[0]:
            waiting += [(ring[ring < cut], before[before < cut]), (ring[ring >= cut], before[before >= cut])]
            continue
        back, found = beside.neighbors(reached)
        keys = np.unique(rows[back] * count + found)
        rows, found = np.divmod(keys, count)
        near = np.linalg.norm(where[found] - where[candidates[rows]], axis=1) <= radius
        higher[rows[near & (rank[found] > rank[candidates[rows]])]] = True
        fresh = keys[near & ~higher[rows]]
        fresh = np.setdiff1d(fresh, np.concatenate([ring, before]), assume_unique=True)
        waiting += [(fresh, ring)] if len(fresh) else []
        step()
    return higher
