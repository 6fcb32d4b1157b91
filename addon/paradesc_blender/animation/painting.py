"""Writes values and their colors to the attributes of a mesh, frame after frame, with ranges that stay."""

from collections.abc import Callable, Iterable
from contextlib import nullcontext
from dataclasses import dataclass, field, replace

import bpy
import numpy as np

from paradesc.core import color_maps
from paradesc.core.color_maps import Look, ValueRange

from ..scene import arrays, carrying, mesh_io, modes, ownership, record
from . import unkeyed

# The number of steps in a color table, so that one is far below the resolution of 8 bits.
TABLE_STEPS = 4096


@dataclass
class Values:
    """The values that one frame writes to a mesh, with the facts that the mesh's record keeps."""

    shown: dict[str, np.ndarray]  # each (vertex_count,) or (vertex_count, 3) float32; each also gets colors
    extras: dict[str, np.ndarray]  # each (vertex_count,) float32, without colors
    facts: dict[str, object]  # as record.facts_of() has them
    drawn: Callable[[str, ValueRange], dict[str, object]]  # gives what record.drawing_of() has

    def names(self, at: dict[str, str]) -> list[str]:
        """The names of all attributes to write. at: the attribute name of each value."""
        return mesh_io.attribute_names(self.shown, self.extras, at)


@dataclass
class Painter:
    """Remembers the values it wrote last, to write none twice. It holds only arrays: undo may move Blender's data."""

    ranges: dict[str, ValueRange] = field(default_factory=dict)
    tables: dict[str, np.ndarray] = field(default_factory=dict)
    written: dict[str, np.ndarray] = field(default_factory=dict)  # (n,) float32 by attribute
    at: dict[str, str] = field(default_factory=dict)  # the attribute that each value becomes
    basis: tuple[object, ...] = ()  # the count of vertices, the ranges and the settings that the record tells
    carried: bool = False  # the values of other vertices are shown, and those of the mesh lie below them

    def paint(self, target: bpy.types.Object, values: Values, ranges: dict[str, ValueRange], fresh: bool) -> bool:
        """Fills the attributes of the object's mesh, and adds missing ones; False if they hold these values already.

        Sculpt mode is left for a moment only where attributes are missing.
        """
        mesh, has_places = target.data, self.at.keys() == {*values.shown, *values.extras}
        complete = has_places and has_all(mesh, values.names(self.at))
        basis = (len(mesh.vertices), ranges, values.facts.get("settings"))
        if complete and not fresh and ranges == self.ranges and self.is_written(mesh):
            return False
        with nullcontext() if complete or target.mode != "SCULPT" else modes.object_mode(target):
            if not complete or basis != self.basis:
                others, self.at = self.at, mesh_io.places(mesh, values.shown, values.extras)
                mesh_io.make_attributes(mesh, values.names(self.at))
                self.tables = {name: color_table(shown) for name, shown in ranges.items()}
                self.ranges = ranges
                leave_record(mesh, values, ranges, self.at)
                if others and others != self.at:  # another mask was chosen
                    self.reveal(mesh, values)
                self.basis = basis
            ownership.forget(mesh, values.names(self.at))
            if not self.carried:
                carrying.release(mesh, values.names(self.at))
            self.written = {name: array.ravel() for name, array in self.attribute_values(values)}
            for name, array in self.written.items():
                arrays.set_values(mesh.attributes[name], array)
        return True

    def reveal(self, mesh: bpy.types.Mesh, values: Values) -> None:
        """Makes the most telling of the written colors active, unless one of the written colors is active already."""
        active = mesh.color_attributes.active_color
        colors = {f"{self.at[name]}_color" for name in self.ranges}
        if colors and (active is None or active.name not in colors):
            surface = mesh_io.surface_of(mesh)
            seen = {name: mesh_io.extremes(*surface, values.shown[name], shown) for name, shown in self.ranges.items()}
            mesh_io.show(mesh, self.at[mesh_io.most_telling(seen)])

    def is_written(self, mesh: bpy.types.Mesh) -> bool:
        """Returns whether the attributes still hold what was written, without an undo or another change since."""
        for name, values in self.written.items():
            attribute = mesh.attributes.get(name)
            if attribute is None or arrays.kind_of(attribute) != mesh_io.wanted_kind(name):
                return False
            found = arrays.attribute_values(attribute).ravel()
            if not np.array_equal(found.view(np.uint32), values.view(np.uint32)):
                return False
        return True

    def attribute_values(self, values: Values) -> Iterable[tuple[str, np.ndarray]]:
        """Every attribute with its (vertex_count,) or (vertex_count, k) float32 values."""
        for name, array in values.shown.items():
            yield self.at[name], np.ascontiguousarray(array, np.float32)
            yield f"{self.at[name]}_color", colors(array, self.ranges[name], self.tables[name])
        for name, array in values.extras.items():
            yield self.at[name], np.ascontiguousarray(array, np.float32)


