"""Makes the textures of one object: evaluates as if at texels, and packs 16-bit PNGs under names that engines know.

No bpy. Images stay in memory until the caller keeps it: an unsaved .blend has no folder for files.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from ..bridge import InputError, MeshArrays, ProgressFunction
from ..core import job, texel_centers, texel_tiles, transfer, udim
from ..core.advice import LARGEST_IN_IMAGES, double_areas
from ..core.color_maps import Look, most_telling
from ..core.threads import go_on
from . import maps, mask_image, png, tile_names
from .results import Baked

# The names that Substance and game engines use for textures of these descriptors; all others keep their own names.
WORDS = {
    "cavity": "cavity",
    "convexity": "edges",
    "mean_curvature": "curvature",
    "ambient_openness": "openness",
}
# The descriptors in the red, green and blue of a packed texture, and its name.
PACKED = ("cavity", "convexity", "ambient_openness")
PACKED_WORD = "masks"
CHANNELS = "RGBA"
OPAQUE = 65535
# The computation has this share of the progress; textures are drawn and packed in the rest.
COMPUTING = 0.7
# If UDIM tiles are computed one by one, the work before the first of them has this share.
BEGINNING = 0.3
# Drawing has this share of the work on a texture; packing it has the rest.
DRAWING = 0.8
# Charts count as stacked if their areas add up to more than this share of the covered area; borders are half a texel
# off.
STACKED_SHARE = 1.05


@dataclass(frozen=True)
class Choice:
    """The options of textures: size, transparency, packing and colors."""

    size: int  # texels a side
    transparent: bool = False  # where there is no surface, instead of neutral
    packed: bool = False
    look: Look = field(default_factory=Look)  # the look whose ranges the pixels span

    def settings(self, settings: job.Settings) -> job.Settings:
        """The settings, with the descriptors of a packed texture if one is asked for."""
        return replace(settings, descriptors=PACKED, more_radii=()) if self.packed else settings

    def runs(self, settings: job.Settings, fit: Callable[[job.Settings], job.Settings]) -> list[job.Settings]:
        """The settings of each computation. Masks in a packed texture each get a radius that fits them."""
        settings = self.settings(settings)
        if not self.packed:
            return [fit(settings)]
        alone = [fit(replace(settings, descriptors=(name,))) for name in settings.descriptors]
        together: dict[float, job.Settings] = {}
        for one in alone:
            radius = one.options.radius
            names = together[radius].descriptors if radius in together else ()
            together[radius] = replace(one, descriptors=(*names, *one.descriptors))
        return list(together.values())


@dataclass(frozen=True)
class Texture:
    """One PNG file that has been made."""

    name: str  # without suffix
    content: bytes
    tile: int | None = None  # the number of the UDIM tile, if the image is tiled
    holds: tuple[str, ...] = ()  # the values in its channels
    dark: float = 0.0  # the share of the surface that is nearly black
    bright: float = 0.0  # and nearly white

    @property
    def file_name(self) -> str:
        """The name of the file, with the tile's number and the suffix."""
        return str(tile_names.of_tile(Path(f"{self.name}.png"), self.tile))


@dataclass(frozen=True)
class Encoded:
    """The content of a PNG file, and facts about its pixels."""

    content: bytes
    scales: list[mask_image.Scale]  # of the channels, without the one of what is transparent
    covered: float  # the share of texels on the surface
    dark: float  # the share of those that are nearly black in all channels
    bright: float  # and nearly white


@dataclass(frozen=True)
class Onto:
    """Detailed surfaces that are measured for the UV map of a low-poly one; cage: as transfer.run() takes it."""

    low: transfer.Part
    highs: list[transfer.Part]
    cage: float


@dataclass
class Computed:
    """The results from which the textures of one object are drawn."""

    stem: str  # the beginning of their names
    found: list[job.Results]  # one for each radius
    arrays: MeshArrays
    tiling: udim.Tiling


