"""Runs one bake from arrays to arrays, for the operator, the command line and the tests. Never imports bpy."""

import re
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from .. import bridge
from ..bridge import ProgressFunction, origin
from . import advice, balance, color_maps, contexts, fitting, mesh_faults, voxels
from .color_maps import MASKS, Look, ValueRange, Weighted, value_range
from .corners import ATTRIBUTE, THRESHOLD, WINDOW_REACH, Corners, find_corners

# Ends the names of values relative to the rest pose.
CHANGE = "_change"
# Follows the name of an attribute if that name was the user's already.
NUMBER = re.compile(r"_\d+$")

# The computation has this share of the progress if corners are looked for afterwards.
COMPUTING = 0.95
# The same if the radius is looked for before.
BALANCING = 0.75

# The attribute that marks vertices without a value.
UNDEFINED_MASK = "paradesc_mask"


@dataclass
class Settings:
    """The settings of a computation: descriptors, options and device.

    Radii beside the options' own are computed on the same baked buffers; all values are then named after their radius.
    """

    descriptors: tuple[str, ...] = ("mean_curvature",)
    options: bridge.Options = field(default_factory=bridge.Options)
    backend: str = "auto"
    device_index: int = -1
    more_radii: tuple[float, ...] = ()
    corner_threshold: float = THRESHOLD  # of the largest Harris response
    space: str = "object"  # or "world": what the arrays were brought into before; see spaces.py
    radius_fit: str = "typed"  # or a size of advice.SIZES or "auto", with which fitted() finds it; then "fitted"
    memory_limit: int = 0  # bytes, 0: half of what is free; of the machine and not of the results, so not in as_dict()
    threads: int = 0  # 0: all cores; neither in as_dict()
    domain: str = "vertices"  # or "faces", at which face_centers.py computes

    def value_names(self) -> list[str]:
        """The names of the results: the descriptors, at each radius if there are several."""
        radii = (self.options.radius, *self.more_radii)
        suffixes = [radius_suffix(radius) for radius in radii] if self.more_radii else [""]
        return [name + suffix for suffix in suffixes for name in self.descriptors]

    def as_dict(self) -> dict[str, object]:
        """The settings without nesting and with plain types, for JSON and for Blender's custom properties."""
        flat: dict[str, object] = {"descriptors": list(self.descriptors)}
        flat.update(asdict(self.options))
        flat.update(backend=self.backend, device_index=self.device_index, more_radii=list(self.more_radii))
        flat.update(corner_threshold=self.corner_threshold, space=self.space)
        if self.radius_fit != "typed":  # reports of each object then have its radius
            flat["radius_fit"] = self.radius_fit
        if self.domain != "vertices":
            flat["domain"] = self.domain
        return flat


@dataclass
class Transfer:
    """A report of how the values of detailed surfaces came to the UV map of a coarse one (transfer.py)."""

    sources: list[str]  # the names of those surfaces
    cage: float  # how far from the coarse surface they were looked for
    texels: int  # on the surface
    missed: int  # of those, how many met nothing
    measured: dict[str, np.ndarray]  # each (n,) or (n, 3) float32, the values of those surfaces
    images: dict[str, np.ndarray]  # each (N, N, 1 or 3) float32 over the UV map, rows from v = 0 up; NaN off it


