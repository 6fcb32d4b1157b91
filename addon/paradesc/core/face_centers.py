"""Computes the descriptors of a mesh at its faces: each at its middle, as a vertex would be there. Never imports bpy.

The library evaluates at the texels of a map over the UV layout, and on the processor a layout says nothing but where on
the surface the texels are. So a layout in which each face has a single texel, at its middle, evaluates at faces.
"""

from dataclasses import replace

import numpy as np

from ..bridge import InputError, MeshArrays, ProgressFunction, abi, unusable
from . import advice, job, texel_centers, udim

DOMAINS = ("vertices", "faces")
# The corners of a triangle around a texel's middle, in texels. They are so close that, wherever that middle lies in the
# triangle, its border never comes near enough to another texel's middle for that texel to be evaluated on it.
AROUND = np.array([(-1, 0), (1, -1), (0, 1)]) / 8
LOW_COVERAGE = 0.9  # below which the mask says so, as at vertices
# Counts in the report that concern the UV map, which here is not the mesh's own.
OF_UV_MAPS = (
    "zero_uv_area_triangles", "flipped_triangles", "charts", "seam_edges", "self_seam_edges", "unlinked_edges",
    "uv_remapped",
)  # fmt: skip


def run(
    arrays: MeshArrays,
    settings: job.Settings,
    progress: ProgressFunction | None = None,
    sizes: np.ndarray | None = None,
) -> job.Results:
    """Computes like job.run(), at faces; sizes: (face_count,) of polygons, without which each triangle is a face."""
    check(arrays, settings)
    count = len(arrays.triangle_corners) if sizes is None else len(sizes)
    faces = np.arange(count) if sizes is None else np.repeat(np.arange(count), np.maximum(sizes - 2, 0))
    side = max(16, int(np.ceil(np.sqrt(count))))
    if side > texel_centers.LARGEST_MAP:
        raise InputError(f"The mesh has {count:,} faces; values at faces end at {texel_centers.LARGEST_MAP**2:,}.")
    laid = with_a_texel_each(arrays, faces, count, side)
    at_texels = replace(texel_centers.with_texels(settings, side), backend="cpu")
    return at_faces(job.run(laid, at_texels, progress), settings, laid, faces, count)


def check(arrays: MeshArrays, settings: job.Settings) -> None:
    """Refuses settings that cannot be computed at faces."""
    options = settings.options
    if job.backend_for(settings) != "cpu" or options.evaluate != "vertex":
        sentence = "Values at faces are computed on the processor alone"
        raise unusable(f"{sentence}; choose the backend cpu, and neither texels nor options of texture space.")
    if arrays.maps is not None:
        raise unusable("Values at faces cannot follow a displacement or a normal map; leave it out.")


def with_a_texel_each(arrays: MeshArrays, faces: np.ndarray, count: int, side: int) -> MeshArrays:
    """The mesh with a UV map of side × side texels, in which each face's middle lies on the texel of its number."""
    corners = arrays.positions[arrays.triangle_vertices].astype(np.float64)
    chosen, weights = middles(corners, faces, count)
    shown = np.flatnonzero(chosen >= 0)
    texels = np.column_stack([shown % side, shown // side]) + 0.5
    uvs = np.full((len(corners), 3, 2), 0.5 / side)
    uvs[chosen[shown]] = (texels[:, None] + AROUND - (weights[shown] @ AROUND)[:, None]) / side
    return udim.unshared(arrays, uvs.astype(np.float32))


def middles(corners: np.ndarray, faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(count,) the triangle in which the middle of each face is, -1 for none, and its (count, 3) weights there.

    corners: (n, 3, 3) of triangles. The middle of a bent or concave face is brought into the triangle nearest to it.
    """
    areas = advice.double_areas(corners)
    chosen, weights = np.full(count, -1), np.full((count, 3), 1 / 3)
    total = np.bincount(faces, areas, count)
    sums = [np.bincount(faces, areas * corners[:, :, axis].mean(axis=1), count) for axis in range(3)]
    with np.errstate(divide="ignore", invalid="ignore"):
        found = weights_at(corners, (np.column_stack(sums) / total[:, None])[faces])
    usable = np.flatnonzero((areas > 0) & np.isfinite(found).all(axis=1))
    best = usable[np.argsort(found[usable].min(axis=1), kind="stable")]
    chosen[faces[best]] = best  # the last one of each face stays
    several = (chosen >= 0) & (np.bincount(faces, minlength=count) > 1)
    kept = np.maximum(found[chosen[several]], 0)
    weights[several] = kept / kept.sum(axis=1, keepdims=True)
    return chosen, weights


def weights_at(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n, 3) weights of the corners (n, 3, 3) of triangles at points (n, 3) over their planes."""
    one, other, way = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    across = np.cross(one, other)
    square = (across * across).sum(axis=1)
    second = (np.cross(way, other) * across).sum(axis=1) / square
    third = (np.cross(one, way) * across).sum(axis=1) / square
    return np.column_stack([1 - second - third, second, third])


def at_faces(
    found: job.Results, settings: job.Settings, laid: MeshArrays, faces: np.ndarray, count: int
) -> job.Results:
    """The results with the texels' values as values of faces, without results that only vertices have."""
    values = {name: picture.reshape(-1, *picture.shape[2:])[:count] for name, picture in found.maps.items()}
    coverage, cut = (
        worst.reduce([values.pop(name) for name in list(values) if name.startswith(stem)])
        for worst, stem in ((np.minimum, "coverage"), (np.maximum, "boundary"))
    )

    def areas() -> np.ndarray:
        return np.bincount(faces, advice.double_areas(laid.positions[laid.triangle_vertices]) / 2, count)

    given, options = settings.options, found.settings.options
    results = replace(
        found,
        settings=replace(settings, options=replace(given, radius=options.radius), radius_fit=found.settings.radius_fit),
        values=values,
        coverage=coverage,
        mask=mask_of(cut, coverage),
        mesh_report={**found.mesh_report, **dict.fromkeys(OF_UV_MAPS, 0)},
        maps={},
        layout=None,
        corners=None,
        areas_of=found.areas_of and areas,
    )
    results.field_report = {**found.field_report, "undefined_vertices": int(results.undefined.sum())}
    return results


def mask_of(cut: np.ndarray, coverage: np.ndarray) -> np.ndarray:
    """(count,) uint8 bits of faces; cut, (count,) float32, is 1 where a boundary cuts the neighborhood."""
    with np.errstate(invalid="ignore"):
        is_cut, low = cut > 0, coverage < LOW_COVERAGE
    bits = np.isnan(coverage) * abi.MASK_NO_FACE | is_cut * abi.MASK_BOUNDARY | low * abi.MASK_LOW_COVERAGE
    return bits.astype(np.uint8)
