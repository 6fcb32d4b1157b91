"""Live mode: computes values and colors of a mesh from its deformed positions at every frame.

A session keeps what lasts from frame to frame. handlers.py calls its steps, and turns a ParadescError into a sentence
in the panel.
"""

import time
from dataclasses import dataclass, replace

import bpy
import numpy as np

from paradesc.bridge import InputError, Options, ParadescError, ProgressFunction
from paradesc.core import advice, color_maps, fitting
from paradesc.core.color_maps import Look, ValueRange
from paradesc.core.job import Results, Settings, check_descriptors, registry_row
from paradesc.core.latest import Latest, Outcome, is_cancelled
from paradesc.core.stream import Stream, is_too_small
from paradesc.files.frame_baking import with_fixed_radii
from paradesc.files.reading import Read, on_original

from ..bake import sculpt_mask
from ..scene import carrying, delivery, mesh_io, ownership, record, surface_maps
from ..scene.arrays import set_values
from ..settings import looks, properties
from . import painting, surfaces

# Smaller buffers would save no time, and a radius of fewer texels would cost accuracy.
SMALLEST_BUFFER, ENOUGH_TEXELS = 256, 5.5
# On a mesh of so many triangles a radius spans many edges, and fitted normals would make sculpting wait.
FINE = 100_000
TOO_SMALL = "The mesh is smaller than the radius at this frame, so its values are undefined."
# The member of the mesh's record that keeps the radii of a generated mesh and the settings they follow from. Machines
# of a farm start at other frames than the window did, and must use the same radii.
RADII = "live_radii"


@dataclass(frozen=True, eq=False)
class LiveRequest:
    """The input of one live computation."""

    read: Read  # the undeformed mesh, or the mesh that modifiers made at first
    kept: dict[str, object]  # what RADII keeps; {}: radii follow from the arrays
    positions: np.ndarray  # (vertex_count, 3) float32
    corner_normals: np.ndarray | None  # (corner_count, 3) float32, where they are asked for
    settings: Settings
    quick: bool  # with buffers as small as the radius allows
    chosen: tuple[object, ...]  # as chosen() gives it

    def same(self, other: "LiveRequest | None") -> bool:
        """Returns whether the results would be the same."""
        return (
            other is not None
            and self.read is other.read
            and self.settings == other.settings
            and np.array_equal(self.positions, other.positions)
        )