@dataclass
class Textures:
    """All textures of one object, with the results from which they were made."""

    results: job.Results
    made: list[Texture]  # the tiles of one image follow each other

    def by_name(self) -> dict[str, list[Texture]]:
        """The tiles of each image, in their order."""
        found: dict[str, list[Texture]] = {}
        for texture in self.made:
            found.setdefault(texture.name, []).append(texture)
        return found

    def most_telling(self) -> int:
        """The index of the first image, or of the least black one if the first is nearly black everywhere."""
        return most_telling([seen["dark"] for seen in self.extremes()])

    def extremes(self) -> list[dict[str, float]]:
        """The shares of each image that are nearly black and nearly white."""
        images, words = self.by_name().values(), ("dark", "bright")
        return [{word: sum(getattr(tile, word) for tile in tiles) / len(tiles) for word in words} for tiles in images]


def word_of(name: str) -> str:
    """The descriptor in a texture's name, after the object: "curvature", or "curvature_r0.02" with several radii."""
    stem = job.registry_name(name)
    return WORDS.get(stem, stem) + name.removeprefix(stem)


def run(
    stem: str,
    mesh: MeshArrays | Onto,
    settings: job.Settings,
    choice: Choice,
    progress: ProgressFunction | None = None,
) -> Textures:
    """Computes and makes the textures, whose names begin with stem; raises ParadescError where progress says stop."""
    before = BEGINNING if udim.of_mesh(arrays_of(mesh)).tiles else COMPUTING
    found = computed(stem, mesh, settings, choice, job.span_of(progress, 0.0, before))
    return packed(found, choice, job.span_of(progress, before, 1.0))


def arrays_of(mesh: MeshArrays | Onto) -> MeshArrays:
    """The mesh over whose UV map the textures lie."""
    return mesh.low.arrays if isinstance(mesh, Onto) else mesh


def computed(
    stem: str,
    mesh: MeshArrays | Onto,
    settings: job.Settings,
    choice: Choice,
    progress: ProgressFunction | None = None,
) -> Computed:
    """Computes the results from which the textures of a mesh are drawn."""
    arrays, size = arrays_of(mesh), choice.size
    if not double_areas(arrays.positions[arrays.triangle_vertices]).any():
        raise InputError("The mesh has no area; there is no surface to measure.")
    tiling = udim.of_mesh(arrays)
    if isinstance(mesh, Onto):
        fit = partial(job.fitted, arrays=mesh.highs[0].measured, largest=LARGEST_IN_IMAGES)
    else:
        fit = partial(texel_centers.fitted, arrays)
    found, runs = [], choice.runs(settings, fit)
    for number, one in enumerate(runs):
        part = job.part_of(progress, number, len(runs))
        if isinstance(mesh, Onto):
            found.append(transfer.run(mesh.low, mesh.highs, one, size, mesh.cage, part, tiling.tiles))
        else:
            found.append(texel_tiles.run(arrays, one, size, tiling.tiles, part))
    return Computed(stem, found, arrays, tiling)


def packed(made_of: Computed, choice: Choice, making: ProgressFunction | None = None) -> Textures:
    """Draws and packs the textures of the computed results, tile after tile."""
    found, tiling = made_of.found, made_of.tiling
    for results in found:
        results.look = choice.look
    names = [name for results in found for name in results.values]
    in_order = sorted(names, key=PACKED.index) if choice.packed else names
    groups = {PACKED_WORD: in_order} if choice.packed else {word_of(name): [name] for name in names}
    made: dict[str, list[Texture]] = {word: [] for word in groups}
    covered, tiles = 0.0, tiling.tiles or (None,)
    for number, tile in enumerate(tiles):
        of_tile = job.part_of(making, number, len(tiles))
        share = 0.0 if found[0].tiles is None else COMPUTING
        bakes: dict[str, Baked] = {}  # the results of a tile, by the descriptor that is drawn from them
        for index, results in enumerate(found):
            own = results.of_tile(tile, job.part_of(job.span_of(of_tile, 0.0, share), index, len(found)))
            bakes.update(dict.fromkeys(results.values, Baked(made_of.stem, own, made_of.arrays, np.eye(4))))
        textures, least = textures_of(bakes, groups, choice, tile, job.span_of(of_tile, share, 1.0))
        covered += least
        for word, texture in zip(groups, textures, strict=True):
            made[word].append(texture)
    for results in found:
        results.finish_tiles()
        results.tiles = None  # with the mesh that they would be evaluated on
    results = joined(found)
    results.notes += tiling.notes
    results.warnings += tiling.warnings
    if texel_centers.uv_area(made_of.arrays) > STACKED_SHARE * covered:
        results.warnings.append(maps.STACKED)
    return Textures(results, [texture for row in made.values() for texture in row])


