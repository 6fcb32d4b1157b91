"""Live mode: an object's deformed positions at every frame to values and colors of its mesh.

A session keeps what lasts from frame to frame: the native mesh, the results, and what was written. Its steps are called
by handlers.py; errors are ParadescError, which the handlers turn into a sentence in the panel.
"""

import time
from dataclasses import replace

import bpy
import numpy as np

from . import color_maps, mesh_io, properties, surface_maps
from .bridge import MeshArrays, Options
from .job import Results, Settings
from .mesh_io import refuse
from .stream import Stream

# In these modes Blender works on copies of a mesh, or keeps tables of its own: results wait until they are left.
WAITING_MODES = {"EDIT", "SCULPT", "VERTEX_PAINT"}
# Steps of a color table, far below what 8 bits can show.
TABLE_STEPS = 4096
STAGES = ("read", "compute", "write")


class Session:
    """What one live object keeps from frame to frame. It holds arrays only: Blender's own data moves with undo."""

    def __init__(self) -> None:
        self.stream: Stream | None = None
        self.topology: tuple[object, ...] = ()
        self.arrays: MeshArrays | None = None  # of the undeformed mesh
        self.positions: np.ndarray | None = None  # what the results are of
        self.asked: Settings | None = None
        self.results: Results | None = None
        self.ranges: dict[str, color_maps.ValueRange] = {}
        self.tables: dict[str, np.ndarray] = {}
        self.written: dict[str, np.ndarray] = {}  # (n,) float32 by attribute
        self.seconds: dict[str, float] = {}  # of the last frame that was computed, by stage
        self.edited = False  # the mesh has to be compared as a whole

    def close(self) -> None:
        """Frees the native mesh and its device."""
        if self.stream is not None:
            self.stream.close()
        self.stream = self.results = None

    def refresh(self, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph, scene: bpy.types.Scene) -> bool:
        """Leaves on the object's mesh the values of its shape in the depsgraph; False where nothing had to change."""
        start = time.perf_counter()
        evaluated = evaluated_object(target, depsgraph)
        if evaluated is None:
            return False
        settings = settings_for(scene, depsgraph.mode == "RENDER")
        self.follow_mesh(target, settings)
        positions = deformed_positions(target, evaluated)
        read = time.perf_counter()
        fresh = self.results is None or settings != self.asked or not np.array_equal(positions, self.positions)
        if fresh:
            self.compute(positions, evaluated, settings)
        computed = time.perf_counter()
        changed = self.write(target.data, locked_ranges(scene.paradesc_live, self.results), fresh)
        if changed:
            tag_written(target.data, depsgraph)
        if fresh:
            ends = (start, read, computed, time.perf_counter())
            self.seconds = {name: ends[k + 1] - ends[k] for k, name in enumerate(STAGES)}
        return changed

    def follow_mesh(self, target: bpy.types.Object, settings: Settings) -> None:
        """Begins again where anything but positions has changed; after edits everything is compared, else counts."""
        topology = topology_of(target, settings)
        if topology == self.topology and self.arrays is not None and not self.edited:
            return
        mesh_io.check_writable(target)
        arrays = mesh_io.read_object(target, settings.options.normals == "mesh", settings.backend != "reference")
        surface_maps.add_maps(target, arrays, surface_maps.Sources(material=measures_maps(target)))
        if arrays.maps is not None and arrays.maps.normals is not None:
            raise refuse("Live mode does not follow normal maps; switch Material maps off.")
        if self.stream is not None and not (topology == self.topology and self.stream.matches(arrays)):
            self.close()
        self.topology, self.arrays, self.edited = topology, arrays, False

    def compute(self, positions: np.ndarray, evaluated: bpy.types.Object, settings: Settings) -> None:
        """The results of these positions."""
        wanted = with_lasting_radius(settings, self.arrays)
        if self.stream is None or device_of(self.stream.settings) != device_of(wanted):
            self.close()
            self.stream = Stream(self.arrays, wanted)
        self.stream.settings = wanted
        normals = mesh_io.read_corner_normals(evaluated.data) if settings.options.normals == "mesh" else None
        self.results = self.stream.compute(positions, corner_normals=normals)
        self.positions, self.asked = positions, settings

    def write(self, mesh: bpy.types.Mesh, ranges: dict[str, color_maps.ValueRange], fresh: bool) -> bool:
        """Fills the attributes, made where they are missing; False where they hold all of it already."""
        names = mesh_io.wanted_names(self.results)
        complete = all(mesh.attributes.get(name) is not None for name in names)
        if complete and not fresh and ranges == self.ranges and self.is_written(mesh):
            return False
        if not complete or ranges != self.ranges:
            mesh_io.make_attributes(mesh, names, mesh_io.check_names(mesh, names))
            self.tables = {name: color_table(shown) for name, shown in ranges.items()}
            self.ranges = ranges
            store_summary(mesh, self.results, ranges)
        self.written = {name: values.ravel() for name, values in self.attribute_values()}
        for name, values in self.written.items():
            attribute = mesh.attributes[name]
            attribute.data.foreach_set(member_of(attribute), values)
        return True

    def is_written(self, mesh: bpy.types.Mesh) -> bool:
        """True where the attributes are as this session left them: neither undone nor written by anything else."""
        for name, values in self.written.items():
            attribute, found = mesh.attributes.get(name), np.empty(values.size, np.float32)
            if attribute is None or mesh_io.wanted_kind(name) != (attribute.data_type, attribute.domain):
                return False
            attribute.data.foreach_get(member_of(attribute), found)
            if not np.array_equal(found.view(np.uint32), values.view(np.uint32)):
                return False
        return True

    def attribute_values(self) -> list[tuple[str, np.ndarray]]:
        """Every attribute with its (vertex_count,) or (vertex_count, k) float32 values."""
        made: list[tuple[str, np.ndarray]] = []
        for name, values in self.results.values.items():
            made.append((name, np.ascontiguousarray(values, np.float32)))
            made.append((f"{name}_color", colors(values, self.ranges[name], self.tables[name])))
        return made + [(name, np.ascontiguousarray(extra, np.float32)) for name, extra in self.results.extras.items()]


