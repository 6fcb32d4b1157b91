"""Live mode: computes values and colors of a mesh from its deformed positions at every frame.

A session keeps what lasts from frame to frame. handlers.py calls its steps, and turns a ParadescError into a sentence
in the panel.
"""

import time
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ..bridge import MeshArrays, Options, ProgressFunction
from ..core import color_maps
from ..core.color_maps import Look, ValueRange
from ..core.job import Results, Settings, needs_uvs, registry_row
from ..core.latest import Latest, Outcome, is_cancelled
from ..core.stream import Stream
from ..files.frame_baking import at_fixed_radii
from ..scene import carrying, mesh_io, record, source_meshes, surface_maps
from ..scene.mesh_io import refuse
from ..settings import looks, properties
from ..settings.snapshot import identity
from . import painting

# In these modes Blender works on a copy of the mesh, or keeps tables of its own, so results wait until the mode ends.
WAITING_MODES = {"EDIT", "SCULPT", "VERTEX_PAINT"}
# Smaller buffers would save no time, and a radius of fewer texels would cost accuracy.
SMALLEST_BUFFER, ENOUGH_TEXELS = 256, 5.5
# Modifiers that only append vertices: the original ones come first, in their order (tested).
APPENDING = {"SUBSURF", "MULTIRES", "MIRROR", "SOLIDIFY", "ARRAY"}


@dataclass(frozen=True, eq=False)
class LiveRequest:
    """What one computation needs."""

    arrays: MeshArrays  # of the undeformed mesh
    positions: np.ndarray  # (vertex_count, 3) float32
    corner_normals: np.ndarray | None  # (corner_count, 3) float32, where they are asked for
    settings: Settings
    quick: bool  # with buffers as small as the radius allows

    def same(self, other: "LiveRequest | None") -> bool:
        """Whether the results would be the same."""
        return (
            other is not None
            and self.arrays is other.arrays
            and self.settings == other.settings
            and np.array_equal(self.positions, other.positions)
        )


