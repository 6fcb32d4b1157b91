"""Suggests a radius and a buffer that suit a mesh, by its report and its UV map. Never imports bpy."""

from collections.abc import Collection

import numpy as np

from .. import bridge

# A radius of this many mean edges sees the surface and not its facets; a larger share of the diagonal is no longer
# a neighborhood.
RADIUS_IN_EDGES = 2.0
LARGEST_RADIUS = 0.25
# A mask resolves the finest detail at a radius of one and a half mean edges. On dense meshes that is half a percent of
# the diagonal; on coarse meshes, most of the surface bends within more than four percent. Images resolve detail
# whatever the size of the faces.
MASK_RADIUS_IN_EDGES, LEAST_MASK_RADIUS, LARGEST_MASK_RADIUS, LARGEST_IN_IMAGES = 1.5, 0.005, 0.04, 0.015
# Factors of that radius: for broader and finer masks, and for openness, which looks further around. At a radius below
# the mean edge values show facets.
SIZES = {"fine": 0.6, "medium": 1.0, "broad": 2.5}
MASKS = {"cavity": 1.0, "convexity": 1.0, "ambient_openness": 4.0}
# So many triangles suffice to estimate the mean edge.
ENOUGH_TRIANGLES = 100_000
USUAL_RADIUS = bridge.Options().radius
LEAST_TEXELS = 4.0
BUFFERS = (256, 512, 1024, 2048, 4096, 8192)
# The share of the UV square that our own unwrap fills, roughly.
UNWRAPPED_SHARE = 0.6
# Charts that the UV map stretches more than this are scaled back by the library.
LARGEST_STRETCH = 2.0**1.5


def texels_per_length(arrays: bridge.MeshArrays) -> float:
    """The median length of a unit of the surface in the UV square, where it is shortest; estimated without a map."""
    corners = arrays.positions[arrays.triangle_vertices].astype(np.float64)
    area = double_areas(corners)
    if arrays.corner_uvs is None:
        total = float(area.sum()) / 2
        return float(np.sqrt(UNWRAPPED_SHARE / total)) if total > 0 else 0.0
    uvs = arrays.corner_uvs[arrays.triangle_corners].astype(np.float64)
    in_map = double_areas(np.concatenate([uvs, np.zeros((*uvs.shape[:2], 1))], axis=2))
    sound = (area > 0) & (in_map > 0)
    if not sound.any():
        return 0.0
    stretch = np.minimum(stretches(corners[sound], uvs[sound]), LARGEST_STRETCH)
    return float(np.median(np.sqrt(in_map[sound] / area[sound] / stretch)))


def stretches(corners: np.ndarray, uvs: np.ndarray) -> np.ndarray:
    """(n,) ratio of the larger to the smaller principal stretch of (n, 3, 3) triangles in (n, 3, 2) UVs."""
    (e1, e2), (d1, d2) = ((v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]) for v in (corners, uvs))
    along_u, along_v = e1 * d2[:, 1:] - e2 * d1[:, 1:], e2 * d1[:, :1] - e1 * d2[:, :1]
    area = np.linalg.norm(np.cross(along_u, along_v), axis=1)
    half = (along_u**2 + along_v**2).sum(axis=1) / np.maximum(2 * area, np.finfo(np.float64).tiny)
    return half + np.sqrt(np.maximum(half**2 - 1, 0))


def mean_edge_and_diagonal(arrays: bridge.MeshArrays, triangles: np.ndarray | None = None) -> tuple[float, float]:
    """The mean edge of the triangles, and the diagonal of their box; triangles: (n, 3) vertices, if not all."""
    corners = arrays.positions[arrays.triangle_vertices if triangles is None else triangles].astype(np.float64)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return float(edges.mean()), float(np.linalg.norm(corners.max(axis=(0, 1)) - corners.min(axis=(0, 1))))


def double_areas(corners: np.ndarray) -> np.ndarray:
    """(n,) float64 twice the areas of (n, 3, 3) triangles."""
    corners = corners.astype(np.float64)
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def areas_of_vertices(arrays: bridge.MeshArrays) -> np.ndarray:
    """(vertex_count,) float64: a third of the areas of the triangles at each vertex."""
    corners = arrays.triangle_vertices
    areas = np.repeat(double_areas(arrays.positions[corners]) / 6, 3)
    return np.bincount(corners.reshape(-1), weights=areas, minlength=len(arrays.positions))


def fitting_radius(mean_edge: float, diagonal: float) -> float:
    """A radius that sees the surface, as a share of the diagonal: the usual one unless triangles are large."""
    return float(f"{min(max(USUAL_RADIUS, RADIUS_IN_EDGES * mean_edge / diagonal), LARGEST_RADIUS):.3g}")


def edge_and_diagonal(arrays: bridge.MeshArrays) -> tuple[float, float]:
    """The mean edge of a mesh that a radius can be fitted to, by enough of its triangles, and the diagonal."""
    every = arrays.triangle_vertices
    if not len(every) or not np.isfinite(arrays.positions[every]).all():
        raise bridge.InputError("The mesh has no faces to fit the radius to, or a position that is not a number.")
    edge, diagonal = mean_edge_and_diagonal(arrays, every[:: 1 + len(every) // ENOUGH_TRIANGLES])
    if not diagonal > 0:
        raise bridge.InputError("The mesh is a single point, so there is no radius that fits it.")
    return edge, diagonal


def fitted_radius(
    arrays: bridge.MeshArrays, descriptors: Collection[str], size: str, largest: float = LARGEST_MASK_RADIUS
) -> tuple[float, float, float]:
    """The radius for a mesh, its descriptors and a size of SIZES; the mean edge; the diagonal: all as lengths.

    Small radii are for masks alone. With other descriptors it is the usual radius, unless triangles are large.
    """
    edge, diagonal = edge_and_diagonal(arrays)
    if not descriptors or not set(descriptors) <= MASKS.keys():
        usual = fitting_radius(edge, diagonal) * diagonal
        return SIZES[size] * usual, edge, diagonal
    own = MASK_RADIUS_IN_EDGES * edge / diagonal
    share = min(max(own, LEAST_MASK_RADIUS), largest)
    sized = SIZES[size] * max(MASKS[name] for name in descriptors) * share
    least = edge / diagonal if own <= largest else 0.0  # below it, values show faces
    return float(f"{max(sized, least):.3g}") * diagonal, edge, diagonal


def suggested(report: dict[str, float], density: float) -> dict[str, object] | None:
    """A radius that sees the surface, as a share of the diagonal, and the smallest buffer with four texels in it."""
    diagonal = report["diagonal"]
    if not (diagonal > 0 and density > 0):
        return None
    radius = fitting_radius(report["mean_edge"], diagonal)
    texels = {size: radius * diagonal * density * size for size in BUFFERS}
    fitting = next((size for size in BUFFERS if texels[size] >= LEAST_TEXELS), BUFFERS[-1])
    usual = bridge.Options().buffer_size
    return {
        "radius": radius,
        "radius_unit": "diagonal",
        "buffer": fitting,
        "radius_in_texels": texels[fitting],
        "smallest_radius_at_usual_buffer": LEAST_TEXELS / (density * usual * diagonal),
    }
