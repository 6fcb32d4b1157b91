"""Finds the meshes to bake from the selection, each once, or the reasons why they cannot be baked; and reads them."""

import bpy
import numpy as np

from paradesc import bridge
from paradesc.bridge import InputError, ParadescError, abi
from paradesc.core import job, source_kinds, spaces
from paradesc.files.reading import Read, ReadRequest

from . import carrying, mesh_io, source_meshes, surface_maps
from .arrays import read_array

# The types of objects with a surface that must be converted to a mesh first.
CONVERTIBLE = ("CURVE", "SURFACE", "FONT", "META")
# The modes in which the mesh can be read, and which can be left and entered again.
MODES = {"OBJECT", "EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"}


def chosen(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The mesh objects that a bake takes: the selected ones, active first; outside object mode, those in the mode.

    If no mesh is selected, it is the active object, or the only mesh below an active armature or empty, which importers
    make active.
    """
    active = context.active_object
    if active is not None and active.type == "MESH" and active.mode == "EDIT":
        edited = [item for item in context.view_layer.objects if item.type == "MESH" and item.mode == "EDIT"]
        return sorted(edited, key=lambda item: item != active)
    if active is not None and active.mode != "OBJECT":
        return [active] if active.type == "MESH" else []
    selected = getattr(context, "selected_objects", None)  # a script may have put them there; handlers have none
    if selected is None:
        selected = context.view_layer.objects.selected
    found = [item for item in selected if is_measured(item)]
    if not found and active is not None:
        carried = [active] if active.type == "MESH" else [*active.children_recursive]
        meshes = [item for item in carried if is_measured(item)]
        return meshes if len(meshes) == 1 else []
    return sorted(found, key=lambda item: item != active)


def is_measured(item: bpy.types.Object) -> bool:
    """Returns whether an object is a mesh, and not one of ours that only holds values."""
    return item.type == "MESH" and not carrying.is_carrier(item)


def first(context: bpy.types.Context) -> bpy.types.Object | None:
    """The mesh object that panels and buttons refer to: the first one that a bake takes; None if there is none.

    Without a window, as when timers run, there is no active object, and nobody looks at one.
    """
    return next(iter(chosen(context)), None) if hasattr(context, "active_object") else None


def skipped(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected objects that a bake leaves out because they have a surface but are not meshes."""
    active = context.active_object
    if active is not None and active.mode != "OBJECT":
        return []
    return [item for item in context.selected_objects if item.type in CONVERTIBLE]


def unconvertible(item: bpy.types.Object) -> str:
    """One sentence about why a text, curve, surface or metaball object cannot be converted to a mesh, or ""."""
    if item.library is not None or item.data.library is not None or item.override_library is not None:
        return f'The object "{item.name}" is linked from another file; make it local first.'
    if item.type == "META":
        return ""  # one of a family of metaballs has the whole mesh
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    empty = mesh is None or not mesh.polygons
    evaluated.to_mesh_clear()
    return f'The object "{item.name}" has no faces: give the curve a bevel or an extrusion first.' if empty else ""


def by_mesh(targets: list[bpy.types.Object]) -> list[list[bpy.types.Object]]:
    """The objects grouped by the mesh that they share."""
    groups: dict[bpy.types.Mesh, list[bpy.types.Object]] = {}
    for target in targets:
        groups.setdefault(target.data, []).append(target)
    return list(groups.values())


def leave(mode: str) -> str:
    """The sentence about a mode that stands in the way."""
    return f"Leave {mode.replace('_', ' ').lower()} mode first"


def hidden(context: bpy.types.Context) -> str:
    """One sentence about an active object that cannot leave its mode because it is hidden, or ""."""
    active = context.active_object
    stuck = active is not None and active.mode != "OBJECT" and not bpy.ops.object.mode_set.poll()
    return "Show the hidden object first" if stuck else ""


def reading_obstacle(context: bpy.types.Context) -> str:
    """One sentence about why no mesh can be read now, or ""."""
    missing = bridge.missing_sentence()
    if missing:
        return missing
    active = context.active_object
    if active is not None and active.mode != "OBJECT" and (active.type != "MESH" or active.mode not in MODES):
        return leave(active.mode)
    if hidden(context):
        return hidden(context)
    targets = chosen(context)
    if not targets:
        return "Convert the selected objects to meshes first" if skipped(context) else "Select a mesh object first"
    for target in targets:
        if target.mode == "SCULPT" and target.use_dynamic_topology_sculpting:
            return "Turn off Dyntopo or leave sculpt mode first"
    return ""


def obstacle(context: bpy.types.Context) -> str:
    """One sentence about why nothing can be baked now, or ""."""
    sentence = reading_obstacle(context)
    if sentence:
        return sentence
    refused = [mesh_io.unwritable(target) for target in chosen(context)]
    return refused[0] if all(refused) else ""


# ---- Reading


def read(target: bpy.types.Object, settings: job.Settings, request: ReadRequest) -> Read:
    """The object's mesh by its source, before or after modifiers; the mesh stays as it is."""
    source = request.source
    if source == source_kinds.AUTOMATIC:
        source = shown_source(target, request.shape_key)
    needs_uvs = job.needs_uvs(settings, request.buffers)
    found = source_meshes.read(target, source, settings.options.normals == "mesh", needs_uvs, placing=request.placing)
    found.source_notes = list(found.notes)
    if found.source == "original":
        found.notes += take_shape(target, found.arrays, request.shape_key)
    found.map_notes = surface_maps.add_maps(target, found.arrays, request.maps)
    maps = found.arrays.maps
    if maps is not None and maps.normals is not None and found.source != "original":
        base = source_meshes.BASE
        raise InputError(f"A normal map belongs to the base mesh; choose the source {base}, or leave the map out.")
    in_space = (target.matrix_world, target.name, settings.space, request.remedy)
    found.measured, found.warnings = spaces.measured(found.arrays, *in_space)
    return found


def shown_source(target: bpy.types.Object, shape_key: str = "basis") -> str:
    """The source of the surface in the viewport: the base mesh unless modifiers or shape keys change it there."""
    changes = bool(source_meshes.shown_modifiers(target)) or (shape_key == "basis" and shows_shape_key(target))
    return source_kinds.EVALUATED if changes else source_kinds.ORIGINAL


def shows_shape_key(target: bpy.types.Object) -> bool:
    """Returns whether the viewport shows another shape than the keys' basis, or than the one that is edited."""
    keys = target.data.shape_keys
    if keys is None or source_meshes.is_edited(target):
        return False
    if not keys.use_relative:
        return keys.eval_time != keys.reference_key.frame
    return target.show_only_shape_key or any(block.value != 0 and not block.mute for block in keys.key_blocks[1:])


def take_shape(target: bpy.types.Object, arrays: bridge.MeshArrays, shape: str) -> list[str]:
    """Takes the positions of the chosen shape key, or of the edited one; returns a note if another shape is shown."""
    key = source_meshes.shape_key(target, active=shape == "active" or source_meshes.is_edited(target))
    if key is None:
        return []
    if len(key.data) != len(arrays.positions):
        sentence = f'The shape key "{key.name}" does not fit its mesh "{target.data.name}"; leave edit mode first.'
        raise ParadescError(abi.STATUS_INVALID_OPERATION, sentence)
    arrays.positions = read_array(key.data, "co", np.float32, 3)
    if key != target.data.shape_keys.reference_key:
        return [f'The shape key "{key.name}" was measured, at its full value.']
    if shows_shape_key(target):
        return [f'The mesh "{target.data.name}" has shape keys; the basis was measured, not the shape that is shown.']
    return []


def shared_note(sharing: list[bpy.types.Object], space: str = "world", source: str = "original") -> list[str]:
    """A note about which object was measured, if objects share a mesh but not its modifiers or scale."""
    first, *others = sharing
    if others and source != source_kinds.ORIGINAL:
        return [f'{len(sharing)} objects share the mesh "{first.data.name}"; it was measured on "{first.name}".']
    if space != "world":
        return []
    own = np.sort(spaces.scales(first.matrix_world))
    if all(np.allclose(own, np.sort(spaces.scales(item.matrix_world)), rtol=spaces.EVEN) for item in others):
        return []
    return [
        f'{len(sharing)} objects share the mesh "{first.data.name}" at different scales; it was measured as '
        f'"{first.name}" stands in the world.'
    ]