@dataclass
class Results:
    """Everything that one bake leaves behind; in the domain of faces, they stand for vertices in all that follows."""

    settings: Settings
    values: dict[str, np.ndarray]  # each (vertex_count,) float32, NaN where undefined
    coverage: np.ndarray  # (vertex_count,) float32
    mask: np.ndarray  # (vertex_count,) uint8 bits abi.MASK_*
    mesh_report: dict[str, float | int]
    field_report: dict[str, float | int]  # of the first radius
    backend: str
    device: str
    warnings: list[str]  # limits of the results
    notes: list[str] = field(default_factory=list)  # facts about the measurement, and options without effect
    shape_notes: Callable[[], list[str]] = list  # gives defects of the mesh that limit values
    near_seam: np.ndarray | None = None  # (vertex_count,) bool, in texture space only
    maps: dict[str, np.ndarray] = field(default_factory=dict)  # each (N, N) or (N, N, 3), with evaluate = texel only
    buffers: dict[str, np.ndarray] = field(default_factory=dict)  # what was baked, by bridge.BUFFERS, where asked for
    layout: np.ndarray | None = None  # (triangle_count, 3, 2) where maps and buffers lie

    field_reports: dict[str, dict[str, float | int]] = field(default_factory=dict)  # by the suffix of each radius
    unwrapped: bridge.Layout | None = None  # the layout that was computed on, if not the mesh's own UV map
    corners: Corners | None = None  # with the descriptor harris only
    areas_of: Callable[[], np.ndarray] | None = None  # gives areas, if masks are among the values
    texel_values: dict[str, np.ndarray] = field(default_factory=dict)  # of masks in images, whose ranges follow from them
    look: Look = field(default_factory=Look)  # of the colors
    transfer: Transfer | None = None  # if these are values of other, more detailed surfaces
    # A TexelTiles or Projection, which makes maps and images of one UDIM tile after another, so that only one tile's
    # texels are in memory; None if all of them are here already.
    tiles: Any = None

    def of_tile(self, tile: int | None, progress: ProgressFunction | None = None) -> "Results":
        """The results with the maps and images of a tile; None stands for the only one."""
        if tile is None or self.tiles is None:
            return self
        return replace(self.tiles.results_of(tile, progress), look=self.look)

    def finish_tiles(self) -> None:
        """Adds counts, times and warnings of the tiles, once all of them have been evaluated."""
        if self.tiles is not None:
            self.tiles.finish(self)

    def shown(self, name: str) -> ValueRange:
        """The range of values that the colors of a descriptor span."""
        values, areas = self.weighted(name)
        return value_range(values, registry_row(name), self.radius_of(name), self.look, areas)

    def weighted(self, name: str) -> Weighted:
        """The values that tell the range: of texels or detailed surfaces, else those of vertices with their areas."""
        if name in self.texel_values:
            return self.texel_values[name], None
        return (self.values[name], self.areas) if self.transfer is None else (self.transfer.measured[name], None)

    @property
    def areas(self) -> np.ndarray | None:
        """(vertex_count,) float64 area around each vertex, computed on demand, as live values seldom need it."""
        return None if self.areas_of is None else self.areas_of()

    @property
    def extras(self) -> dict[str, np.ndarray]:
        """The attributes that are written besides the descriptors, each (vertex_count,) float32."""
        painted = {} if self.corners is None else {ATTRIBUTE: self.corners.painted}
        return {"coverage": self.coverage, UNDEFINED_MASK: self.undefined, **painted}

    @property
    def undefined(self) -> np.ndarray:
        """(vertex_count,) float32, 1 where at least one of the values does not exist, else 0."""
        found = np.zeros(len(self.coverage), bool)
        for values in self.values.values():
            found |= np.isnan(values.reshape(len(values), -1)).any(axis=1)
        return found.astype(np.float32)

    @property
    def harris(self) -> str | None:
        """The name of the Harris responses in which corners are found, those of the first radius; None without any."""
        return next((name for name in self.values if registry_name(name) == "harris"), None)

    @property
    def radius(self) -> float:
        """The first radius in units of the positions."""
        return float(self.field_report["radius"])

    @property
    def least_radius(self) -> float:
        """The smallest radius in units of the positions."""
        return min(float(report["radius"]) for report in self.field_reports.values())

    def report_of(self, name: str) -> dict[str, float | int]:
        """The field report of the radius that these values belong to."""
        return self.field_reports.get(name[len(registry_name(name)) :], self.field_report)

    def asked_radius(self, name: str) -> float:
        """The radius of these values, in the options' unit."""
        suffix = name[len(registry_name(name)) :]
        return float(suffix.removeprefix("_r")) if suffix else self.settings.options.radius

    def radius_of(self, name: str) -> float:
        """The radius of these values, in units of the positions."""
        return float(self.report_of(name)["radius"])

    def facet_notes(self) -> list[str]:
        """Warnings about defects of the mesh, and about a radius below the mean edge, at which values show facets."""
        edge = self.mesh_report["mean_edge"]
        if self.least_radius >= edge or self.settings.radius_fit == fitting.FITTED:
            return self.shape_notes()
        share = f"{self.least_radius / edge:.2g}"
        facets = f"The radius is only {share} of the mean edge, so values show single faces; choose a larger one."
        return [*self.shape_notes(), facets]

    def unused_notes(self) -> list[str]:
        """Notes about chosen numbers that have no effect on the backend used."""
        return unused_notes(self.backend, self.settings.options)