def has_all(mesh: bpy.types.Mesh, names: Iterable[str]) -> bool:
    """Returns whether the mesh has attributes with all these names."""
    return all(mesh.attributes.get(name) is not None for name in names)


def leave_record(mesh: bpy.types.Mesh, values: Values, ranges: dict[str, ValueRange], at: dict[str, str]) -> None:
    """Records on the mesh what was written, so that the attributes are recognized as the add-on's own."""
    drawn = {at[name]: values.drawn(name, shown) for name, shown in ranges.items()}
    spans = {at[name]: shown for name, shown in ranges.items()}
    record.disown(mesh, mesh_io.refused(at))
    record.write(mesh, values.facts, spans, drawn, values.names(at))
    if mesh.color_attributes.active_color is None:
        mesh.color_attributes.active_color = mesh.color_attributes.get(at[next(iter(values.shown))] + "_color")


def leave(target: bpy.types.Object) -> None:
    """Keeps fingerprints of values that no longer change, on the object's mesh and on its carrier's."""
    if target.type != "MESH":
        return
    for mesh in (target.data, carrying.carrier_of(target)):
        if mesh is not None and mesh.library is None and not mesh.is_editmode:
            known = ownership.fingerprints(mesh)
            ownership.leave(mesh, [name for name in record.attributes_of(mesh) if name not in known])