# ---- What is asked


def settings_for(scene: bpy.types.Scene, rendering: bool) -> Settings:
    """The scene's settings: in the viewport with what live mode makes of them for speed."""
    settings = properties.job_settings(scene.paradesc)
    group = scene.paradesc_live
    if rendering and group.full_render:
        return settings
    options = replace(
        settings.options,
        samples=min(settings.options.samples, group.samples),
        buffer_size=min(settings.options.buffer_size, group.buffer_size),
        relocation="affine" if group.fast_seams else settings.options.relocation,
    )
    return replace(settings, options=options)


def with_lasting_radius(settings: Settings, arrays: MeshArrays) -> Settings:
    """The same settings with a radius that does not change with the pose: in units of the undeformed positions."""
    unit = radius_unit(settings.options, arrays)
    if unit == 1.0:
        return settings
    options = replace(settings.options, radius=settings.options.radius * unit, radius_unit="absolute")
    return replace(settings, options=options)


def device_of(settings: Settings) -> tuple[str, int]:
    """What a native mesh cannot change."""
    return (settings.backend, settings.device_index)


def radius_unit(options: Options, arrays: MeshArrays) -> float:
    """The length that the options' radius is a multiple of, on this mesh."""
    if options.radius_unit == "absolute":
        return 1.0
    triangles = arrays.triangle_vertices
    if options.radius_unit == "diagonal":
        used = arrays.positions[np.unique(triangles)].astype(np.float64)
        return float(np.linalg.norm(np.ptp(used, axis=0)))
    _, place = np.unique(arrays.positions, axis=0, return_inverse=True)
    edges = np.sort(place.ravel()[triangles[:, [0, 1, 1, 2, 2, 0]]].reshape(-1, 2), axis=1)
    _, first = np.unique(edges, axis=0, return_index=True)
    ends = arrays.positions[triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)[first]].astype(np.float64)
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())


def measures_maps(target: bpy.types.Object) -> bool:
    """Whether a scene of the object has its material's maps measured."""
    return any(scene.paradesc.material_maps for scene in target.users_scene)


# ---- The mesh


def topology_of(target: bpy.types.Object, settings: Settings) -> tuple[object, ...]:
    """What changes with most changes of a mesh besides its positions, and can be looked at every frame."""
    mesh = target.data
    layer = mesh.uv_layers.active
    counts = (len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons))
    maps = measures_maps(target)
    return (mesh.name, *counts, "" if layer is None else layer.name, settings.options.normals, settings.backend, maps)


