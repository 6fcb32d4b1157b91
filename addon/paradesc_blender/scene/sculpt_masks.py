"""Reads and writes sculpt mode's mask, one float per vertex: an attribute since Blender 4.1, a data layer before."""

import bmesh
import bpy
import numpy as np

from paradesc.bridge import InputError

from . import modes
from .arrays import read_array

NAME = ".sculpt_mask"
IS_ATTRIBUTE = bpy.app.version >= (4, 1, 0)


def values(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """(n,) float32 of the mask, or None if the mesh has none."""
    stored = storage(mesh)
    return None if stored is None else read_array(stored.data, "value", np.float32)


def is_painted(mesh: bpy.types.Mesh) -> bool:
    """Returns whether any vertex is masked."""
    found = values(mesh)
    return found is not None and bool(found.any())


def write(target: bpy.types.Object, weights: np.ndarray) -> None:
    """Replaces the mask by (n,) weights, and creates its storage if it is missing."""
    mesh = target.data
    if storage(mesh) is None:
        make_storage(target)
    storage(mesh).data.foreach_set("value", np.ascontiguousarray(weights, np.float32))
    mesh.update()


def write_shown(target: bpy.types.Object, weights: np.ndarray) -> None:
    """Replaces the mask of the object in sculpt mode by (n,) weights. Hidden vertices keep theirs, as in Blender."""
    mesh = target.data
    if target.mode != "SCULPT" or len(mesh.vertices) != len(weights):
        raise InputError(f'The mesh "{mesh.name}" was changed while it was being measured; run it again.')
    hidden, old = mesh.attributes.get(".hide_vert"), values(mesh)
    if hidden is not None:
        weights = np.where(read_array(hidden.data, "value", bool), 0.0 if old is None else old, weights)
    if bpy.app.background:  # without undo, which Blender's own operators on the mask rely on
        with modes.object_mode(target):
            write(target, weights)
        return
    if storage(mesh) is None and not IS_ATTRIBUTE:
        # Blender 3 crashes if redo comes to a mask whose storage the step before does not have.
        bpy.ops.paint.mask_flood_fill(mode="VALUE", value=0.0)
        bpy.ops.ed.undo_push(message="Before Mask from Shape")
    # Adds a step with the former mask to sculpt mode's own undo stack, and creates the mask's storage.
    bpy.ops.paint.mask_flood_fill(mode="INVERT")
    write(target, weights)


def storage(mesh: bpy.types.Mesh) -> bpy.types.ID | None:
    """The attribute or data layer that holds the mask; None without one."""
    if IS_ATTRIBUTE:
        return mesh.attributes.get(NAME)
    return mesh.vertex_paint_masks[0] if len(mesh.vertex_paint_masks) else None


def make_storage(target: bpy.types.Object) -> None:
    """Creates an empty mask. This needs the mesh of edit mode if the mask is not an attribute."""
    if IS_ATTRIBUTE:
        target.data.attributes.new(NAME, "FLOAT", "POINT")
        return
    objects = bpy.context.view_layer.objects
    active, objects.active = objects.active, target
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        bmesh.from_edit_mesh(target.data).verts.layers.paint_mask.verify()
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
        objects.active = active


def sculpts_multires(target: bpy.types.Object) -> bool:
    """Returns whether strokes change the levels of Multires, which add-ons cannot access."""
    shown = (item for item in target.modifiers if item.type == "MULTIRES" and item.show_viewport)
    return any(item.sculpt_levels > 0 and not item.use_sculpt_base_mesh for item in shown)


def multires_obstacle(target: bpy.types.Object) -> str:
    """A sentence with the remedy if the mask belongs to the levels of Multires, else ""."""
    if sculpts_multires(target):
        return "Add-ons cannot reach the mask of Multires: apply the modifier, or set its Sculpt level to 0"
    return ""