class Session:
    """What one live object keeps from frame to frame. It holds arrays only: Blender's own data moves with undo."""

    def __init__(self) -> None:
        self.stream: Stream | None = None  # while a thread computes, this and prepared belong to it
        self.prepared: LiveRequest | None = None  # whose settings the stream has
        self.topology: tuple[object, ...] = ()
        self.arrays: MeshArrays | None = None  # of the undeformed mesh
        self.done: LiveRequest | None = None  # what the results are of
        self.results: Results | None = None
        self.latest: Latest[LiveRequest, Results] = Latest(self.compute)
        self.scene_name = ""  # whose settings the newest request has
        self.painter = painting.Painter()
        self.seconds: dict[str, float] = {}  # of the last frame that was computed: read, compute, write
        self.read_seconds = self.compute_seconds = 0.0
        self.note = ""  # for the panel
        self.edited = False  # the mesh has to be compared as a whole
        self.unsure = False  # the same once editing pauses; most likely it was our own writing
        self.wrote = False  # since Blender last told of an edit
        self.unpainted = False  # the results are not on the mesh yet

    def close(self) -> None:
        """Frees the native mesh and its device."""
        self.latest.settle()
        self.close_stream()
        self.results = self.done = None

    def close_stream(self) -> None:
        """Frees the native mesh while nothing computes."""
        if self.stream is not None:
            self.stream.close()
        self.stream = self.prepared = None

    @property
    def busy(self) -> bool:
        """True while collect() may still bring results."""
        return self.latest.busy

    def refresh(
        self, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph, scene: bpy.types.Scene, wait: bool = True
    ) -> bool:
        """Writes the values of the depsgraph's shape to the object's mesh; False if nothing had to change.

        Without wait, collect() or the next call writes them, whichever comes first once they have been computed. The
        very first values are always waited for.
        """
        start = time.perf_counter()
        rendering = depsgraph.mode == "RENDER"
        evaluated = evaluated_object(target, depsgraph)
        if evaluated is None:
            return False
        request = self.request(target, evaluated, scene, rendering)
        self.read_seconds, self.scene_name = time.perf_counter() - start, scene.name
        if wait or self.results is None:
            self.latest.settle()
            fresh = not request.same(self.done)
            if fresh:
                self.results, self.done = self.compute(request), request
        else:
            if not request.same(self.latest.newest or self.done):
                self.latest.ask(request)
            fresh = self.take(self.latest.step())
        return self.show(target, scene, depsgraph, fresh)

    def collect(self, target: bpy.types.Object, wait: bool = False) -> bool:
        """Writes to the mesh what has been computed meanwhile; False if nothing had to change."""
        taken, scene = self.take(self.latest.step(wait)), bpy.data.scenes.get(self.scene_name)
        if not taken:
            return False
        if scene is None or target.mode in WAITING_MODES or len(target.data.vertices) != len(self.results.coverage):
            self.unpainted = True
            return False
        self.wrote = self.show(target, scene, None, True)
        return self.wrote

    # The type is in quotes because typing remembers it, and would keep bpy alive past Python's end, which crashes.
    def take(self, outcome: "Outcome[LiveRequest, Results] | None") -> bool:
        """Keeps the results of a request; False if there are none, or if the mesh has become another one."""
        if outcome is None or outcome.request.arrays is not self.arrays:
            return False
        if outcome.error is not None:
            if is_cancelled(outcome.error):
                return False
            raise outcome.error
        self.results, self.done = outcome.result, outcome.request
        return True

    def show(
        self, target: bpy.types.Object, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None, fresh: bool
    ) -> bool:
        """Writes the results to the mesh; False if they are there already."""
        start = time.perf_counter()
        look = looks.scene_look(scene)
        self.results.look = look
        ranges = painting.locked_ranges(scene.paradesc_live, look, self.asked_names(), self.found_range)
        changed = self.painter.paint(target.data, self.values(), ranges, fresh or self.unpainted)
        self.unpainted = False
        if changed:
            painting.tag_written(target, depsgraph)
        if fresh:
            write = time.perf_counter() - start
            self.seconds = {"read": self.read_seconds, "compute": self.compute_seconds, "write": write}
        return changed

    def request(
        self, target: bpy.types.Object, evaluated: bpy.types.Object, scene: bpy.types.Scene, rendering: bool
    ) -> LiveRequest:
        """What has to be computed of the object now."""
        settings = settings_for(scene, rendering)
        self.follow_mesh(target, settings)
        positions = deformed_positions(target, evaluated, rendering)
        normals = mesh_io.read_corner_normals(evaluated.data) if settings.options.normals == "mesh" else None
        return LiveRequest(self.arrays, positions, normals, settings, is_quick(scene, rendering))

    def follow_mesh(self, target: bpy.types.Object, settings: Settings) -> None:
        """Begins again if anything but positions has changed. After edits it compares all, otherwise only counts."""
        topology = topology_of(target, settings)
        known = self.arrays is not None and topology == self.topology
        if known and not self.edited and (self.results is None or self.painter.is_there(target.data)):
            return
        mesh_io.check_writable(target)
        arrays = mesh_io.read_object(target, settings.options.normals == "mesh", needs_uvs(settings))
        surface_maps.add_maps(target, arrays, surface_maps.MapChoice(material=measures_maps(target)))
        if arrays.maps is not None and arrays.maps.normals is not None:
            raise refuse("Live mode does not follow normal maps; switch Material Maps off.")
        self.edited = self.unsure = False
        if self.stream is not None and not (topology == self.topology and self.stream.matches(arrays)):
            self.close()
        elif self.arrays is not None and np.array_equal(arrays.positions, self.arrays.positions):
            return
        self.topology, self.arrays = topology, arrays  # and the radius follows the new rest pose

    def compute(self, request: LiveRequest, progress: ProgressFunction | None = None) -> Results:
        """Computes at the radius of the undeformed mesh, which does not change with the pose. Runs on any thread."""
        start = time.perf_counter()
        settings, prepared = request.settings, self.prepared
        if self.stream is None or device_of(self.stream.settings) != device_of(settings):
            self.close_stream()
            self.stream = Stream(request.arrays, settings, shared=True)
            prepared = None
        new = prepared is None or prepared.arrays is not request.arrays or prepared.settings != settings
        if new:
            self.prepared = None
            self.stream.settings = settings
            self.stream.settings = at_fixed_radii(settings, self.stream.mesh_at(request.arrays).report())
        results = self.stream.compute(request.positions, progress, request.corner_normals)
        if new and request.quick:
            options = with_fewer_texels(self.stream.settings.options, results.field_report["radius_in_texels"])
            if options != self.stream.settings.options:
                self.stream.settings = replace(self.stream.settings, options=options)
                results = self.stream.compute(request.positions, progress, request.corner_normals)
        self.prepared = request
        self.compute_seconds = time.perf_counter() - start
        return results

    def forget_ranges(self) -> None:
        """Does nothing, because a session keeps no ranges."""

    def found_ranges(self, look: Look) -> dict[str, ValueRange]:
        """The range of each descriptor in these results."""
        return {} if self.results is None else {name: self.found_range(name, look) for name in self.asked_names()}

    def found_range(self, name: str, look: Look) -> ValueRange:
        """The range of one descriptor in these results."""
        results, computed = self.results, self.computed_names()[name]
        return color_maps.value_range(
            results.values[computed], registry_row(computed), results.radius_of(computed), look
        )

    def asked_names(self) -> list[str]:
        """The name of each value, after the radius that was asked for."""
        return self.done.settings.value_names()

    def computed_names(self) -> dict[str, str]:
        """For each such name, the name after the radius that was computed with."""
        return dict(zip(self.asked_names(), self.results.settings.value_names(), strict=True))

    def values(self) -> painting.Values:
        """The results in the form in which they are written."""
        results, names = self.results, self.computed_names()
        return painting.Values(
            {name: results.values[computed] for name, computed in names.items()},
            results.extras,
            record.facts_of(results),
            lambda name, shown: record.drawing_of(shown, results, names[name]),
        )


