"""Brings what is measured on detailed surfaces to the UV map and the vertices of a coarse one. Never imports bpy.

From each texel's place on the coarse surface a line goes along its smooth normal, both ways. The nearest surface
that it meets within the cage distance, and that faces the same side, gives the texel its value. It is the nearest, and
not the outermost, so that a cage that is wider than needed takes nothing from a part that stands in front.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from .. import bridge
from ..bridge import MeshArrays, ParadescError, ProgressFunction, abi, unusable
from . import job, spaces, texel_centers, udim
from .job import Results, Transfer

# The cage distance where none is given, as a share of the diagonal of the coarse surface: that of an icosahedron is
# enough for the sphere around it, and more hardly harms.
USUAL_CAGE = 0.1
# Texels that met nothing take values from neighbors up to so many rings away.
FILLED_RINGS = 64
# If a smaller share of texels than this met nothing, a note says so instead of a warning.
WORTH_WARNING = 0.001
# Bytes that a texel takes: its ray, drawn and cast, and its hit, without the values.
FLOAT = 4
RAY_BYTES = 2 * 6 * FLOAT + 1
HIT_BYTES = 4 * FLOAT + 2
# The share of the progress that measuring has.
MEASURING = 0.6


@dataclass
class Part:
    """One object's mesh as it stands in the world."""

    name: str
    arrays: MeshArrays  # in object space
    measured: MeshArrays  # in the space that is measured
    matrix: np.ndarray  # (4, 4) from object space to the world

    @property
    def points(self) -> np.ndarray:
        """(vertex_count, 3) float64 in the world."""
        return self.arrays.positions.astype(np.float64) @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    @property
    def triangles(self) -> np.ndarray:
        """(triangle_count, 3) int32 vertices, wound in the world as in object space even where it is mirrored."""
        vertices = self.arrays.triangle_vertices
        return vertices[:, ::-1] if np.linalg.det(self.matrix[:3, :3]) < 0 else vertices


@dataclass
class Surface:
    """The detailed meshes as one surface about the middle of the coarse one, with their values."""

    positions: np.ndarray  # (n, 3) float32
    triangles: np.ndarray  # (triangle_count, 3) int32
    values: dict[str, np.ndarray]  # each (n,) or (n, 3) float32
    coverage: np.ndarray  # (n,) float32


@dataclass
class Projection:
    """Casts rays from the low-poly surface to the detailed one, over the whole UV map or tile by tile."""

    low: Part
    surface: Surface
    rays: np.ndarray  # (n, 6) float32 places and normals of the coarse surface's vertices
    cage: float
    size: int
    base: Results | None = None  # the coarse surface's, without images
    found: dict[int, Transfer] = field(default_factory=dict)  # by tile, without images

    def look(
        self, tile: int | None, first: np.ndarray, progress: ProgressFunction | None
    ) -> tuple[bridge.Hits, bridge.Hits, np.ndarray]:
        """The hits of the first rays (n, 6) and of the covered texels' rays, and which texels (N, N) are covered."""
        uvs = self.low.arrays.corner_uvs[self.low.arrays.triangle_corners]
        corners, rays = self.low.arrays.triangle_vertices, self.rays
        if tile is not None:
            shown = udim.cut(uvs, tile)
            uvs, (corners, rays) = shown.uvs, shown.values(corners, rays)
        drawing, casting = job.span_of(progress, 0.0, 0.2), job.span_of(progress, 0.2, 1.0)
        drawn = bridge.draw_uv_image(uvs, corners, rays, self.size, None, drawing, numbers=True)
        covered, both = with_texels(first, drawn)
        del drawn
        hits = bridge.cast_rays(self.surface.positions, self.surface.triangles, both, self.cage, casting)
        return *hits.apart(len(first)), covered

    def results_of(self, tile: int, progress: ProgressFunction | None) -> Results:
        """The results with the images of one tile."""
        _, at_texels, covered = self.look(tile, self.rays[:0], progress)
        seen = over_uv_map(self.surface, at_texels, covered, self.cage)
        self.found[tile] = replace(seen, images={})
        return replace(self.base, transfer=seen, tiles=None)

    def finish(self, results: Results) -> None:
        """Adds how many texels of all tiles met nothing."""
        results.transfer.texels = sum(one.texels for one in self.found.values())
        results.transfer.missed = sum(one.missed for one in self.found.values())
        add_sentences(results, self.low.name)
        self.found.clear()