def joined(found: list[job.Results]) -> job.Results:
    """The results of several computations as one: the first one's reports, and the times, notes and warnings of all."""
    return replace(
        found[0],
        field_report={**found[0].field_report, **job.seconds_of(found)},
        notes=list(dict.fromkeys(note for one in found for note in one.notes)),
        warnings=list(dict.fromkeys(warning for one in found for warning in one.warnings)),
    )


def textures_of(
    bakes: dict[str, Baked],
    groups: dict[str, list[str]],
    choice: Choice,
    tile: int | None,
    drawing: ProgressFunction | None,
) -> tuple[list[Texture], float]:
    """The textures of one tile, by the word in their names, and the share of the tile that is on the surface."""
    any_baked = next(iter(bakes.values()))
    shown = maps.cut_of(any_baked, tile)
    made, covered = [], math.inf
    for number, (word, group) in enumerate(groups.items()):
        of_one = job.part_of(drawing, number, len(groups))
        channels = [(bakes[name], name) for name in group]
        one = encoded(channels, choice.size, choice.transparent, of_one, shown)
        made.append(Texture(f"{any_baked.object_name}_{word}", one.content, tile, tuple(group), one.dark, one.bright))
        if bakes[group[0]].results.values[group[0]].ndim == 1:  # directions may be missing on the surface
            covered = one.covered
    return made, covered


def encoded(
    sources: list[tuple[Baked, str]],
    size: int,
    transparent: bool = False,
    progress: ProgressFunction | None = None,
    shown: udim.Cut | None = None,
) -> Encoded:
    """A 16-bit PNG of one descriptor, or of one in each channel; shown: the tile, if it is one of several."""
    channels, filled, scales, meanings, dark, bright = [], None, [], [], 1.0, 1.0
    of_channels = job.span_of(progress, 0.0, DRAWING)
    for number, (baked, name) in enumerate(sources):
        pixels = drawn(baked, name, size, job.part_of(of_channels, number, len(sources)), shown)
        meaning = pixels.scale.meaning(name, baked.unit(name))
        channels.append(pixels.values)
        scales.append(pixels.scale)
        dark, bright = min(dark, pixels.dark), min(bright, pixels.bright)
        meanings.append(meaning if len(sources) == 1 else f"{CHANNELS[number]}: {meaning}")
        filled = pixels.filled if filled is None else filled | pixels.filled
    go_on(progress, "write", DRAWING)
    if transparent and len(sources) < len(CHANNELS):
        channels.append(np.where(filled, OPAQUE, 0).astype(np.uint16)[:, :, None])
    image = channels[0] if len(channels) == 1 else np.concatenate(channels, axis=2)
    content = png.encode_png(image[::-1], {"Description": "; ".join(meanings)}, quick=True)
    return Encoded(content, scales, pixels.covered, dark, bright)


def drawn(
    baked: Baked,
    name: str,
    size: int,
    progress: ProgressFunction | None = None,
    shown: udim.Cut | None = None,
) -> mask_image.Pixels:
    """The pixels of a descriptor over the mesh's UV map. Undefined values on the surface become neutral."""
    row, values = job.registry_row(name), baked.results.values[name]
    if values.ndim == 2:
        scale, span = mask_image.signed_scale(0.0, 1.0), None
    else:
        span = baked.results.shown(name)
        scale = mask_image.scale_of(span, row.neutral_value)
        neutral = scale.low + (scale.high - scale.low) * scale.outside / mask_image.WHOLE
        values = np.where(np.isfinite(values), values, np.float32(neutral))
    image = maps.drawn(maps.user_uvs(baked), size, baked, name, values, progress, shown)
    return mask_image.pixels_of(image, scale) if span is None else mask_image.leveled(image, scale, span)