class Session:
    """The state of one live object between frames. It holds only arrays, since undo may move Blender's own data."""

    def __init__(self) -> None:
        self.stream: Stream | None = None  # while a thread computes, this and prepared belong to it
        self.prepared: LiveRequest | None = None  # whose settings the stream has
        self.topology: tuple[object, ...] = ()
        self.in_window: tuple[object, ...] = ()  # the topology that was not a render's
        self.read: Read | None = None  # as LiveRequest has it
        self.kept: dict[str, object] = {}
        self.radii: dict[str, object] = {}  # the newest, as RADII keeps them
        self.rest: np.ndarray | None = None  # (original_count, 3) float32 when it was read
        self.frame: float | None = None  # of the newest request
        self.done: LiveRequest | None = None  # the request that the results belong to
        self.results: Results | None = None
        self.latest: Latest[LiveRequest, Results] = Latest(self.compute)
        self.scene_name = ""  # whose settings the newest request has
        self.shown_radius: tuple[float, str] | None = None  # in the panel, with its unit
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

    @property
    def computing(self) -> bool:
        """True while a thread computes."""
        return self.latest.computing

    def refresh(
        self, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph, scene: bpy.types.Scene, wait: bool = True
    ) -> bool:
        """Writes the values of the depsgraph's shape to the object's mesh; False if nothing had to change.

        Without wait, collect() or the next call writes them, whichever comes first once they have been computed. The
        very first values are always waited for.
        """
        start = time.perf_counter()
        rendering = depsgraph.mode == "RENDER"
        evaluated = surfaces.evaluated_object(target, depsgraph)
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
        """Writes the values that have been computed meanwhile to the mesh; False if nothing had to change."""
        taken, scene = self.take(self.latest.step(wait)), bpy.data.scenes.get(self.scene_name)
        if not taken:
            return False
        if scene is None or surfaces.waiting_sentence(target) or len(target.data.vertices) != len(self.own().coverage):
            self.unpainted = True
            return False
        self.wrote = self.show(target, scene, None, True)
        return self.wrote

    # The type is in quotes because typing remembers it, and would keep bpy alive past Python's end, which crashes.
    def take(self, outcome: "Outcome[LiveRequest, Results] | None") -> bool:
        """Keeps the results of a request; False if there are none, or if the mesh has been read again since."""
        if outcome is None or outcome.request.read is not self.read:
            return False
        if outcome.error is not None:
            if is_cancelled(outcome.error):
                return False
            raise outcome.error
        self.results, self.done = outcome.result, outcome.request
        return True

    def has_settings(self, scene: bpy.types.Scene) -> bool:
        """Returns whether the newest request, or the newest values, have the scene's present settings."""
        asked = self.latest.newest or self.done
        try:
            return asked is None or asked.chosen == chosen(scene, rendering=False)
        except ParadescError:  # which is said where they are applied
            return False

    def show(
        self, target: bpy.types.Object, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None, fresh: bool
    ) -> bool:
        """Writes the results to the mesh; False if they are there already."""
        start = time.perf_counter()
        self.unpainted = fresh = fresh or self.unpainted
        look = looks.scene_look(scene)
        self.results.look = look
        painting.follow_bake(scene.paradesc_live, look, target.data, self.asked_names())
        ranges = painting.locked_ranges(scene.paradesc_live, look, self.asked_names(), self.found_range)
        self.painter.carried = self.done.read.vertices is not None
        extras = list(mesh_io.extras_on(target.data, self.results))
        changed = self.painter.paint(target, self.values(self.own(), extras), ranges, fresh)
        rendering = depsgraph is not None and depsgraph.mode == "RENDER"
        if self.painter.carried and (changed or fresh):
            self.carry(target, self.values(self.results, extras), rendering)
        if changed:
            painting.tag_written(target, depsgraph)
        if fresh:
            self.note = TOO_SMALL if is_too_small(self.results) else ""
            if not rendering:
                self.show_radius(scene)
            write = time.perf_counter() - start
            self.seconds = {"read": self.read_seconds, "compute": self.compute_seconds, "write": write}
        self.unpainted = False
        return changed

    def carry(self, target: bpy.types.Object, values: painting.Values, rendering: bool) -> None:
        """Writes values to the vertices that modifiers made, on the same carrier as bakes.

        A render never makes a carrier. If it finds one that does not fit, because the render has another subdivision
        level, Blender interpolates the values of the object's own vertices there.
        """
        read, names, mesh = self.done.read, values.names(self.painter.at), carrying.carrier_of(target)
        arrays = read.arrays
        counts = (len(arrays.positions), len(arrays.corner_vertices))
        fits = carrying.own_group(target) is not None and painting.has_all(mesh, names)  # copies may share a group
        fits = fits and counts == carrying.counts_of(carrying.modifier_of(target).node_group)
        if rendering and not fits:
            if read.own:
                return
            raise surfaces.lost(target)
        if not fits:
            earlier = {name: array for name, array in read.earlier.items() if name not in names}
            mesh = delivery.carrier_mesh(target, arrays, not read.own, earlier)
            mesh_io.make_attributes(mesh, names)
        ownership.forget(mesh, names)
        for name, array in self.painter.attribute_values(values):
            set_values(mesh.attributes[name], array)
        if not fits:
            painting.leave_record(mesh, values, self.painter.ranges, self.painter.at)
            carrying.carry(target, mesh, counts, not read.own)
        mesh.update()

    def show_radius(self, scene: bpy.types.Scene) -> None:
        """Shows the fitted radius in the panel, as a bake does."""
        asked, found = self.done.settings, self.results.settings
        radius, unit = found.options.radius, asked.options.radius_unit
        if not follows_mesh(asked) or (radius, unit) == self.shown_radius:
            return
        self.shown_radius = (radius, unit)
        edge, diagonal = advice.mean_edge_and_diagonal(self.done.read.arrays)
        length = {"diagonal": diagonal, "mean-edge": edge}.get(unit, 1.0)
        options = replace(found.options, radius=radius / length, radius_unit=unit)
        properties.show_radius(scene.paradesc, replace(found, options=options))

    def request(
        self, target: bpy.types.Object, evaluated: bpy.types.Object, scene: bpy.types.Scene, rendering: bool
    ) -> LiveRequest:
        """The input for computing the object's values in its present shape."""
        settings = settings_for(scene, rendering)
        with surfaces.shown(target, evaluated, surfaces.source_of(scene), rendering) as surface:
            positions, normals = surface.positions, surface.normals(settings)
            read = self.follow_mesh(target, surface, settings)
        moved, self.frame = scene.frame_current_final != self.frame, scene.frame_current_final
        if read is not None:
            self.take_mesh(target, read, rendering if surface.generated else None, moved)
        if target.mode == "SCULPT":
            settings = sculpt_mask.quick(settings, len(self.read.arrays.triangle_corners), FINE)
        quick, asked = is_quick(scene, rendering), chosen(scene, rendering)
        return LiveRequest(self.read, self.kept, positions, normals, settings, quick, asked)

    def follow_mesh(self, target: bpy.types.Object, surface: surfaces.Surface, settings: Settings) -> Read | None:
        """Reads the mesh if more than positions may have changed, else None. Without edits only counts are compared."""
        topology = surfaces.topology_of(target, surface, settings, measures_maps(target))
        known = self.read is not None and topology == self.topology and surface.has_corners_of(self.read.arrays)
        settled = not self.edited or target.mode == "SCULPT"
        if known and settled and (self.results is None or painting.has_all(target.data, self.painter.written)):
            return None
        mesh_io.check_writable(target)
        read = surface.read(target, settings)
        arrays = read.arrays
        surface_maps.add_maps(target, arrays, surface_maps.MapChoice(material=measures_maps(target)))
        if arrays.maps is not None and arrays.maps.normals is not None:
            raise InputError("Live mode does not follow normal maps; switch Material Maps off.")
        self.edited = self.unsure = False
        if self.stream is not None and not (topology == self.topology and self.stream.matches(arrays)):
            self.close()
        elif self.read is not None and np.array_equal(mesh_io.read_positions(target.data), self.rest):
            return None
        self.topology = topology
        return read

    def take_mesh(self, target: bpy.types.Object, read: Read, rendering: bool | None, moved: bool) -> None:
        """Starts again with this mesh, at radii that no pose changes. rendering: None for the object's own mesh.

        moved: another frame made the mesh, for example of an animated Array, and not an edit of the modifiers.
        """
        rest, self.kept = mesh_io.read_positions(target.data), {}
        if rendering is not None:
            read.vertices, read.own = surfaces.places_of(target, read.arrays, rendering)
            is_known = moved or self.topology == self.in_window
            same = is_known and self.rest is not None and np.array_equal(rest, self.rest)
            # Renders, which may subdivide otherwise, have the radii of the window.
            if self.read is None or rendering or same:
                self.kept = self.radii or record.read(target.data).get(RADII, {})
        if not rendering:
            self.in_window = self.topology
        self.read, self.rest, self.shown_radius = read, rest, None

    def compute(self, request: LiveRequest, progress: ProgressFunction | None = None) -> Results:
        """Computes at the radius of the undeformed mesh, which does not change with the pose. Runs on any thread."""
        start = time.perf_counter()
        settings, prepared = request.settings, self.prepared
        if self.stream is None or device_of(self.stream.settings) != device_of(settings):
            self.close_stream()
            self.stream = Stream(request.read.arrays, settings, shared=True)
            prepared = None
        new = prepared is None or prepared.read is not request.read or prepared.settings != settings
        if new:
            self.prepared = None
            self.stream.settings = settings
            self.stream.settings = self.with_radii(request)
        results = self.stream.compute(request.positions, progress, request.corner_normals)
        if new and request.quick:
            options = with_fewer_texels(self.stream.settings.options, results.field_report["radius_in_texels"])
            if options != self.stream.settings.options:
                self.stream.settings = replace(self.stream.settings, options=options)
                results = self.stream.compute(request.positions, progress, request.corner_normals)
        self.prepared = request
        self.compute_seconds = time.perf_counter() - start
        return results

    def with_radii(self, request: LiveRequest) -> Settings:
        """The settings with radii that do not depend on the pose: the kept ones, else those of a bake."""
        asked, options = request.settings, request.settings.options
        words = repr((asked.radius_fit, options.radius_unit, options.radius, asked.more_radii, asked.descriptors))
        radii = request.kept.get("radii") if request.kept.get("asked") == words else None
        if isinstance(radii, list) and len(radii) == 1 + len(asked.more_radii):
            own = replace(options, radius=radii[0], radius_unit="absolute")
            found = replace(asked, options=own, more_radii=tuple(radii[1:]), radius_fit=fitting.FITTED)
        else:
            found = with_fixed_radii(self.stream, request.read.arrays, asked)
        self.radii = {"asked": words, "radii": [float(radius) for radius in (found.options.radius, *found.more_radii)]}
        return found

    def reveal(self, target: bpy.types.Object) -> None:
        """Makes the colors of the values the active ones of the mesh."""
        if self.results is not None:
            self.painter.reveal(target.data, self.values(self.own(), []))

    def forget_ranges(self) -> None:
        """Does nothing, because a session keeps no ranges."""

    def found_ranges(self, look: Look) -> dict[str, ValueRange]:
        """The range of each descriptor in these results."""
        return {} if self.results is None else {name: self.found_range(name, look) for name in self.asked_names()}

    def found_range(self, name: str, look: Look) -> ValueRange:
        """The range of one descriptor in these results."""
        results, computed = self.results, self.computed_names()[name]
        row, radius = registry_row(computed), results.radius_of(computed)
        areas = None if look.fixed(row) or results.areas_of is None else results.areas_of()
        return color_maps.value_range(results.values[computed], row, radius, look, areas)

    def asked_names(self) -> list[str]:
        """The name of each value, with the radius that was asked for."""
        return self.done.settings.value_names()

    def computed_names(self) -> dict[str, str]:
        """The name of each value with the radius that was used, by its name with the radius that was asked for."""
        return dict(zip(self.asked_names(), self.results.settings.value_names(), strict=True))

    def own(self) -> Results:
        """The results at the original vertices."""
        return on_original(self.results, self.done.read.vertices)

    def values(self, results: Results, extras: list[str]) -> painting.Values:
        """The results as painting writes them, with the extras of these names."""
        names = self.computed_names()
        return painting.Values(
            {name: results.values[computed] for name, computed in names.items()},
            {name: values for name, values in results.extras.items() if name in extras},
            {**record.facts_of(results), **({} if self.read.vertices is None else {RADII: self.radii})},
            lambda name, shown: record.drawing_of(shown, results, names[name]),
        )


