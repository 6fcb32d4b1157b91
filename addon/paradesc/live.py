"""Live mode: an object's deformed positions at every frame to values and colors of its mesh.

A session keeps what lasts from frame to frame. Its steps are called by handlers.py; errors are ParadescError, which the
handlers turn into a sentence in the panel.
"""

import time
from dataclasses import replace

import bpy
import numpy as np

from . import frames, looks, mesh_io, painting, properties, sources, surface_maps
from .bridge import MeshArrays, Options
from .color_maps import ValueRange
from .job import Results, Settings
from .mesh_io import refuse
from .stream import Stream

# In these modes Blender works on copies of a mesh, or keeps tables of its own: results wait until they are left.
WAITING_MODES = {"EDIT", "SCULPT", "VERTEX_PAINT"}
# Smaller buffers save nothing more, and a radius of fewer texels costs accuracy.
SMALLEST_BUFFER, ENOUGH_TEXELS = 256, 5.5
STAGES = ("read", "compute", "write")
# Modifiers that only append vertices: the original ones come first, in their order (tested).
APPENDING = {"SUBSURF", "MULTIRES", "MIRROR", "SOLIDIFY", "ARRAY"}


class Session:
    """What one live object keeps from frame to frame. It holds arrays only: Blender's own data moves with undo."""

    def __init__(self) -> None:
        self.stream: Stream | None = None
        self.topology: tuple[object, ...] = ()
        self.arrays: MeshArrays | None = None  # of the undeformed mesh
        self.positions: np.ndarray | None = None  # what the results are of
        self.asked: Settings | None = None
        self.results: Results | None = None
        self.painter = painting.Painter()
        self.seconds: dict[str, float] = {}  # of the last frame that was computed, by stage
        self.note = ""  # for the panel
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
        positions = deformed_positions(target, evaluated, depsgraph.mode == "RENDER")
        read = time.perf_counter()
        fresh = self.results is None or settings != self.asked or not np.array_equal(positions, self.positions)
        if fresh:
            self.compute(positions, evaluated, settings, is_quick(scene, depsgraph.mode == "RENDER"))
        computed = time.perf_counter()
        self.results.look = looks.scene_look(scene)
        ranges = painting.locked_ranges(scene.paradesc_live, self.found_ranges())
        changed = self.painter.paint(target.data, self.values(target.data), ranges, fresh)
        if changed:
            painting.tag_written(target.data, depsgraph)
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
        self.edited = False
        if self.stream is not None and not (topology == self.topology and self.stream.matches(arrays)):
            self.close()
        elif self.arrays is not None and np.array_equal(arrays.positions, self.arrays.positions):
            return
        self.topology, self.arrays, self.asked = topology, arrays, None  # and the radius follows the new rest pose

    def compute(
        self, positions: np.ndarray, evaluated: bpy.types.Object, settings: Settings, quick: bool = False
    ) -> None:
        """The results of these positions, at the radius of the undeformed mesh: it does not change with the pose."""
        if self.stream is None or device_of(self.stream.settings) != device_of(settings):
            self.close()
            self.stream = Stream(self.arrays, settings)
        if settings != self.asked:
            self.stream.settings = settings
            self.stream.settings = frames.at_fixed_radii(settings, self.stream.mesh_at(self.arrays).report())
        normals = mesh_io.read_corner_normals(evaluated.data) if settings.options.normals == "mesh" else None
        self.results = self.stream.compute(positions, corner_normals=normals)
        if quick and settings != self.asked:
            options = with_fewer_texels(self.stream.settings.options, self.results.field_report["radius_in_texels"])
            if options != self.stream.settings.options:
                self.stream.settings = replace(self.stream.settings, options=options)
                self.results = self.stream.compute(positions, corner_normals=normals)
        self.positions, self.asked = positions, settings

    def forget_ranges(self) -> None:
        """Nothing is kept of them."""

    def found_ranges(self) -> dict[str, ValueRange]:
        """The range of each descriptor in these results."""
        if self.results is None:
            return {}
        return {name: mesh_io.shown_range(self.results, computed) for name, computed in self.names()}

    def names(self) -> list[tuple[str, str]]:
        """What each value is called by the radius that was asked for, and by the one that was computed with."""
        return list(zip(self.asked.value_names(), self.results.settings.value_names(), strict=True))

    def values(self, mesh: bpy.types.Mesh) -> painting.Values:
        """The results as they are written."""
        shown = {name: self.results.values[computed] for name, computed in self.names()}
        return painting.Values(shown, self.results.extras, lambda: mesh_io.summary(mesh, self.results))


# ---- What is asked


def settings_for(scene: bpy.types.Scene, rendering: bool) -> Settings:
    """The scene's settings: in the viewport with what live mode makes of them for speed."""
    settings = properties.job_settings(scene.paradesc)
    group = scene.paradesc_live
    if settings.space != "object":
        raise refuse("Live values are measured in object space; choose that, and apply the scale where it matters.")
    if not is_quick(scene, rendering):
        return settings
    options = replace(
        settings.options,
        samples=min(settings.options.samples, group.samples),
        buffer_size=min(settings.options.buffer_size, group.buffer_size),
        relocation="affine" if group.fast_seams else settings.options.relocation,
    )
    return replace(settings, options=options)


def is_quick(scene: bpy.types.Scene, rendering: bool) -> bool:
    """Whether live mode's own, quicker settings hold."""
    return not (rendering and scene.paradesc_live.full_render)


def with_fewer_texels(options: Options, radius_in_texels: float) -> Options:
    """The same options with buffers as small as the radius allows, which take less time."""
    size = options.buffer_size
    while size > SMALLEST_BUFFER and radius_in_texels * (size // 2) >= ENOUGH_TEXELS * options.buffer_size:
        size //= 2
    return replace(options, buffer_size=size)


def device_of(settings: Settings) -> tuple[str, int]:
    """What a native mesh cannot change."""
    return (settings.backend, settings.device_index)


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


def deformed_positions(target: bpy.types.Object, evaluated: bpy.types.Object, rendering: bool) -> np.ndarray:
    """(vertex_count, 3) float32 of the original vertices in object space after all modifiers."""
    count, found = len(target.data.vertices), len(evaluated.data.vertices)
    if not keeps_vertices(target, rendering, count, found):
        raise refuse(
            f'The modifiers of "{target.name}" make {found:,} vertices of {count:,}, among which live values do not '
            "find the original ones; switch those off that take vertices away, or bake frames and play them."
        )
    return mesh_io.read_positions(evaluated.data)[:count]


def keeps_vertices(target: bpy.types.Object, rendering: bool, count: int, found: int) -> bool:
    """True where the modifiers in use leave the original vertices first."""
    used = [item for item in target.modifiers if (item.show_render if rendering else item.show_viewport)]
    if any(item.type == "MIRROR" and any(item.use_bisect_axis) for item in used):
        return False  # it may well make as many as it cuts away
    changing = [item for item in used if item.type in sources.GENERATING or item.type == "NODES"]
    return count == found or (found > count and all(item.type in APPENDING for item in changing))
