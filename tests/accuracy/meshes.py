"""Makes meshes for the report: a Wavefront reader, charts by projection, Loop's subdivision, noise. Plain numpy."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from surfaces import as_arrays

ROOT = Path(__file__).resolve().parents[2]
MESHES = ROOT.parent / "shared" / "meshes"
GUTTER = 3.0 / 1024  # around each chart, in UV units


def find(name):
    """The file of a real mesh, or None if it is not there."""
    path = MESHES / f"{name}.obj"
    return read_obj(path) if path.is_file() else None


def read_obj(path):
    """Reads positions, triangles (polygons as fans) and UVs, if every corner has one."""
    points, uvs, corners, corner_uvs = [], [], [], []
    with path.open() as lines:
        for line in lines:
            words = line.split()
            if not words:
                continue
            if words[0] == "v":
                points.append(words[1:4])
            elif words[0] == "vt":
                uvs.append(words[1:3])
            elif words[0] == "f":
                places = [(word + "//").split("/")[:2] for word in words[1:]]
                for i in range(1, len(places) - 1):
                    for vertex, uv in (places[0], places[i], places[i + 1]):
                        corners.append(int(vertex))
                        corner_uvs.append(int(uv) if uv else 0)
    corners, corner_uvs = np.array(corners), np.array(corner_uvs)
    triangles = np.where(corners < 0, corners + len(points), corners - 1).reshape(-1, 3)
    points = np.array(points, np.float64)
    used, triangles = np.unique(triangles, return_inverse=True)  # Blender also leaves out vertices without a face
    points, triangles = points[used], triangles.reshape(-1, 3)
    if not uvs or (corner_uvs == 0).any():
        return as_arrays(points, triangles)
    places = np.array(uvs, np.float64)[np.where(corner_uvs < 0, corner_uvs + len(uvs), corner_uvs - 1)]
    return as_arrays(points, triangles, places.reshape(-1, 3, 2))


def with_charts(name):
    """A real mesh and how it got its UV map; (None, sentence) if it is absent or cannot be unwrapped."""
    arrays = find(name)
    if arrays is None:
        return None, f"{name}.obj is not in shared/meshes beside the checkout."
    if arrays.corner_uvs is not None:
        return arrays, "its own"
    return project_charts(arrays, cells=6), "projected charts"


def area_vectors(points, triangles):
    """(t, 3) normals whose lengths are twice the triangles' areas."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def max_normals(points, triangles):
    """(n, 3) unit normals of the vertices by Max's weights."""
    normals = np.zeros_like(points)
    for i in range(3):
        tip = points[triangles[:, i]]
        u, v = points[triangles[:, (i + 1) % 3]] - tip, points[triangles[:, (i + 2) % 3]] - tip
        weight = (u * u).sum(1) * (v * v).sum(1)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.nan_to_num(np.cross(u, v) / weight[:, None])
        for axis in range(3):
            normals[:, axis] += np.bincount(triangles[:, i], part[:, axis], len(points))
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def edges_of(triangles):
    """Directed edges by triangle: (3 t, 2) vertices and (3 t,) triangles."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return edges, np.tile(np.arange(len(triangles)), 3)


def euler_characteristic(triangles):
    """V − E + F, counting the vertices that have a face."""
    edges, _ = edges_of(triangles)
    return len(np.unique(triangles)) - len(np.unique(np.sort(edges, axis=1), axis=0)) + len(triangles)


def neighbor_pairs(triangles):
    """(k, 2) triangles that share an edge."""
    edges, owner = edges_of(triangles)
    edges = np.sort(edges, axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    same = (edges[order[1:]] == edges[order[:-1]]).all(1)
    return np.stack([owner[order[:-1][same]], owner[order[1:][same]]], axis=1)


def components(count, pairs):
    """(count,) number of the connected component of each item."""
    label = np.arange(count)
    while True:
        before = label.copy()
        lowest = np.minimum(label[pairs[:, 0]], label[pairs[:, 1]])
        for side in range(2):
            np.minimum.at(label, label[pairs[:, side]], lowest)
            np.minimum.at(label, pairs[:, side], lowest)
        label = label[label]
        if np.array_equal(label, before):
            return np.unique(label, return_inverse=True)[1]


def project_charts(arrays, cells):
    """Gives the mesh charts: connected faces that look along one axis in a block of cells³, projected to a plane."""
    points, triangles = arrays.positions.astype(np.float64), arrays.triangle_vertices
    pairs = neighbor_pairs(triangles)
    facing = area_vectors(points, triangles)
    for _ in range(12):  # smoothing, so that a scan's noise does not tear charts apart
        total = facing.copy()
        for axis in range(3):
            total[:, axis] += np.bincount(pairs[:, 0], facing[pairs[:, 1], axis], len(facing))
            total[:, axis] += np.bincount(pairs[:, 1], facing[pairs[:, 0], axis], len(facing))
        facing = total / 4
    axis = np.abs(facing).argmax(1)
    sign = np.take_along_axis(facing, axis[:, None], 1)[:, 0] > 0
    low = points.min(0)
    block = np.minimum((points[triangles].mean(1) - low) / np.ptp(points) * cells, cells - 1e-9).astype(int)
    kind = ((axis * 2 + sign) * cells + block[:, 0]) * cells**2 + block[:, 1] * cells + block[:, 2]
    chart = components(len(triangles), pairs[kind[pairs[:, 0]] == kind[pairs[:, 1]]])
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners = points[triangles]
    flat = np.stack([np.take_along_axis(corners, way[:, None, None], 2)[..., 0] for way in (u, v)], -1)
    flat[~sign, :, 0] *= -1
    return replace(arrays, corner_uvs=pack(flat, chart).reshape(-1, 2).astype(np.float32))


def pack(flat, chart):
    """(t, 3, 2) UVs in the unit square: charts on shelves, all at one scale."""
    count = chart.max() + 1
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    for corner in range(3):
        np.minimum.at(low, chart, flat[:, corner])
        np.maximum.at(high, chart, flat[:, corner])
    size = high - low
    order = np.argsort(-size[:, 1])
    smallest, largest = 0.0, 1.0 / size.max()
    for _ in range(20):
        scale = (smallest + largest) / 2
        smallest, largest = (scale, largest) if shelves(size * scale, order) is not None else (smallest, scale)
    place = shelves(size * smallest, order)
    return (flat - low[chart][:, None]) * smallest + place[chart][:, None]


def shelves(size, order):
    """(count, 2) places of boxes in the unit square, or None if they do not fit."""
    place = np.empty_like(size)
    x = y = GUTTER
    height = 0.0
    for box in order:
        width = size[box, 0] + GUTTER
        if x + width > 1:
            x, y, height = GUTTER, y + height, 0.0
        if width + GUTTER > 1 or y + size[box, 1] + GUTTER > 1:
            return None
        place[box] = x, y
        x += width
        height = max(height, size[box, 1] + GUTTER)
    return place


def loop_subdivide(arrays, times):
    """Loop's subdivision of a manifold mesh; old vertices keep their indices. UVs are halved linearly."""
    for _ in range(times):
        arrays = loop_once(arrays)
    return arrays


