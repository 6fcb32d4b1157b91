"""Computes for an image over the UV map: at every texel, or at fewer centers that lie closely enough to interpolate.

Values change over lengths like the radius, whatever the size of the image. So a large image needs a map of centers that
lie a part of the radius apart. Charts lie further apart in that map than in most UV maps, because a place between two
centers must never see one of another chart. Never imports bpy.
"""

from dataclasses import replace
from operator import attrgetter

import numpy as np

from ..bridge import MeshArrays, ProgressFunction
from . import advice, color_maps, fitting, job, packing, udim

# Centers that the radius spans at least, on all but a share of the surface: the pixels of a figure with fine detail are
# then within 0.1 % of white of those of evaluating each texel, in the mean.
CENTERS_IN_RADIUS = 12.0
SHARE_BELOW = 0.05
# A map of centers is at least this large, and its charts lie 2.5 centers or more apart: one center that interpolation
# reads lies up to 1.42 off a chart, and one that belongs to another chart up to 0.71 off that.
LEAST_SIDE = 512
GUTTER = 2.5 / LEAST_SIDE
# The native library makes no map larger than this.
LARGEST_MAP = 8192
# The side of an image that shows how bright a mask is.
SMALL_SIDE = 96
# Every texel is evaluated, unless the centers are fewer than this share of the texels.
WORTH_SHARE = 0.7
# Vertices have this share of the progress.
VERTICES = 0.1


def run(arrays: MeshArrays, settings: job.Settings, size: int, progress: ProgressFunction | None = None) -> job.Results:
    """Computes like job.run(), at vertices and for an image of size texels along a side.

    Values at vertices are those of a bake of vertices, and so are the ranges of colors that follow from them.
    """
    job.check_descriptors(settings.descriptors)
    backend = job.backend_for(settings)
    if backend == "reference":  # which has no texels
        return job.run(arrays, with_texels(settings, size, "vertex"), progress)
    exact = settings.options.evaluate == "texel"  # which needs each texel
    side = size
    if not exact and backend == "cpu" and arrays.maps is None:  # to others the layout is part of what is measured
        arrays, side = centers_for(arrays, settings, size)
    at_texels, at_vertices = with_texels(settings, side), with_texels(settings, side, "vertex")
    with job.open_context(arrays, settings) as context, context.mesh(arrays, progress) as mesh:
        results = job.run_on(mesh, arrays, at_vertices, job.span_of(progress, 0.0, VERTICES))
        of_texels = job.run_on(mesh, arrays, at_texels, job.span_of(progress, VERTICES, 1.0))
    return joined(results, of_texels)


def fitted(arrays: MeshArrays, settings: job.Settings, progress: ProgressFunction | None = None) -> job.Settings:
    """The settings with a radius that suits the surface in an image, if they ask for one, by a small image of it."""
    narrow = settings.radius_fit in fitting.NARROWED and color_maps.EDGES & set(settings.descriptors)
    settings = job.fitted(settings, arrays, progress, advice.LARGEST_IN_IMAGES)
    if not narrow or job.backend_for(settings) == "reference":
        return settings
    with job.open_context(arrays, settings) as context, context.mesh(arrays, progress) as mesh:

        def compute(chosen: job.Settings) -> job.Results:
            return job.run_on(mesh, arrays, with_texels(chosen, SMALL_SIDE), progress)

        small = fitting.narrowed(settings, compute, attrgetter("maps"))
    return replace(settings, options=replace(settings.options, radius=small.settings.options.radius))


def joined(results: job.Results, of_texels: job.Results) -> job.Results:
    """The results at vertices with the maps from texels, and the reports of both."""
    one, other = results.field_report, of_texels.field_report
    seconds = {name: one[name] + other[name] for name in one if name.startswith("seconds_")}
    same = [line for line in of_texels.warnings if line not in results.warnings]
    return replace(
        results,
        settings=of_texels.settings,
        maps=of_texels.maps,
        texel_values={name: of_texels.maps[name].ravel() for name in color_maps.MASKS & of_texels.maps.keys()},
        layout=of_texels.layout,
        unwrapped=of_texels.unwrapped,
        field_report={**other, **seconds, "undefined_vertices": one["undefined_vertices"]},
        warnings=[*results.warnings, *same],
    )