def shape_notes(positions: np.ndarray, mean_edge: float, radius: float, is_chosen: bool) -> list[str]:
    """Notes about (n, 3) positions that limit values at the least radius, a length; is_chosen: see voxels.notes()."""
    return [*origin.rounding_note(positions, mean_edge), *voxels.notes(positions, radius, is_chosen)]


def unused_notes(backend: str, options: bridge.Options) -> list[str]:
    """Notes about chosen numbers that have no effect on this backend."""
    usual = bridge.Options()
    chosen = {"buffer size": options.buffer_size != usual.buffer_size, "seed": options.seed != usual.seed}
    names = " and the ".join(name for name, given in chosen.items() if given)
    if backend != "cpu" or not names:
        return []
    verb = "are" if " and " in names else "is"
    return [f"The {names} {verb} ignored on the processor."]


def radius_suffix(radius: float) -> str:
    """The suffix of the names of values where several radii are computed: "_r0.02"."""
    return f"_r{radius:g}"


def registry_name(name: str) -> str:
    """The descriptor of values with this name: mean_curvature for mean_curvature_r0.02, its _change, and a _2."""
    known = {row.name for row in bridge.descriptors()}
    if name not in known:
        name = NUMBER.sub("", name).removesuffix(CHANGE)
    stem, mark, _ = name.rpartition("_r")
    return stem if mark and name not in known and stem in known else name


def with_one_scale(look: Look, found: list[Results]) -> Look:
    """The look with one range for all values of each descriptor, whatever their radii."""
    every: dict[str, list[tuple[Results, str]]] = {}
    for results in found:
        for name, values in results.values.items():
            if values.ndim == 1:
                every.setdefault(registry_name(name), []).append((results, name))
    baked = []
    for descriptor, own in every.items():
        first, name = own[0]
        values = [results.weighted(name) for results, name in own]
        baked.append((registry_row(descriptor), first.radius_of(name), values))
    return color_maps.with_one_scale(look, baked)


def registry_row(name: str) -> bridge.Descriptor:
    """The registry's row of a descriptor, at any radius. The row of a change is signed, with 0 as its neutral value."""
    stem = registry_name(name)
    found = next(row for row in bridge.descriptors() if row.name == stem)
    if name == found.name or not NUMBER.sub("", name).endswith(CHANGE):
        return found
    nan = float("nan")
    changed = {"is_signed": True, "neutral_value": 0.0, "display_minimum": nan, "display_maximum": nan}
    return replace(found, label=f"Change of {found.label}", **changed)


def check_descriptors(names: tuple[str, ...]) -> None:
    """Refuses an empty list, a name that the registry lacks, and one asked for twice."""
    known = [row.name for row in bridge.descriptors()]
    if not names:
        raise bridge.unusable("No descriptor is chosen; choose at least one.")
    for name in names:
        if name not in known:
            raise bridge.unusable(f'There is no descriptor "{name}"; choose from {", ".join(known)}.')
        if names.count(name) > 1:
            raise bridge.unusable(f'The descriptor "{name}" is listed twice.')


def check_radii(radii: tuple[float, ...]) -> None:
    """Refuses radii whose values would have the same names."""
    named: dict[str, float] = {}
    for radius in radii:
        suffix = radius_suffix(radius)
        if named.get(suffix) == radius:
            raise bridge.unusable("A radius is listed twice.")
        if suffix in named:
            raise bridge.unusable(
                f"The radii {named[suffix]!r} and {radius!r} are the same to six digits, and so are the names of their "
                f"values, which end in {suffix}; give one of them."
            )
        named[suffix] = radius


