"""Copies stored values to other places on request: packed channels, face corners, a vertex group, the sculpt mask.

Or a copy of the whole object, with its modifiers applied.
"""

import bpy
import numpy as np

from paradesc.bridge import InputError
from paradesc.core import color_maps
from paradesc.core.job import registry_row

from ..scene import arrays, delivery, ownership, record, sculpt_masks, targets
from ..settings import translation
from ..settings.looks import CHANNELS, PACKED_DOMAINS
from . import recolor

# The custom property of a mesh with the attributes and vertex groups that this module made and may overwrite.
OWN = "paradesc_made"
SUFFIX_CORNER = "_corner_color"
EXPORT_PREFIX = "_"


# ---- What is ours


def own_names(mesh: bpy.types.Mesh, kind: str) -> list[str]:
    """The names that this module made; kind is "attributes" or "groups"."""
    names = record.kept(mesh, OWN).get(kind)
    return [name for name in names if isinstance(name, str)] if isinstance(names, list) else []


def remember(mesh: bpy.types.Mesh, kind: str, name: str) -> None:
    """Notes on the mesh that this name is ours; ownership keeps the fingerprint of its values."""
    kept = {each: own_names(mesh, each) for each in ("attributes", "groups")}
    kept[kind] = sorted({*kept[kind], name})
    mesh[OWN] = {each: names for each, names in kept.items() if names}


def is_own(mesh: bpy.types.Mesh, attribute: bpy.types.Attribute) -> bool:
    """Returns whether this module made the attribute, and nobody has painted on it since."""
    if attribute.name not in own_names(mesh, "attributes") or attribute.data_type not in arrays.MEMBERS:
        return False
    values, faces = arrays.attribute_values(attribute), ownership.faces_of(mesh)
    return ownership.is_untouched(mesh, attribute.name, values, faces)


def own_attribute(mesh: bpy.types.Mesh, name: str, kind: str, domain: str) -> bpy.types.Attribute:
    """The attribute of this name, made again if type or domain differ. Raises if it is not ours and unchanged."""
    if not name:
        raise InputError("The attribute has no name; give it one.")
    attribute = mesh.attributes.get(name)
    if name in mesh.uv_layers or (attribute is not None and not is_own(mesh, attribute)):
        raise InputError(
            f'The mesh "{mesh.name}" has an attribute "{name}" that was not made here, or was changed since; rename '
            "it, or choose another name."
        )
    if attribute is not None and arrays.kind_of(attribute) != (kind, domain):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = mesh.attributes.new(name, kind, domain)
    if attribute is None or attribute.name != name:
        if attribute is not None:
            mesh.attributes.remove(attribute)
        raise InputError(f'The name "{name}" is taken on the mesh "{mesh.name}"; choose another.')
    remember(mesh, "attributes", name)
    return attribute


# ---- Values