def with_texels(settings: job.Settings, side: int, evaluate: str = "texel") -> job.Settings:
    """The settings with evaluation at texels, and this number of texels along a side."""
    return replace(settings, options=replace(settings.options, evaluate=evaluate, texels=side))


def centers_for(
    arrays: MeshArrays, settings: job.Settings, size: int, shown: np.ndarray | None = None
) -> tuple[MeshArrays, int]:
    """The mesh over a layout with fewer centers, and the map's side; the mesh itself and the given size if cheaper.

    shown: (k,) the triangles that have an area in the UV map, if not all of them are asked for.
    """
    radius = least_radius(arrays, settings)
    apart = with_charts_apart(arrays, shown)
    scale = least_texels_per_length(apart)
    if not (scale > 0 and radius > 0):
        return arrays, size
    side = max(LEAST_SIDE, int(np.ceil(CENTERS_IN_RADIUS / (radius * scale))))
    fewer = uv_area(apart) * side**2 < WORTH_SHARE * uv_area(arrays) * size**2
    return (apart, side) if fewer else (arrays, size)


def least_radius(arrays: MeshArrays, settings: job.Settings) -> float:
    """The smallest radius as a length, approximately. Like the native library, this ignores unused vertices."""
    options = settings.options
    radius = min((options.radius, *settings.more_radii))
    if options.radius_unit == "absolute":
        return radius
    edge, diagonal = advice.mean_edge_and_diagonal(arrays)
    return radius * (diagonal if options.radius_unit == "diagonal" else edge)


def with_charts_apart(arrays: MeshArrays, shown: np.ndarray | None = None) -> MeshArrays:
    """The mesh over a layout of its own, in which charts keep their shapes and lie apart; triangles stay in order.

    shown: (k,) the triangles that are laid out; the others get no area.
    """
    own = udim.unshared(arrays)
    chosen = np.arange(len(own.triangle_corners)) if shown is None else shown
    corners = own.triangle_corners[chosen].reshape(-1)
    packed = packing.pack(own.corner_uvs[corners], own.corner_vertices[corners], np.full(len(chosen), 3), GUTTER)
    uvs = np.repeat(packed[:1], len(own.corner_uvs), axis=0)
    uvs[corners] = packed
    return replace(own, corner_uvs=uvs)


def uv_area(arrays: MeshArrays) -> float:
    """The share of the square that the triangles take in the UV map, those over each other counted each."""
    one, other = edges(arrays.corner_uvs[arrays.triangle_corners])
    return float(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]).sum() / 2)


def least_texels_per_length(arrays: MeshArrays) -> float:
    """The length of a unit of the surface in the UV square where it is shrunk most, apart from a small share of it."""
    (one, other), (u, v) = (
        edges(corners)
        for corners in (arrays.positions[arrays.triangle_vertices], arrays.corner_uvs[arrays.triangle_corners])
    )
    area = np.linalg.norm(np.cross(one, other), axis=1)
    in_map = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    sound = (area > 0) & (in_map > 0)
    if not sound.any():
        return 0.0
    one, other, u, v, area, in_map = (part[sound] for part in (one, other, u, v, area, in_map))
    # The squares of a triangle's two stretches have this sum and this product.
    lengths = [(one * one).sum(axis=1), (one * other).sum(axis=1), (other * other).sum(axis=1)]
    total = (u * u).sum(axis=1) * lengths[2] - 2 * (u * v).sum(axis=1) * lengths[1] + (v * v).sum(axis=1) * lengths[0]
    total, product = total / area**2, (in_map / area) ** 2
    largest = (total + np.sqrt(np.maximum(total**2 - 4 * product, 0.0))) / 2
    shrunk = np.sqrt(product / largest)
    order = np.argsort(shrunk)
    reached = np.cumsum(area[order])
    return float(shrunk[order][np.searchsorted(reached, SHARE_BELOW * reached[-1])])


def edges(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two edges (n, d) of each of (n, 3, d) triangles, from the first corner."""
    corners = corners.astype(np.float64)
    return corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