def run(
    arrays: bridge.MeshArrays,
    settings: Settings,
    progress: ProgressFunction | None = None,
    with_buffers: bool = False,
) -> Results:
    """Computes the descriptors of a mesh; raises ParadescError, also (STATUS_CANCELLED) when progress returns False."""
    check_descriptors(settings.descriptors)
    sized, settings = settings.radius_fit, fitted(settings, arrays, span_of(progress, 0.0, BALANCING))
    if sized == balance.AUTO:
        progress = span_of(progress, BALANCING, 1.0)
    with open_context(arrays, settings) as context, context.mesh(arrays, progress) as mesh:
        compute = partial(run_on, mesh, arrays, progress=progress, with_buffers=with_buffers)
        if sized in fitting.NARROWED:
            return fitting.narrowed(settings, compute, attrgetter("values"))
        return compute(settings)


def fitted(
    settings: Settings,
    arrays: bridge.MeshArrays,
    progress: ProgressFunction | None = None,
    largest: float = advice.LARGEST_MASK_RADIUS,
) -> Settings:
    """The settings with a fitted radius if they ask for one: by fitting.fitted(), or where noise and bias balance."""
    if settings.radius_fit != balance.AUTO:
        return fitting.fitted(settings, arrays, largest)
    parts = halves(progress)
    return balance.balanced(settings, arrays, lambda asked: run(arrays, asked, next(parts)))


def open_context(arrays: bridge.MeshArrays, settings: Settings, shared: bool = False) -> contexts.Lease:
    """The device that the settings name, if it can compute on these arrays; alone or together with others."""
    lease = contexts.Lease(settings.backend, settings.device_index, shared, settings.memory_limit, settings.threads)
    try:
        check_uvs(arrays, lease.context.backend)
    except bridge.ParadescError:
        lease.close()
        raise
    return lease


def backend_for(settings: Settings, buffers: bool = False) -> str:
    """The backend that computes, told before there is a mesh; pdesc_mesh_backend decides the same for a mesh."""
    if settings.backend != "auto":
        return settings.backend
    options = settings.options
    needs_opengl = options.relocation != "connected" or options.precision == "half" or options.adaptive > 0
    return "software" if buffers or needs_opengl else "cpu"


def needs_uvs(settings: Settings, buffers: bool = False) -> bool:
    """Returns whether computing needs UVs. Then a mesh without a map gets a layout; displacing images need its map."""
    backend = backend_for(settings, buffers=buffers)
    return bridge.uses_texture_space(backend) or (backend == "cpu" and settings.options.evaluate == "texel")


def check_uvs(arrays: bridge.MeshArrays, backend: str) -> None:
    """Refuses arrays without UV coordinates where texture space is needed."""
    if arrays.corner_uvs is None and bridge.uses_texture_space(backend):
        raise bridge.unusable(
            "The arrays have no UV coordinates; give them, or choose the backend cpu or reference, which need none.",
        )


def run_on(
    mesh: bridge.Mesh,
    arrays: bridge.MeshArrays,
    settings: Settings,
    progress: ProgressFunction | None = None,
    with_buffers: bool = False,
) -> Results:
    """Computes the descriptors on a native mesh that was made of these arrays."""
    finds_corners = "harris" in settings.descriptors
    computing = span_of(progress, 0.0, COMPUTING) if finds_corners else progress
    results = run_radii(mesh, settings, computing, with_buffers)
    about_shape = results.mesh_report["mean_edge"], results.least_radius, settings.radius_fit == fitting.FITTED
    results.shape_notes = partial(shape_notes, arrays.positions, *about_shape)
    if results.buffers and (center := origin.far_center(arrays.positions)) is not None:
        results.buffers["position"] = results.buffers["position"] + center
    results.warnings += mesh_faults.sentences(results.mesh_report)
    if arrays.layout is not None and (bridge.uses_texture_space(results.backend) or results.maps):
        results.unwrapped = arrays.layout
        results.warnings.insert(0, layout_sentence(arrays.layout, results.mesh_report["charts"]))
    if MASKS & set(settings.descriptors):
        results.areas_of = partial(advice.areas_of_vertices, arrays)
    if finds_corners:
        reach = WINDOW_REACH * settings.options.map_sigma * results.radius
        mesh_parts = arrays.positions, arrays.triangle_vertices, results.values[results.harris]
        results.corners = find_corners(*mesh_parts, reach, settings.corner_threshold, progress)
    return results


