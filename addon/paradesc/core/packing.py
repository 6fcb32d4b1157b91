"""Moves the charts of a layout apart: each keeps its shape, and all get one scale and gutters. Never imports bpy."""

import numpy as np

# The gutter between charts as a fraction of the side: four texels of 1024.
GUTTER = 0.004
# With very many charts gutters get narrower: in a row of equal charts they take at most this share of the side.
LARGEST_GUTTER_SHARE = 0.25
# The number of times that the interval of the scale is halved.
SCALE_STEPS = 30


def pack(uvs: np.ndarray, corner_vertices: np.ndarray, sizes: np.ndarray, gutter: float = GUTTER) -> np.ndarray:
    """(corner_count, 2) float32 layout in the unit square, of faces with sizes corners each that lie in a row."""
    chart = charts(uvs, corner_vertices, sizes)
    order = np.argsort(chart, kind="stable")
    first = np.flatnonzero(np.append(True, np.diff(chart[order]) != 0))
    exact = uvs.astype(np.float64)
    low = np.minimum.reduceat(exact[order], first, axis=0)
    extent = np.maximum.reduceat(exact[order], first, axis=0) - low
    gutter = min(gutter, LARGEST_GUTTER_SHARE / np.sqrt(len(extent)))
    corner, scale = place(extent, gutter)
    return (corner[chart] + scale * (exact - low[chart])).astype(np.float32)


def charts(uvs: np.ndarray, corner_vertices: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(corner_count,) chart of each corner, from 0 on: faces that share a vertex at one place belong together."""
    order = np.lexsort((uvs[:, 1], uvs[:, 0], corner_vertices))
    new = np.append(True, (np.diff(corner_vertices[order]) != 0) | (np.diff(uvs[order], axis=0) != 0).any(axis=1))
    node = np.empty(len(uvs), np.int64)
    node[order] = np.cumsum(new) - 1
    node_starts, face_starts = np.flatnonzero(new), np.cumsum(sizes) - sizes
    label = np.arange(len(node_starts))
    while True:  # every node takes the least label around it, then that one's: distances double
        around = np.repeat(np.minimum.reduceat(label[node], face_starts), sizes)
        least = np.minimum.reduceat(around[order], node_starts)
        least = least[least]
        if np.array_equal(least, label):
            return np.unique(label, return_inverse=True)[1][node]
        label = least


def place(extent: np.ndarray, gutter: float) -> tuple[np.ndarray, float]:
    """The low corners (n, 2) of boxes (n, 2) in the unit square, and the largest scale found that fits them all."""
    order = np.argsort(-extent[:, 1], kind="stable")
    boxes = extent[order]
    fits, too_large = 0.0, 1.0 / max(extent.max(), np.finfo(float).tiny)
    for _ in range(SCALE_STEPS):
        middle = (fits + too_large) / 2
        if rows(boxes, middle, gutter) is None:
            too_large = middle
        else:
            fits = middle
    found = rows(boxes, fits, gutter)
    if found is None:  # not even gutters fit; cannot be while LARGEST_GUTTER_SHARE is below a half
        raise ValueError("The charts do not fit.")
    corners = np.empty_like(found)
    corners[order] = found
    return corners, fits


def rows(boxes: np.ndarray, scale: float, gutter: float) -> np.ndarray | None:
    """The low corners (n, 2) of boxes in rows; the highest boxes come first. None if they do not fit."""
    widths, heights = scale * boxes[:, 0] + gutter, scale * boxes[:, 1] + gutter
    if gutter + widths.max() > 1:
        return None
    ends = np.cumsum(widths)
    corners = np.empty_like(boxes)
    start, before, height = 0, 0.0, gutter
    while start < len(boxes):
        if height + heights[start] > 1:
            return None
        end = max(start + 1, int(np.searchsorted(ends, before + 1 - gutter, side="right")))
        corners[start:end, 0] = ends[start:end] - widths[start:end] - before + gutter
        corners[start:end, 1] = height
        height += heights[start]
        start, before = end, ends[end - 1]
    return corners
