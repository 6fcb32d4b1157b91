"""Computes for images over several UDIM tiles: one map for all where that is small, else one tile after another.

The surface that is measured is always all of the mesh; a tile only says at which places. Never imports bpy.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..bridge import MeshArrays, ProgressFunction
from . import face_centers, job, texel_centers, udim


@dataclass
class TexelTiles:
    """Evaluates the texels of a tile when the tile is asked for."""

    arrays: MeshArrays
    settings: job.Settings
    size: int  # texels along a side of each tile
    exact: bool  # at each texel
    found: job.Results  # at the vertices
    reports: dict[int, job.Results] = field(default_factory=dict)  # by tile, without maps

    def results_of(self, tile: int, progress: ProgressFunction | None) -> job.Results:
        """The results with the maps of one tile."""
        shown, arrays = udim.alone(self.arrays, tile)
        apart, side = arrays, self.size
        if not self.exact:
            apart, side = texel_centers.centers_for(arrays, self.settings, self.size, shown)
        if apart is arrays:  # the native library shrinks it if faces across the tile's border make it larger than one
            side = side_for(self.size, arrays)
        of_tile = job.run(apart, texel_centers.with_texels(self.settings, side), progress)
        self.reports[tile] = replace(of_tile, maps={}, layout=None)
        return replace(texel_centers.joined(self.found, of_tile), tiles=None)

    def finish(self, results: job.Results) -> None:
        """Adds the places, times and warnings of all tiles to the results."""
        for of_tile in self.reports.values():
            places = results.field_report["places"] + of_tile.field_report["places"]
            both = texel_centers.joined(results, of_tile)
            results.field_report, results.warnings = {**both.field_report, "places": places}, both.warnings
        self.reports.clear()


def side_for(size: int, arrays: MeshArrays) -> int:
    """The side of one map for all tiles whose texels are as small as those of tiles with size texels a side."""
    return min(texel_centers.LARGEST_MAP, max(size, int(np.ceil(size * extent(arrays)))))


def one_by_one(arrays: MeshArrays, settings: job.Settings, size: int, exact: bool) -> bool:
    """Returns whether each tile is evaluated when its turn comes; else one map serves all of them.

    To engines in texture space the UV map is a part of what is measured, and images that move the surface lie over it.
    """
    if job.backend_for(settings) != "cpu" or arrays.maps is not None:
        return False
    if exact:
        return True
    found, side = texel_centers.centers_for(arrays, settings, size)
    return found is arrays or side > max(size, texel_centers.LEAST_SIDE)


def run(
    arrays: MeshArrays,
    settings: job.Settings,
    size: int,
    tiles: tuple[int, ...],
    progress: ProgressFunction | None = None,
) -> job.Results:
    """Computes like texel_centers.run(), where tiles have images of their own, each of size texels along a side."""
    exact = settings.options.evaluate == "texel"
    if not tiles:
        return texel_centers.run(arrays, settings, size, progress)
    if one_by_one(arrays, settings, size, exact):
        at_vertices = job.run(arrays, texel_centers.with_texels(settings, size, "vertex"), progress)
        at_vertices.tiles = TexelTiles(arrays, settings, size, exact, replace(at_vertices))
        return at_vertices
    side = size
    if job.backend_for(settings) != "cpu" or arrays.maps is not None:
        side = side_for(size, arrays)
    results = texel_centers.run(arrays, settings, side, progress)
    results.notes += coarser(side, size, arrays) if results.maps else []
    return results


def run_where_asked(
    arrays: MeshArrays,
    settings: job.Settings,
    tiles: tuple[int, ...],
    progress: ProgressFunction | None = None,
    with_buffers: bool = False,
) -> job.Results:
    """Computes like job.run(), or at faces. Images of UDIM tiles get as many texels in all as a single image would."""
    if settings.domain == "faces":
        return face_centers.run(arrays, settings, progress)
    size = settings.options.texels
    if not tiles or settings.options.evaluate != "texel" or job.backend_for(settings, with_buffers) == "reference":
        return job.run(arrays, settings, progress, with_buffers)
    if one_by_one(arrays, settings, size, exact=True) and not with_buffers:
        results = job.run(arrays, settings, progress)
        results.tiles = TexelTiles(arrays, settings, size, True, replace(results, maps={}))
        return results
    side = side_for(size, arrays)
    results = job.run(arrays, texel_centers.with_texels(settings, side), progress, with_buffers)
    results.notes += coarser(side, size, arrays)
    return replace(results, settings=settings)


def extent(arrays: MeshArrays) -> float:
    """The longer side of the box around the UV coordinates of triangles."""
    used = arrays.corner_uvs[arrays.triangle_corners.reshape(-1)].astype(np.float64)
    return float(np.ptp(used, axis=0).max())


def coarser(side: int, size: int, arrays: MeshArrays) -> list[str]:
    """A note if the one map of all tiles is coarser than the tiles' images."""
    wanted = size * extent(arrays)
    if side >= wanted:
        return []
    return [
        f"On this device all UDIM tiles share one map of {side} texels, so each tile has about "
        f"{size * side / wanted:.0f} along a side, and values between them are interpolated; the processor (cpu) "
        "measures the tiles one by one."
    ]