def loop_once(arrays):
    points, triangles = arrays.positions.astype(np.float64), arrays.triangle_vertices
    edges, owner = edges_of(triangles)
    unique, edge, uses = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    opposite = triangles[owner, (np.repeat(np.arange(3), len(triangles)) + 2) % 3]
    across = np.stack([np.bincount(edge, points[opposite, axis], len(unique)) for axis in range(3)], 1)
    middle = points[unique].sum(1) / 2
    inner = uses == 2
    fresh = np.where(inner[:, None], 0.75 * middle + across / 8, middle)
    moved = loop_vertices(points, unique, inner)
    place = edge.reshape(3, -1).T + len(points)  # of each triangle's edges
    a, b, c = triangles.T
    ab, bc, ca = place.T
    parts = np.stack([np.stack(row, 1) for row in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))], 1)
    uvs = None
    if arrays.corner_uvs is not None:
        p, q, r = np.moveaxis(arrays.corner_uvs[arrays.triangle_corners].astype(np.float64), 1, 0)
        pq, qr, rp = (p + q) / 2, (q + r) / 2, (r + p) / 2
        rows = ((p, pq, rp), (pq, q, qr), (rp, qr, r), (pq, qr, rp))
        uvs = np.stack([np.stack(row, 1) for row in rows], 1).reshape(-1, 3, 2)
    return as_arrays(np.concatenate([moved, fresh]), parts.reshape(-1, 3), uvs)


def loop_vertices(points, unique, inner):
    """(n, 3) new places of the old vertices: Loop's weights inside, the cubic spline's along boundaries."""

    def gathered(chosen):
        both = np.concatenate([chosen, chosen[:, ::-1]])
        total = np.stack([np.bincount(both[:, 0], points[both[:, 1], axis], len(points)) for axis in range(3)], 1)
        return total, np.bincount(both[:, 0], minlength=len(points))

    total, valence = gathered(unique)
    rim_total, rim = gathered(unique[~inner])
    valence = np.maximum(valence, 1)
    beta = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / valence)) ** 2) / valence
    smooth = (1 - valence * beta)[:, None] * points + beta[:, None] * total
    border = 0.75 * points + rim_total / 8
    return np.where((rim == 2)[:, None], border, np.where((rim == 0)[:, None], smooth, points))


def moved(arrays, points):
    """The same mesh with other positions (n, 3)."""
    return replace(arrays, positions=points.astype(np.float32))


def diagonal(arrays):
    """The diagonal of the bounding box."""
    return float(np.linalg.norm(np.ptp(arrays.positions, axis=0)))