def evaluated_object(target: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bpy.types.Object | None:
    """The object as the depsgraph has it; None where it has not, or where its mesh is being worked on."""
    if target.mode in WAITING_MODES:
        return None
    evaluated = target.evaluated_get(depsgraph)
    return evaluated if evaluated.is_evaluated and evaluated.type == "MESH" else None


def deformed_positions(target: bpy.types.Object, evaluated: bpy.types.Object) -> np.ndarray:
    """(vertex_count, 3) float32 in object space after all modifiers, which must not have changed the vertices."""
    count, found = len(target.data.vertices), len(evaluated.data.vertices)
    if count != found:
        raise refuse(
            f'The modifiers of "{target.name}" make {found:,} vertices of {count:,}, so live values have no place; '
            "switch off those that add or remove vertices."
        )
    return mesh_io.read_positions(evaluated.data)


def tag_written(mesh: bpy.types.Mesh, depsgraph: bpy.types.Depsgraph) -> None:
    """Has Blender evaluate the mesh again with its new attributes.

    A render's copies of the mesh and its shape keys are then made afresh from the originals, whose animated values are
    those of the window's frame, and Blender does not animate a frame twice: touching the animation makes it.
    """
    mesh.update()
    for datablock in (mesh, mesh.shape_keys) if depsgraph.mode == "RENDER" else ():
        if datablock is not None and datablock.animation_data is not None:
            datablock.animation_data.action_influence = datablock.animation_data.action_influence


def member_of(attribute: bpy.types.Attribute) -> str:
    """The member that foreach_get and foreach_set take of an attribute of ours."""
    return {"FLOAT_COLOR": "color", "FLOAT_VECTOR": "vector"}.get(attribute.data_type, "value")


def store_summary(mesh: bpy.types.Mesh, results: Results, ranges: dict[str, color_maps.ValueRange]) -> None:
    """Says on the mesh what is written there, so that the attributes are known as ours."""
    layout = mesh_io.stored_layout(mesh)
    summary = mesh_io.summary(mesh, results)
    summary["ranges"] = {name: [shown.minimum, shown.maximum] for name, shown in ranges.items()}
    mesh[mesh_io.PROPERTY] = {**summary, "layout": layout}
    first = mesh.color_attributes.get(next(iter(results.values)) + "_color")
    if mesh.color_attributes.active_color is None:
        mesh.color_attributes.active_color = first


# ---- Colors


def take_ranges(group: bpy.types.PropertyGroup, found: list[Results | None]) -> None:
    """Stores the ranges of these results: of every descriptor the one that holds those of all objects."""
    spans: dict[str, list[color_maps.ValueRange]] = {}
    for results in found:
        for name in () if results is None else results.values:
            spans.setdefault(name, []).append(mesh_io.shown_range(results, name))
    group.ranges.clear()
    for name, shown in spans.items():
        add_range(group, name, min(span.minimum for span in shown), max(span.maximum for span in shown))


def add_range(group: bpy.types.PropertyGroup, name: str, minimum: float, maximum: float) -> bpy.types.PropertyGroup:
    """One more range."""
    item = group.ranges.add()
    item.name, item.minimum, item.maximum = name, minimum, maximum
    return item


def locked_ranges(group: bpy.types.PropertyGroup, results: Results) -> dict[str, color_maps.ValueRange]:
    """The range of every descriptor that the scene has stored; those it lacks are stored as these results have them."""
    stored = {item.name: item for item in group.ranges}
    ranges = {}
    for name in results.values:
        shown = mesh_io.shown_range(results, name)
        item = stored.get(name) or add_range(group, name, shown.minimum, shown.maximum)
        ranges[name] = color_maps.ValueRange(item.minimum, max(item.maximum, above(item.minimum)), shown.diverging)
    return ranges


def above(value: float) -> float:
    """The next value that floats of 32 bits can tell: a range is never empty."""
    return float(np.nextafter(np.float32(value), np.float32(np.inf)))


def color_table(shown: color_maps.ValueRange) -> np.ndarray:
    """(TABLE_STEPS + 1, 4) float32 scene-linear colors over the range; the last one is of undefined values."""
    places = np.append(np.linspace(shown.minimum, shown.maximum, TABLE_STEPS), np.nan)
    return color_maps.linear_rgba(color_maps.colors(places, shown))


def colors(values: np.ndarray, shown: color_maps.ValueRange, table: np.ndarray) -> np.ndarray:
    """(n, 4) float32 scene-linear colors of (n,) values, by the nearest place in the table."""
    if values.ndim == 2:
        return color_maps.linear_rgba(color_maps.colors(values, shown))
    scale = np.float32((TABLE_STEPS - 1) / (shown.maximum - shown.minimum))
    defined = np.isfinite(values)
    place = (np.where(defined, values, 0) - np.float32(shown.minimum)) * scale
    place = np.clip(place, 0, TABLE_STEPS - 1) + np.float32(0.5)
    return table.take(np.where(defined, place, TABLE_STEPS).astype(np.int32), axis=0)