# ---- What is asked


def settings_for(scene: bpy.types.Scene, rendering: bool) -> Settings:
    """The scene's settings; in the viewport live mode changes them for speed."""
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
    """Whether live mode's own, quicker settings apply."""
    return not (rendering and scene.paradesc_live.full_render)


def with_fewer_texels(options: Options, radius_in_texels: float) -> Options:
    """The same options with buffers as small as the radius allows, which take less time."""
    size = options.buffer_size
    while size > SMALLEST_BUFFER and radius_in_texels * (size // 2) >= ENOUGH_TEXELS * options.buffer_size:
        size //= 2
    return replace(options, buffer_size=size)


def device_of(settings: Settings) -> tuple[str, int, int]:
    """The settings that a native mesh cannot change: its device."""
    return (settings.backend, settings.device_index, settings.memory_limit)


def measures_maps(target: bpy.types.Object) -> bool:
    """Whether any scene of the object measures its material's maps."""
    return any(scene.paradesc.material_maps for scene in target.users_scene)


# ---- The mesh


def topology_of(target: bpy.types.Object, settings: Settings) -> tuple[object, ...]:
    """A summary that changes with most changes of a mesh except its positions, and is quick enough for every frame."""
    mesh = target.data
    layer = mesh.uv_layers.active
    counts = (len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons))
    maps, layer_name = measures_maps(target), "" if layer is None else layer.name
    return (identity(mesh), *counts, layer_name, settings.options.normals, needs_uvs(settings), maps)


def evaluated_object(target: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bpy.types.Object | None:
    """The object as the depsgraph has it; None if it is not there, or if its mesh is being edited."""
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
    """Whether the modifiers in use keep the original vertices, and keep them first."""
    shown = "show_render" if rendering else "show_viewport"
    used = [item for item in target.modifiers if getattr(item, shown) and not carrying.is_ours(item)]
    if any(item.type == "MIRROR" and any(item.use_bisect_axis) for item in used):
        return False  # it may well make as many as it cuts away
    changing = [item for item in used if item.type in source_meshes.GENERATING or item.type == "NODES"]
    return count == found or (found > count and all(item.type in APPENDING for item in changing))


def unbaked_simulation(target: bpy.types.Object) -> str:
    """The name of a simulation of the object whose cache is not baked, or "".

    Writing to its mesh makes Blender forget such a cache, so the simulation may come out otherwise.
    """
    found = [*target.modifiers, *(item for item in target.particle_systems if item.settings.type == "EMITTER")]
    free = (item.name for item in found if hasattr(item, "point_cache") and not item.point_cache.is_baked)
    return next(free, "")
