"""Finds the tangent space of normal maps at the corners of triangles (Mikkelsen 2008, MikkTSpace). Never imports bpy.

Corners belong together if they have position, normal and UV in common, their triangles are connected around them, and
the UV map lies the same way round in these. A corner's tangent is that of its triangles, weighted by their angles.
"""

import numpy as np

from ..bridge import MeshArrays

# Lengths and areas below this count as zero. Only triangles without area have such small ones.
NOTHING = 1e-30


def corner_tangents(arrays: MeshArrays) -> np.ndarray:
    """(corner_count, 4) float32 unit tangents, each with the sign of the bitangent, of a mesh with UVs and normals."""
    used, quads = divided(arrays)
    points = arrays.positions.astype(np.float64)[arrays.corner_vertices[used]]
    uvs, normals = arrays.corner_uvs.astype(np.float64)[used], unit(arrays.corner_normals.astype(np.float64))[used]
    along, areas = along_u(points, uvs)
    sound = (np.abs(areas) > NOTHING) & (np.linalg.norm(along, axis=1) > NOTHING)
    signs = of_quads(np.where(areas > 0, 1.0, -1.0), np.abs(areas), sound, quads)
    rows = np.concatenate([points, normals, uvs], axis=2).reshape(-1, 8) + 0.0  # without a zero that is negative
    places = np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1, 3)  # equal rows have equal numbers
    groups = connected(places, signs, sound)
    flat = unit(along[:, None] - normals * (normals * along[:, None]).sum(axis=2, keepdims=True))
    weighted = (angles(points, normals) * sound[:, None])[:, :, None] * flat
    tangents = np.empty((len(used), 3, 4))
    tangents[:, :, :3] = unit(summed(groups.ravel(), weighted.reshape(-1, 3), used.size))[groups]
    tangents[:, :, 3] = signs[:, None]
    tangents = borrowed(tangents, places, sound).reshape(-1, 4)
    found = np.zeros((len(arrays.corner_vertices), 4), np.float32)
    found[:, :3] = unit(summed(used.ravel(), tangents[:, :3], len(found)))
    found[used.ravel(), 3] = tangents[:, 3]
    return found


def divided(arrays: MeshArrays) -> tuple[np.ndarray, np.ndarray]:
    """(m, 3) corners of triangles, of quads by the shorter diagonal in the UV map; (k,) each quad's first one."""
    triangles = arrays.triangle_corners.astype(np.int64)
    uses = np.bincount(triangles.ravel(), minlength=len(arrays.corner_vertices))
    first = halves_of(triangles, uses)
    corners = np.minimum(triangles[first], triangles[first + 1]).min(axis=1)[:, None] + np.arange(4)
    uvs, points = arrays.corner_uvs[corners], arrays.positions[arrays.corner_vertices[corners]]
    one, other = (squared(uvs[:, k] - uvs[:, k + 2]) for k in (0, 1))
    near, far = (squared(points[:, k] - points[:, k + 2]) for k in (0, 1))
    across = (one < other) | ((one == other) & (near <= far))
    triangles[first] = np.where(across[:, None], corners[:, [0, 1, 2]], corners[:, [0, 1, 3]])
    triangles[first + 1] = np.where(across[:, None], corners[:, [0, 2, 3]], corners[:, [1, 2, 3]])
    return triangles, first


def halves_of(triangles: np.ndarray, uses: np.ndarray) -> np.ndarray:
    """(k,) the first of each pair of successive triangles that form a quad; uses: the triangles at each corner."""
    counts = uses[triangles]
    half = (counts.max(axis=1) == 2) & (counts.sum(axis=1) == 1 + 2 + 2)
    common = (triangles[:-1, :, None] == triangles[1:, None, :]).sum(axis=(1, 2)) == 2
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    span = np.maximum(high[1:], high[:-1]) - np.minimum(low[1:], low[:-1])
    return np.flatnonzero(half[1:] & half[:-1] & common & (span == 3))


def squared(ways: np.ndarray) -> np.ndarray:
    """(n,) squared lengths."""
    return (ways.astype(np.float64) ** 2).sum(axis=1)


def of_quads(signs: np.ndarray, areas: np.ndarray, sound: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """The signs of triangles, where both halves of a quad get the sign of the half that is larger in the UV map."""
    found, second = signs.copy(), quads + 1
    takes_first = ~sound[second] | (areas[quads] >= areas[second])
    found[quads] = found[second] = np.where(takes_first, signs[quads], signs[second])
    return found


def summed(groups: np.ndarray, vectors: np.ndarray, count: int) -> np.ndarray:
    """(count, 3) the sum of the vectors (n, 3) of each group."""
    return np.column_stack([np.bincount(groups, vectors[:, axis], count) for axis in range(3)])


def along_u(points: np.ndarray, uvs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m, 3) directions in which U grows, and (m,) twice the signed areas in the UV map."""
    first, second = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    one, other = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    areas = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    along = np.where(areas > 0, 1.0, -1.0)[:, None] * (other[:, 1:] * first - one[:, 1:] * second)
    return along, areas


def unit(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors (…, 3); zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > NOTHING, lengths, 1.0)


def angles(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(m, 3) angles of triangles (m, 3, 3) at their corners, as the planes across the corners' normals show them."""
    ahead, behind = np.roll(points, -1, axis=1) - points, np.roll(points, 1, axis=1) - points
    ahead, behind = (unit(way - normals * (normals * way).sum(axis=2, keepdims=True)) for way in (ahead, behind))
    return np.arccos(np.clip((ahead * behind).sum(axis=2), -1.0, 1.0))


def connected(places: np.ndarray, signs: np.ndarray, sound: np.ndarray) -> np.ndarray:
    """(m, 3) numbers of the groups of corners: those at one place whose triangles share an edge that ends there."""
    starts, ends = places, np.roll(places, -1, axis=1)
    count = int(places.max(initial=0)) + 1
    kept = np.repeat(sound, 3)
    keys, back = (starts * count + ends).ravel(), (ends * count + starts).ravel()
    edges = np.flatnonzero(kept)
    order = edges[np.argsort(keys[edges], kind="stable")]
    place = np.minimum(np.searchsorted(keys[order], back[edges]), max(len(order) - 1, 0))
    partner = order[place] if len(order) else edges
    fits = (keys[partner] == back[edges]) & (signs[partner // 3] == signs[edges // 3])
    one, other = edges[fits], partner[fits]
    # An edge begins at its own corner and ends at the next one; its partner runs the other way.
    following, next_corner = one // 3 * 3 + (one + 1) % 3, other // 3 * 3 + (other + 1) % 3
    return joined(places.size, np.concatenate([one, following]), np.concatenate([next_corner, other])).reshape(-1, 3)


def joined(count: int, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(count,) the smallest number in each one's part of a graph, in which first and second are connected."""
    labels = np.arange(count)
    while True:
        least = np.minimum(labels[first], labels[second])
        before = labels.copy()
        np.minimum.at(labels, labels[first], least)
        np.minimum.at(labels, labels[second], least)
        labels = labels[labels]
        if np.array_equal(labels, before):
            return labels


def borrowed(tangents: np.ndarray, places: np.ndarray, sound: np.ndarray) -> np.ndarray:
    """The tangents (m, 3, 4), where triangles without area in the UV map take those of neighbors at the same places."""
    if sound.all():
        return tangents
    of_place = np.tile(np.array([1.0, 0.0, 0.0, -1.0]), (int(places.max(initial=0)) + 1, 1))
    of_place[places[sound].ravel()] = tangents[sound].reshape(-1, 4)
    return np.where(sound[:, None, None], tangents, of_place[places])
