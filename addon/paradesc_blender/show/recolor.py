"""Changes the colors of a bake on a mesh by the stored values, without computing anything again."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

import bpy
import numpy as np

from paradesc import bridge
from paradesc.bridge import InputError, ParadescError
from paradesc.core import choices, color_maps, legend
from paradesc.core.job import registry_name, registry_row

from ..scene import arrays, carrying, image_preview, mesh_io, modes, ownership, record, targets, viewports
from ..settings import looks, translation

Item = tuple[str, str, str]
# Members of the record that other colors do not change.
KEPT = ("radius", "unit", "automatic")


def baked_names(mesh: bpy.types.Mesh) -> list[str]:
    """The names of attributes with a descriptor's values and colors from a bake that still exist on this mesh."""
    if bridge.missing_sentence():
        return []
    ours, known = record.attributes_of(mesh), {row.name for row in bridge.descriptors()}
    found = [name for name in ours if f"{name}_color" in ours and registry_name(name) in known]
    return [name for name in found if all(is_usable(mesh, one) for one in (name, f"{name}_color"))]


def is_usable(mesh: bpy.types.Mesh, name: str) -> bool:
    """Returns whether an attribute still has a type and domain that Blender can convert to those of a bake."""
    return arrays.kind_of(mesh.attributes[name]) == mesh_io.wanted_kind(name)


def is_direction(name: str) -> bool:
    """Returns whether the values are vectors, whose colors have no scale."""
    return registry_row(name).components == 3


def shown_name(mesh: bpy.types.Mesh) -> str:
    """The descriptor whose colors are active on the mesh, or ""."""
    active = mesh.color_attributes.active_color
    name = "" if active is None else active.name.removesuffix("_color")
    return name if active is not None and name != active.name and name in baked_names(mesh) else ""


def shown_names(mesh: bpy.types.Mesh) -> list[str]:
    """The descriptor whose colors are active on the mesh, as a list that may be empty."""
    return [name] if (name := shown_name(mesh)) else []


def stored_range(mesh: bpy.types.Mesh, name: str) -> color_maps.ValueRange:
    """The range and the map with which a descriptor's colors on this mesh were made."""
    stored = record.read(mesh)
    if name not in stored.get("ranges", {}):
        raise InputError(f'The mesh "{mesh.name}" no longer stores the range of "{name}"; bake it again.')
    minimum, maximum = stored["ranges"][name]
    drawn = stored.get("drawn", {}).get(name, {})
    signed = bool(drawn.get("diverging", registry_row(name).is_signed))
    levels = color_maps.Levels(
        drawn.get("contrast", 0.0), drawn.get("brightness", 0.0), bool(drawn.get("invert", False))
    )
    map_name = drawn.get("map", color_maps.AUTOMATIC)
    return color_maps.ValueRange(minimum, maximum, signed, drawn.get("neutral"), map_name, levels)


