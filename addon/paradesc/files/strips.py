"""Turns strips and fans of triangles into single triangles, each wound as its strip. Never imports bpy."""

import numpy as np

from ..core.polygons import Polygons


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