def run(
    low: Part,
    highs: list[Part],
    settings: job.Settings,
    size: int,
    cage: float = 0.0,
    progress: ProgressFunction | None = None,
    tiles: tuple[int, ...] = (),
) -> Results:
    """Measures the detailed meshes, each as a bake of its own would, and gives the coarse one their values.

    cage: how far away they are looked for, in units of the world; 0: USUAL_CAGE. Images are size texels along a side.
    tiles: UDIM tiles that have images of their own, which are drawn when they are asked for.
    """
    check_cage(cage)
    job.check_descriptors(settings.descriptors)
    for part in (low, *highs):
        spaces.check_scale(part.matrix, part.name)
    check_memory(settings, size)
    settings = texel_centers.with_texels(settings, size, "vertex")
    measuring, projecting = job.span_of(progress, 0.0, MEASURING), job.span_of(progress, MEASURING, 1.0)
    found = [
        job.run(high.measured, settings, job.part_of(measuring, number, len(highs)))
        for number, high in enumerate(highs)
    ]
    points = low.points
    used = points[np.unique(low.triangles)]
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    surface = joined(low, highs, found, middle)
    cage = cage or USUAL_CAGE * float(np.linalg.norm(np.ptp(used, axis=0)))
    rays = np.column_stack([points - middle, smooth_normals(points, low.triangles)]).astype(np.float32)
    projection = Projection(low, surface, rays, cage, size)
    names = [high.name for high in highs]
    if tiles:
        begun = job.span_of(projecting, 0.0, 0.0)
        at_vertices = bridge.cast_rays(surface.positions, surface.triangles, rays, cage, begun)
        results = at_low_vertices(surface, at_vertices, found, names)
        projection.base = replace(results)
        results.transfer = Transfer(names, cage, 0, 0, surface.values, {})
        results.tiles = projection
        return results
    at_vertices, at_texels, covered = projection.look(None, rays, projecting)
    results = at_low_vertices(surface, at_vertices, found, names)
    results.transfer = over_uv_map(surface, at_texels, covered, cage)
    results.transfer.sources = names
    add_sentences(results, low.name)
    return results


def check_cage(cage: float) -> None:
    """Refuses a cage that is not a distance."""
    if not (np.isfinite(cage) and cage >= 0):
        raise unusable(f"The cage distance is {cage:g}; it must be a length above 0, or 0 for the default.")


def memory_of_images(settings: job.Settings, size: int) -> int:
    """The bytes that rays and images take at most, if the UV map covers every texel."""
    radii = 1 + len(settings.more_radii)
    widths = [bridge.components(name) for name in settings.descriptors]
    images = radii * sum(widths) + 2 * (1 + max(widths)) + 1  # all of them, and what filled() makes of one
    return size**2 * max(RAY_BYTES, HIT_BYTES + FLOAT * images)


def check_memory(settings: job.Settings, size: int) -> None:
    """Refuses images that would exceed the memory limit, before anything is measured."""
    needed, limit = memory_of_images(settings, size), settings.memory_limit
    allowed = bridge.allowed_memory(limit)
    if needed <= allowed:
        return
    sentence = f"Images of {size:,} × {size:,} texels from high to low need about {needed / 1e9:.2g} GB of memory, and "
    sentence += f"{allowed / 1e9:.2g} GB may be used ({'the memory limit' if limit else 'half of what is free'}); "
    sentence += f"choose fewer texels, or {'set a higher limit' if limit else 'close other programs'}."
    raise ParadescError(abi.STATUS_OUT_OF_MEMORY, sentence)


def joined(low: Part, highs: list[Part], found: list[Results], middle: np.ndarray) -> Surface:
    """The detailed meshes in the world as one; directions become those of the coarse object's space."""
    starts = np.cumsum([0, *(len(high.arrays.positions) for high in highs)])
    names = list(found[0].values)
    values = {
        name: np.concatenate([turned(one, name, high, low) for one, high in zip(found, highs, strict=True)])
        for name in names
    }
    return Surface(
        np.concatenate([high.points - middle for high in highs]).astype(np.float32),
        np.concatenate([high.triangles + start for high, start in zip(highs, starts, strict=False)]).astype(np.int32),
        values,
        np.concatenate([one.coverage for one in found]),
    )


def turned(results: Results, name: str, high: Part, low: Part) -> np.ndarray:
    """(n,) values unchanged; (n, 3) directions turned from one object's space into the other's."""
    values = results.values[name]
    if values.ndim == 1 or results.settings.space == "world":
        return values
    return spaces.turned(values, np.linalg.solve(low.matrix[:3, :3], high.matrix[:3, :3]))