def stored_values(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    """(n,) or (n, 3) float32 values of one of our attributes; not in edit mode, where Blender hides them."""
    if name not in mesh.attributes or not is_usable(mesh, name):
        raise InputError(f'The mesh "{mesh.name}" no longer has the values "{name}"; bake them again.')
    return arrays.attribute_values(mesh.attributes[name])


def recolor(mesh: bpy.types.Mesh, name: str, look: color_maps.Look) -> color_maps.ValueRange:
    """Makes a descriptor's colors again with the look; returns their range. Not in edit mode."""
    colors = f"{name}_color"
    if colors not in mesh.attributes:
        raise InputError(f'The mesh "{mesh.name}" no longer has the colors "{colors}"; bake them again.')
    if not ownership.is_as_left(mesh, colors, mesh_io.wanted_kind(colors), ownership.faces_of(mesh)):
        raise InputError(
            f'The colors "{colors}" of the mesh "{mesh.name}" were painted over and are kept; bake again to make '
            "others beside them."
        )
    values = stored_values(mesh, name)
    stored = record.read(mesh)
    drawn = stored.get("drawn", {}).get(name, {})
    radius = drawn.get("radius", stored.get("field_report", {}).get("radius", 0.0))
    found = drawn.get("automatic")
    if found and look.is_automatic(registry_row(name).is_signed):
        look = replace(look, ranges={registry_name(name): tuple(found)})
    shown = color_maps.value_range(values, registry_row(name), radius, look)
    mesh_io.write_colors(mesh, name, values, shown)
    drawn = {
        **record.drawing(shown),
        **mesh_io.extremes(*mesh_io.surface_of(mesh), values, shown),
        **{word: drawn[word] for word in KEPT if word in drawn},
    }
    record.write(mesh, {}, {name: shown}, {name: drawn})
    ownership.leave(mesh, [colors])
    mesh.update()
    return shown


def whole_mesh(target: bpy.types.Object, name: str) -> bpy.types.Mesh:
    """The mesh with all values of an object: its carrier, if modifiers change vertices, or its own mesh."""
    carrier = carrying.carrier_of(target)
    return target.data if carrier is None or f"{name}_color" not in record.attributes_of(carrier) else carrier


def recolor_object(target: bpy.types.Object, name: str, look: color_maps.Look) -> None:
    """Makes a descriptor's colors again on the object's own mesh and on its carrier, which determines the range."""
    whole = whole_mesh(target, name)
    whole = whole if whole == target.data else carrying.own_carrier(target)
    shown = recolor(whole, name, look)
    if whole != target.data:
        recolor(target.data, name, replace(look, ranges={registry_name(name): (shown.minimum, shown.maximum)}))
        own, told = (record.read(mesh)["drawn"][name] for mesh in (target.data, whole))
        record.write(target.data, {}, {}, {name: {**own, **told}})


def obstacle(context: bpy.types.Context) -> str:
    """One sentence about why the chosen objects have nothing to show, or ""."""
    target = targets.first(context)
    if target is None:
        return "Select a mesh object first"
    if not baked_names(target.data):
        return "Bake descriptors on this mesh first"
    return targets.hidden(context)


def baked_targets(context: bpy.types.Context) -> Iterator[bpy.types.Object]:
    """The chosen and other selected objects with results; only the first of several that share a mesh."""
    seen = set()
    for target in [*targets.chosen(context), *context.selected_objects]:
        if target.type == "MESH" and target.data not in seen:
            seen.add(target.data)
            if baked_names(target.data):
                yield target


class NeedsBake:
    """Base of operators on baked meshes. They are grey without such a mesh, and report failures as one sentence."""

    whole_selection = False  # otherwise only the active object

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Returns whether the operator can run; the button's tooltip says why not."""
        return translation.can_run(cls, obstacle(context))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Runs in object mode, where attributes can be read and written."""
        found = [*baked_targets(context)] if self.whole_selection else [targets.first(context)]
        failures = 0
        with modes.object_mode():
            self.prepare(context, found)
            for target in found:
                try:
                    mesh_io.check_writable(target)
                    with modes.object_mode(target):
                        self.run(context, target)
                except ParadescError as error:
                    self.report({"ERROR"}, translation.said(error.sentence))
                    failures += 1
        return {"CANCELLED"} if failures == len(found) else {"FINISHED"}

    def prepare(self, context: bpy.types.Context, found: list[bpy.types.Object]) -> None:
        """Looks at all of them before the first one; most need nothing of that."""


class PARADESC_OT_recolor(NeedsBake, bpy.types.Operator):
    """Color all selected meshes again by these settings, without computing anything"""

    bl_idname = "paradesc.recolor"
    bl_label = "Recolor"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    every: bpy.props.BoolProperty(
        name="All Descriptors",
        description="All masks, not only the one whose colors are shown",
        default=False,
        options={"SKIP_SAVE"},
    )

    def names_of(self, mesh: bpy.types.Mesh) -> list[str]:
        """One descriptor, or all of a mesh."""
        return (not self.every and shown_names(mesh)) or baked_names(mesh)

    def prepare(self, context: bpy.types.Context, found: list[bpy.types.Object]) -> None:
        """Keeps the colors of the scene, in the scale that all meshes share if they do."""
        if not choices.look_fault(context.scene.paradesc_looks):
            shown = [(item, name) for item in found for name in self.names_of(item.data)]
            self.look = shared_look(context.scene, shown)

    def run(self, context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Recolors one descriptor, or all of this mesh."""
        fault = choices.look_fault(context.scene.paradesc_looks)
        if fault:
            raise InputError(fault)
        for name in self.names_of(target.data):
            recolor_object(target, name, self.look)


def on_look(scene: bpy.types.Scene, setting: str) -> None:
    """Recolors the selected meshes as soon as a color setting changes. In edit mode values are hidden, so it waits.

    Live values do so themselves.
    All masks get one scale or lose it, since those that are shown later would have another one.
    """
    context = bpy.context
    if context.scene != scene or obstacle(context) or choices.look_fault(scene.paradesc_looks):
        return
    names_of = baked_names if setting == "same_scale" else shown_names
    found = [item for item in baked_targets(context) if item.mode != "EDIT"]
    still = [item for item in found if not (item.is_property_set("paradesc_live") and item.paradesc_live.mode != "OFF")]
    shown = [(item, name) for item in still for name in names_of(item.data)]
    look = shared_look(scene, shown)
    for item, name in shown:
        if item.data.library is None:
            with suppress(ParadescError):  # what was painted over stays, as a click on Recolor says
                recolor_object(item, name, look)


def shared_look(scene: bpy.types.Scene, shown: list[tuple[bpy.types.Object, str]]) -> color_maps.Look:
    """The scene's look for these descriptors of objects; where it asks for one scale, with the range of all of them."""
    look = looks.scene_look(scene)
    if not scene.paradesc_looks.same_scale:
        return look
    return color_maps.with_one_scale(look, together([(whole_mesh(item, name), name) for item, name in shown]))


def together(
    shown: list[tuple[bpy.types.Mesh, str]],
) -> list[tuple[bridge.Descriptor, float, list[color_maps.Weighted]]]:
    """The values of several meshes by descriptor, with the radius on the first of them; those of masks with areas."""
    found: dict[str, tuple[bridge.Descriptor, float, list[color_maps.Weighted]]] = {}
    for mesh, name in shown:
        if not is_direction(name):
            row, radius = registry_row(name), record.read(mesh)["drawn"].get(name, {}).get("radius", 0.0)
            areas = mesh_io.areas_of_vertices(mesh) if row.name in color_maps.MASKS else None
            found.setdefault(row.name, (row, radius, []))[2].append((stored_values(mesh, name), areas))
    return list(found.values())


def register() -> None:
    """Makes color settings recolor the selected meshes."""
    looks.listen(on_look)


def unregister() -> None:
    """Ends the recoloring by color settings."""
    looks.ignore(on_look)


# Blender requires that Python keeps the strings of dynamic enum items alive.
_items: list[Item] = []


def name_items(_self: object, context: bpy.types.Context | None) -> list[Item]:
    """The baked descriptors of the panel's mesh, as enum items."""
    target = targets.first(context) if context is not None else None
    names = baked_names(target.data) if target is not None else []
    _items[:] = [(name, legend.label(name), "") for name in names]
    return _items or [("", "None", "")]


class PARADESC_OT_show(NeedsBake, bpy.types.Operator):
    """Show the colors of this descriptor on all selected meshes"""

    bl_idname = "paradesc.show"
    bl_label = "Show"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    name: bpy.props.EnumProperty(name="Descriptor", description="Descriptor whose colors are shown", items=name_items)

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Makes the descriptor's colors active on each mesh for which it was baked."""
        if self.name in baked_names(target.data):
            mesh_io.show(target.data, self.name)
            image_preview.hide(target)


class PARADESC_OT_view_colors(bpy.types.Operator):
    """Set this viewport to solid shading with the colors of attributes, in flat light"""

    bl_idname = "paradesc.view_colors"
    bl_label = "View Colors"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Works only in a viewport."""
        return context.area is not None and context.area.type == "VIEW_3D"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Changes only the shading of this viewport."""
        shading = context.space_data.shading
        shading.type = "SOLID"
        image_preview.hide()
        viewports.show_attributes(context.screen, shading, viewports.wanted(context))
        return {"FINISHED"}


class PARADESC_OT_restore_shading(bpy.types.Operator):
    """Restore the viewports to their state before the bake; the values stay on the mesh"""

    bl_idname = "paradesc.restore_shading"
    bl_label = "Restore Shading"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Works only if the former shading is known."""
        return viewports.can_restore(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Restores every viewport of this window."""
        viewports.restore(context.screen)
        return {"FINISHED"}


classes = (PARADESC_OT_recolor, PARADESC_OT_show, PARADESC_OT_view_colors, PARADESC_OT_restore_shading)