def run_radii(
    mesh: bridge.Mesh, settings: Settings, progress: ProgressFunction | None, with_buffers: bool
) -> Results:
    """Computes each radius from the same baked buffers. Coverage and mask are the worst of all radii."""
    radii = (settings.options.radius, *settings.more_radii)
    check_radii(radii)
    for index, radius in enumerate(radii):
        suffix = radius_suffix(radius) if len(radii) > 1 else ""
        options = replace(settings.options, radius=radius)
        with mesh.compute(settings.descriptors, options, part_of(progress, index, len(radii)), with_buffers) as found:
            report, backend, coverage, mask = found.report(), found.backend, found.values("coverage"), found.mask()
            if index == 0:
                made = mesh.report(), report, backend, found.device
                results = Results(settings, {}, coverage, mask, *made, warnings=[])
            results.coverage = np.minimum(results.coverage, coverage)
            results.mask = results.mask | mask
            results.field_reports[suffix] = report
            results.values.update({name + suffix: found.values(name) for name in settings.descriptors})
            results.warnings += [line for line in found.warnings() if line not in results.warnings]
            if bridge.uses_texture_space(backend):
                near_seam = mesh.near_seam(report["radius"])
                results.near_seam = near_seam if results.near_seam is None else results.near_seam | near_seam
            if backend != "reference" and (with_buffers or options.evaluate == "texel"):
                keep_texels(results, mesh, found, suffix, with_buffers)
    return results


def part_of(progress: ProgressFunction | None, index: int, count: int, named: str = "") -> ProgressFunction | None:
    """Turns the progress of one of several equal parts into that of the whole; named: begins the names of stages."""
    if progress is None:
        return None
    return lambda stage, fraction: progress(named + stage, (index + fraction) / count)


def seconds_of(found: list[Results]) -> dict[str, float]:
    """The times of several computations, summed."""
    names = [name for name in found[0].field_report if name.startswith("seconds_")]
    return {name: sum(one.field_report[name] for one in found) for name in names}


def span_of(progress: ProgressFunction | None, first: float, last: float) -> ProgressFunction | None:
    """Turns the progress of a part, which spans these shares of the whole, into that of the whole."""
    if progress is None:
        return None
    return lambda stage, fraction: progress(stage, first + (last - first) * fraction)


def halves(progress: ProgressFunction | None) -> Iterator[ProgressFunction | None]:
    """The progress of parts whose number is unknown: each has half of what is left."""
    done = 0.0
    while True:
        yield span_of(progress, done, (1 + done) / 2)
        done = (1 + done) / 2


def keep_texels(results: Results, mesh: bridge.Mesh, found: bridge.Field, suffix: str, with_buffers: bool) -> None:
    """Adds the images over the layout: the maps of texel evaluation, and the baked buffers if asked for."""
    if results.settings.options.evaluate == "texel":
        also = ("coverage", "boundary") if results.settings.domain == "faces" else ("coverage",)
        names = (*results.settings.descriptors, *also)
        results.maps.update({name + suffix: found.map(name) for name in names})
    if with_buffers:
        results.buffers = {name: mesh.read_buffer(name) for name in bridge.BUFFERS}
    if results.maps or results.buffers:
        results.layout = mesh.layout()


def layout_sentence(layout: bridge.Layout, charts: int) -> str:
    """A sentence about the layout that was used in place of a UV map."""
    count = f"{charts:,} chart" if charts == 1 else f"{charts:,} charts"
    if layout.kept:
        done = f"the layout of {count} that an earlier bake left in it was used"
    else:
        done = f"Blender unwrapped a copy of it into {count} for the computation"
    if layout.reason == "has no UV map":
        return f"The mesh has no UV map; {done}."
    return f"The mesh {layout.reason}; {done}, and the map itself is unchanged."