def smooth_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(vertex_count, 3) float64: the triangles' normals weighted by their angles, one for all vertices at a place.

    Lines along the normals of hard edges would leave gaps between the faces beside them.
    """
    corners = points[triangles]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    across = np.cross(ahead, behind)
    with np.errstate(divide="ignore", invalid="ignore"):
        angles = np.arctan2(np.linalg.norm(across, axis=2), (ahead * behind).sum(axis=2))
        of_triangles = across[:, 0] / np.linalg.norm(across[:, 0], axis=1, keepdims=True)
    weighted = np.nan_to_num(angles[:, :, None] * of_triangles[:, None, :]).reshape(-1, 3)
    _, place = np.unique(points, axis=0, return_inverse=True)
    place = place.reshape(-1)
    at_corners = place[triangles].reshape(-1)
    totals = [np.bincount(at_corners, weighted[:, axis], int(place.max()) + 1) for axis in range(3)]
    return np.column_stack(totals)[place]


def at_low_vertices(surface: Surface, hits: bridge.Hits, found: list[Results], names: list[str]) -> Results:
    """The results at the low-poly mesh's vertices, with the reports of the detailed meshes."""
    values = {name: hits.values(column) for name, column in surface.values.items()}
    first = found[0]
    warnings = [
        f'"{name}": {line}'
        for name, one in zip(names, found, strict=True)
        for line in (*one.warnings, *(one.facet_notes() if one is not first else []))  # the first's are added by all
    ]
    results = replace(
        first,
        values=values,
        coverage=hits.values(surface.coverage),
        mask=np.where(hits.missed, abi.MASK_NO_FACE, 0).astype(np.uint8),
        warnings=list(dict.fromkeys(warnings)),
        unwrapped=None,
        corners=None,
    )
    undefined = int(results.undefined.sum())
    results.field_report = {**first.field_report, "undefined_vertices": undefined, **job.seconds_of(found)}
    return results


def with_texels(rays: np.ndarray, drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The texels (N, N) of drawn rays (N, N, 6) that are covered, and rays: the given ones (n, 6), then the texels'."""
    covered = np.isfinite(drawn[:, :, 0])
    both = np.empty((len(rays) + int(covered.sum()), drawn.shape[2]), np.float32)
    both[: len(rays)] = rays
    end = len(rays)
    for row, there in zip(drawn, covered, strict=True):  # row by row, as all at once would need the memory twice
        start, end = end, end + int(there.sum())
        both[start:end] = row[there]
    return covered, both


def over_uv_map(surface: Surface, hits: bridge.Hits, covered: np.ndarray, cage: float) -> Transfer:
    """The images of the values that the covered texels' rays (N, N) met."""
    missed = np.zeros(covered.shape, bool)
    missed[covered] = hits.missed
    images = {}
    for name, column in surface.values.items():
        image = np.full((*covered.shape, column.size // len(column)), np.nan, np.float32)
        image[covered] = hits.values(column).reshape(-1, image.shape[2])
        images[name] = filled(image, missed)
    return Transfer([], cage, int(covered.sum()), int(missed.sum()), surface.values, images)


def filled(image: np.ndarray, missed: np.ndarray) -> np.ndarray:
    """The image (N, N, 1 or 3) in which texels that met nothing (N, N) take values from neighbors, as gutters do."""
    if not missed.any():
        return image
    there = np.where(np.isfinite(image[:, :, :1]), np.float32(1.0), np.float32(np.nan))
    around = bridge.fill_gutter(np.concatenate([image, there], axis=2), FILLED_RINGS)
    reached = missed & (around[:, :, -1] > 0)
    image[reached] = around[reached][:, :-1]
    return image


def add_sentences(results: Results, name: str) -> None:
    """Adds sentences about the sources of the values and about texels that met nothing; raises if all met nothing."""
    found = results.transfer
    sources = ", ".join(f'"{source}"' for source in found.sources)
    if found.texels == 0:
        raise unusable(f'The UV map of "{name}" covers the center of no texel; raise the number of texels.')
    if found.missed == found.texels:
        sentence = (
            f'No texel of "{name}" meets {sources} within the cage distance {found.cage:.4g}; lay the objects over '
            "each other, or raise the cage distance."
        )
        raise unusable(sentence)
    results.notes.append(f"Measured on {sources}, at most {found.cage:.4g} away (the cage distance).")
    if not found.missed:
        return
    few = found.missed < WORTH_WARNING * found.texels
    ending = "" if few else "; raise the cage distance"
    sentence = (
        f'{found.missed:,} of {found.texels:,} texels of "{name}" met nothing within the cage distance '
        f"{found.cage:.4g} and take the values of their neighbors{ending}."
    )
    (results.notes if few else results.warnings).append(sentence)