def tag_written(target: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Makes Blender evaluate the object's mesh again with its new attributes, and in this depsgraph the animation, too.

    The depsgraph's copies of the mesh, its shape keys and its objects are made afresh from the originals. In a render
    or an exporter they lose their animated values by that, and Blender does not animate a frame twice: touching the
    animation makes it, in the depsgraphs of all windows as well.
    """
    target.data.update()
    if depsgraph is None or is_of_view_layer(depsgraph):
        return
    mesh = target.data
    objects = [target] if mesh.users == 1 else [item for item in bpy.data.objects if item.data == mesh]
    copied = filter(None, (mesh, mesh.shape_keys, *objects))
    animated = [item for item in copied if item.animation_data is not None]
    unkeyed.keep(animated)
    for datablock in animated:
        datablock.animation_data.action_influence = datablock.animation_data.action_influence


def is_of_view_layer(depsgraph: bpy.types.Depsgraph) -> bool:
    """Returns whether this is a view layer's own depsgraph, whose evaluation animates the originals."""
    return depsgraph.view_layer.depsgraph == depsgraph


# ---- Colors


def locked_ranges(
    group: bpy.types.PropertyGroup, look: Look, names: Iterable[str], found: Callable[[str, Look], ValueRange]
) -> dict[str, ValueRange]:
    """The ranges that hold at every frame, by name.

    These are the ranges that the look fixes; else those that the scene has stored, or those that are found if it has
    none. Ranges that were stored for another look are forgotten.
    """
    if look.ranges:
        return {name: found(name, look) for name in names}
    follow_look(group, look)
    stored, ranges = {item.name: item for item in group.ranges}, {}
    for name in names:
        item = stored.get(name)
        if item is None:
            shown = found(name, look)
            item = add_range(group, name, shown.minimum, shown.maximum)
        low = item.minimum
        above = float(np.nextafter(np.float32(low), np.float32(np.inf)))  # so that a range is never empty
        ranges[name] = found(name, replace(look, ranges={"": (low, max(item.maximum, above))}))
    return ranges


def follow_bake(group: bpy.types.PropertyGroup, look: Look, mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Takes over the ranges of a bake that wrote these values since they were live, except ranges that were typed."""
    baked = ownership.fingerprints(mesh) if ownership.PROPERTY in mesh and not look.ranges else {}
    at = {name: record.attribute_of(mesh, name) for name in names} if baked else {}
    if not baked.keys() & at.values():
        return
    stored = record.read(mesh).get("ranges", {})
    found = {name: stored[place] for name, place in at.items() if place in baked and place in stored}
    hold_ranges(group, look, {name: ValueRange(low, high, False) for name, (low, high) in found.items()})


def follow_look(group: bpy.types.PropertyGroup, look: Look) -> None:
    """Forgets the stored ranges if they do not fit this look."""
    if not keeps_ranges(group, look):
        group.ranges.clear()
    if group.ranges_look != look_key(look):
        group.ranges_look = look_key(look)


def keeps_ranges(group: bpy.types.PropertyGroup, look: Look) -> bool:
    """Returns whether the stored ranges suit this look: only the map differs, or the look fixes its own ranges."""
    return bool(look.ranges) or group.ranges_look in ("", look_key(look))


def look_key(look: Look) -> str:
    """A key of the parts of a look that ranges depend on."""
    return repr((look.percentile, look.symmetric, look.neutral))


def hold_ranges(group: bpy.types.PropertyGroup, look: Look, found: dict[str, ValueRange]) -> None:
    """Stores these ranges, except those that somebody has typed."""
    follow_look(group, look)
    stored = {item.name: item for item in group.ranges}
    for name, shown in found.items():
        item = stored.get(name)
        if item is None:
            add_range(group, name, shown.minimum, shown.maximum)
        elif not item.typed:
            item.minimum, item.maximum = shown.minimum, shown.maximum


def take_ranges(group: bpy.types.PropertyGroup, found: Iterable[dict[str, ValueRange]]) -> None:
    """Replaces the stored ranges by ones that span the found ranges of all objects."""
    spans: dict[str, list[ValueRange]] = {}
    for ranges in found:
        for name, shown in ranges.items():
            spans.setdefault(name, []).append(shown)
    group.ranges.clear()
    for name, shown in spans.items():
        add_range(group, name, min(span.minimum for span in shown), max(span.maximum for span in shown))


def add_range(group: bpy.types.PropertyGroup, name: str, minimum: float, maximum: float) -> bpy.types.PropertyGroup:
    """Adds a range to the stored ones."""
    item = group.ranges.add()
    item.name, item.minimum, item.maximum = name, minimum, maximum
    return item


def color_table(shown: ValueRange) -> np.ndarray:
    """(TABLE_STEPS + 1, 4) float32 scene-linear colors over the range; the last one is of undefined values."""
    places = np.append(np.linspace(shown.minimum, shown.maximum, TABLE_STEPS), np.nan)
    return color_maps.linear_rgba(color_maps.colors(places, shown))


def colors(values: np.ndarray, shown: ValueRange, table: np.ndarray) -> np.ndarray:
    """(n, 4) float32 scene-linear colors of (n,) values, by the nearest place in the table."""
    if values.ndim == 2:
        return color_maps.linear_rgba(color_maps.colors(values, shown))
    scale = np.float32((TABLE_STEPS - 1) / (shown.maximum - shown.minimum))
    defined = np.isfinite(values)
    place = (np.where(defined, values, 0) - np.float32(shown.minimum)) * scale
    place = np.clip(place, 0, TABLE_STEPS - 1) + np.float32(0.5)
    return table.take(np.where(defined, place, TABLE_STEPS).astype(np.int32), axis=0)