# ---- What is asked


def settings_for(scene: bpy.types.Scene, rendering: bool) -> Settings:
    """The scene's settings; in the viewport live mode changes them for speed."""
    settings = properties.job_settings(scene.paradesc)
    check_descriptors(settings.descriptors)
    group = scene.paradesc_live
    if settings.space != "object":
        raise InputError("Live values are measured in object space; choose that, and apply the scale where it matters.")
    if follows_mesh(settings):  # the panel shows that of the newest bake
        settings = replace(settings, options=replace(settings.options, radius=Options().radius))
    if not is_quick(scene, rendering):
        return settings
    options = replace(
        settings.options,
        samples=min(settings.options.samples, group.samples),
        buffer_size=min(settings.options.buffer_size, group.buffer_size),
    )
    return replace(settings, options=options)


def follows_mesh(settings: Settings) -> bool:
    """Returns whether a single radius follows from the mesh. With several, names of values contain the radii."""
    return settings.radius_fit in advice.SIZES and not settings.more_radii


def chosen(scene: bpy.types.Scene, rendering: bool) -> tuple[object, ...]:
    """All settings of a scene that change the computed values."""
    return (settings_for(scene, rendering), surfaces.source_of(scene))


def is_quick(scene: bpy.types.Scene, rendering: bool) -> bool:
    """Returns whether live mode's own, quicker settings apply."""
    return not (rendering and scene.paradesc_live.full_render)


def with_fewer_texels(options: Options, radius_in_texels: float) -> Options:
    """The options with the smallest buffers that the radius allows, which take less time."""
    size = options.buffer_size
    while size > SMALLEST_BUFFER and radius_in_texels * (size // 2) >= ENOUGH_TEXELS * options.buffer_size:
        size //= 2
    return replace(options, buffer_size=size)


def device_of(settings: Settings) -> tuple[str, int, int]:
    """The settings of the device, which cannot be changed on an existing native mesh."""
    return (settings.backend, settings.device_index, settings.memory_limit)


def measures_maps(target: bpy.types.Object) -> bool:
    """Returns whether any scene of the object measures its material's maps."""
    return any(scene.paradesc.material_maps for scene in target.users_scene)


def unbaked_simulation(target: bpy.types.Object) -> str:
    """The name of a simulation on the object whose cache is not baked, or "".

    Writing to the mesh makes Blender discard such a cache, so the simulation may give other results.
    """
    found = [*target.modifiers, *(item for item in target.particle_systems if item.settings.type == "EMITTER")]
    free = (item.name for item in found if hasattr(item, "point_cache") and not item.point_cache.is_baked)
    return next(free, "")