def shares(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    """(n,) float32 in [0, 1]: a descriptor relative to the range of its colors, any other attribute unchanged.

    An undefined value becomes neutral, or 0.
    """
    attribute = mesh.attributes.get(name)
    if attribute is None or arrays.kind_of(attribute) != ("FLOAT", "POINT"):
        raise InputError(f'The mesh "{mesh.name}" has no values "{name}" with one float per vertex.')
    values = arrays.attribute_values(attribute)
    defined = np.isfinite(values)
    if name not in recolor.baked_names(mesh):
        return np.clip(np.where(defined, values, 0), 0, 1).astype(np.float32)
    shown = recolor.stored_range(mesh, name)
    neutral = color_maps.neutral_value(registry_row(name), color_maps.Look(neutral=shown.neutral))
    empty = shown.minimum if neutral is None else neutral
    scaled = (np.where(defined, values, empty) - shown.minimum) / (shown.maximum - shown.minimum)
    return np.clip(scaled, 0, 1).astype(np.float32)


def spread(mesh: bpy.types.Mesh, values: np.ndarray, domain: str) -> np.ndarray:
    """(n, k) values at vertices, copied to face corners if that is the domain."""
    return values if domain == "POINT" else values[arrays.read_corner_vertices(mesh)]


# ---- Copies


def corner_colors(mesh: bpy.types.Mesh, name: str) -> str:
    """Copies a descriptor's colors to face corners in 8 bits, like vertex paint; returns the attribute's name."""
    colors = arrays.read_array(mesh.attributes[f"{name}_color"].data, "color", np.float32, 4)
    attribute = own_attribute(mesh, name + SUFFIX_CORNER, "BYTE_COLOR", "CORNER").name
    arrays.set_values(mesh.attributes[attribute], spread(mesh, colors, "CORNER"))
    ownership.leave(mesh, [attribute])
    mesh.update()
    return attribute


def is_own_group(target: bpy.types.Object, group: bpy.types.VertexGroup) -> bool:
    """Returns whether this module made the vertex group, and nobody has painted its weights since."""
    mesh = target.data
    if group.name not in own_names(mesh, "groups"):
        return False
    weights = np.full(len(mesh.vertices), np.nan, np.float32)
    for vertex in mesh.vertices:
        for one in vertex.groups:
            if one.group == group.index:
                weights[vertex.index] = one.weight
    return ownership.is_untouched(mesh, f":{group.name}", weights, ownership.faces_of(mesh))


def export_copies(mesh: bpy.types.Mesh) -> list[str]:
    """Copies all values under names with an underscore, as glTF needs them; undefined ones become neutral."""
    made = []
    for name in recolor.baked_names(mesh):
        if recolor.is_direction(name):
            continue
        values = recolor.stored_values(mesh, name)
        neutral = color_maps.neutral_value(registry_row(name), color_maps.Look())
        values = np.where(np.isfinite(values), values, neutral or 0.0)
        attribute = own_attribute(mesh, EXPORT_PREFIX + name, "FLOAT", "POINT").name
        arrays.set_values(mesh.attributes[attribute], values)
        made.append(attribute)
    ownership.leave(mesh, made)
    mesh.update()
    return made


# ---- Operators


class NeedsShown(recolor.NeedsBake):
    """Base of operators that use the descriptor whose colors are shown."""

    bl_options = {"REGISTER", "UNDO"}

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Runs on the descriptor with the active colors, else on the first one."""
        name = recolor.shown_name(target.data) or recolor.baked_names(target.data)[0]
        self.report({"INFO"}, self.write(target, name))


class PARADESC_OT_pack(recolor.NeedsBake, bpy.types.Operator):
    """Write up to four values into the channels of one color attribute, each from 0 to 1 over its range"""

    bl_idname = "paradesc.pack"
    bl_label = "Pack Channels"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Packs the attributes that the scene's settings name; a channel without a name is 0, or 1 in alpha."""
        group, mesh = context.scene.paradesc_looks, target.data
        names = [getattr(group, f"pack_{channel}") for channel in CHANNELS]
        if not any(names):
            raise InputError("No channel has values; choose a descriptor for at least one.")
        rgba = np.zeros((len(mesh.vertices), 4), np.float32)
        rgba[:, 3] = 1.0
        for channel, name in enumerate(names):
            if name:
                rgba[:, channel] = shares(mesh, name)
        own_attribute(mesh, group.pack_name, group.pack_kind, group.pack_domain)
        arrays.set_values(mesh.attributes[group.pack_name], spread(mesh, rgba, group.pack_domain))
        ownership.leave(mesh, [group.pack_name])
        mesh.update()
        words = translation.label({item[0]: item[1] for item in PACKED_DOMAINS}[group.pack_domain]).lower()
        sentence = translation.said('Packed into "{name}", one color per {place}')
        self.report({"INFO"}, sentence.format(name=group.pack_name, place=words))


class PARADESC_OT_corner_colors(NeedsShown, bpy.types.Operator):
    """Copy the shown colors to face corners in 8 bits, for vertex paint and older exporters"""

    bl_idname = "paradesc.corner_colors"
    bl_label = "Corner Colors"

    def write(self, target: bpy.types.Object, name: str) -> str:
        """Makes the attribute."""
        return translation.said('Wrote the color attribute "{name}"').format(name=corner_colors(target.data, name))


class PARADESC_OT_vertex_group(NeedsShown, bpy.types.Operator):
    """Write the values shown as weights of a vertex group, from 0 to 1 over their range"""

    bl_idname = "paradesc.vertex_group"
    bl_label = "Vertex Group"

    def write(self, target: bpy.types.Object, name: str) -> str:
        """Makes or fills the group of the descriptor's name."""
        mesh, group = target.data, target.vertex_groups.get(name)
        if group is not None and not is_own_group(target, group):
            raise InputError(
                f'The object "{target.name}" has a vertex group "{name}" that was not made here, or was changed '
                "since; rename it first."
            )
        weights = shares(mesh, name)
        active = target.vertex_groups.active_index
        if group is None:
            group = target.vertex_groups.new(name=name)
            if active >= 0:
                target.vertex_groups.active_index = active
        remember(mesh, "groups", name)
        for vertex, weight in enumerate(weights.tolist()):
            group.add((vertex,), weight, "REPLACE")
        ownership.leave_weights(mesh, name, weights)
        return translation.said('Wrote the vertex group "{name}"').format(name=name)


class PARADESC_OT_sculpt_mask(NeedsShown, bpy.types.Operator):
    """Write the values shown as the mask of sculpt mode, from 0 to 1 over their range; 1 is protected"""

    bl_idname = "paradesc.sculpt_mask"
    bl_label = "Sculpt Mask"

    replace: bpy.props.BoolProperty(
        name="Replace", description="Replace an existing mask", default=False, options={"SKIP_SAVE"}
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Asks before a painted mask is replaced."""
        if not self.replace and sculpt_masks.is_painted(targets.first(context).data):
            self.replace = True
            return context.window_manager.invoke_confirm(self, event)
        return self.execute(context)

    def write(self, target: bpy.types.Object, name: str) -> str:
        """Fills the mask."""
        weights = shares(target.data, name)
        if sculpt_masks.is_painted(target.data) and not self.replace:
            raise InputError(
                f'The mesh "{target.data.name}" has a sculpt mask; allow replacing it, or clear it in sculpt mode '
                "first."
            )
        sculpt_masks.write(target, weights)
        return translation.said("Wrote {name} into the sculpt mask").format(name=name)


class PARADESC_OT_export_copies(recolor.NeedsBake, bpy.types.Operator):
    """Copy all values to attributes whose names begin with an underscore, which the glTF exporter includes"""

    bl_idname = "paradesc.export_copies"
    bl_label = "Copies for glTF"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Makes or fills the copies."""
        names = ", ".join(export_copies(target.data))
        self.report({"INFO"}, translation.said("Wrote {names}").format(names=names))


class PARADESC_OT_make_result_object(recolor.NeedsBake, bpy.types.Operator):
    """Make a copy with all modifiers applied and every mask on its vertices; it is selected, and the original hidden"""

    bl_idname = "paradesc.make_result_object"
    bl_label = "Copy with Values"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Works only in object mode, where the selection can change."""
        active = context.active_object
        mode = "OBJECT" if active is None else active.mode
        return translation.can_run(cls, "" if mode == "OBJECT" else targets.leave(mode)) and super().poll(context)

    def run(self, context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Makes one copy and hides its original in the viewport and in renders."""
        copy = delivery.copy_with_values(target)
        if context.view_layer.objects.active == target:
            context.view_layer.objects.active = copy
        copy.select_set(True)
        target.select_set(False)
        target.hide_set(True)
        target.hide_render = True
        names = {"copy": copy.name, "name": target.name}
        sentence = translation.said('"{copy}" has the modifiers applied and all masks; "{name}" is hidden')
        self.report({"INFO"}, sentence.format(**names))


classes = (
    PARADESC_OT_pack,
    PARADESC_OT_corner_colors,
    PARADESC_OT_vertex_group,
    PARADESC_OT_sculpt_mask,
    PARADESC_OT_export_copies,
    PARADESC_OT_make_result_object,
)
