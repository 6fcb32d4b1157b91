"""Gives faces a slot of ours and takes it back: what the user has assigned, linked or tuned meanwhile stays."""

import bpy
import numpy as np

from ..scene import arrays
from . import tuned

# The face attribute that remembers which slot each face had before.
FORMER_SLOTS = ".hide_paradesc_slots"
# The custom property of a mesh with the names of the materials that its slots had then.
FORMER_NAMES = "paradesc_slots"
# The custom property of our materials that names the descriptor they show.
DESCRIPTOR = "paradesc_descriptor"


def own_slots(mesh: bpy.types.Mesh) -> list[int]:
    """The slots that hold our materials."""
    return [index for index, item in enumerate(mesh.materials) if item is not None and DESCRIPTOR in item]


def shown_descriptor(target: bpy.types.Object) -> str:
    """The descriptor that an object's faces show by one of our materials, or ""."""
    found = own_slots(target.data)
    return target.data.materials[found[0]][DESCRIPTOR] if found else ""


def assign(mesh: bpy.types.Mesh, material: bpy.types.Material) -> list[str]:
    """Gives all faces a slot with this material and remembers which slots they had. Not in edit mode.

    Gives a sentence about a material of ours that was there before and stays, because it was changed.
    """
    found, notes = own_slots(mesh), []
    keep_slots(mesh, found)
    if found:
        slot, former = found[0], mesh.materials[found[0]]
        mesh.materials[slot] = material
        notes = discard(former)
    else:
        mesh.materials.append(material)
        slot = len(mesh.materials) - 1
    mesh.polygons.foreach_set("material_index", np.full(len(mesh.polygons), slot, np.int32))
    mesh.update()
    return notes


def keep_slots(mesh: bpy.types.Mesh, ours: list[int]) -> None:
    """Remembers the faces' slots; of faces on ours, those that they had before."""
    slots = former_slots(mesh, ours)
    if FORMER_SLOTS in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[FORMER_SLOTS])
    attribute = mesh.attributes.new(FORMER_SLOTS, "INT", "FACE")
    attribute.data.foreach_set("value", slots)
    mesh[FORMER_NAMES] = slot_names(mesh)


def former_slots(mesh: bpy.types.Mesh, ours: list[int]) -> np.ndarray:
    """(face_count,) int32 slots that faces have, or had before they got ours; those given to them since stay.

    Slots that were moved since are found by the names of their materials.
    """
    slots = arrays.read_array(mesh.polygons, "material_index", np.int32)
    attribute, before, now = mesh.attributes.get(FORMER_SLOTS), list(mesh.get(FORMER_NAMES, [])), slot_names(mesh)
    if attribute is None or arrays.kind_of(attribute) != ("INT", "FACE"):
        return slots
    former = arrays.read_array(attribute.data, "value", np.int32)
    place = np.arange(max(len(before), former.max(initial=0) + 1), dtype=np.int32)
    for slot, name in enumerate(before):
        if slot >= len(now) or now[slot] != name:
            place[slot] = now.index(name) if name in now else min(slot, max(len(now) - 1, 0))
    return np.where(np.isin(slots, ours), place[np.maximum(former, 0)], slots).astype(np.int32)


def slot_names(mesh: bpy.types.Mesh) -> list[str]:
    """The names of the materials in the slots."""
    return ["" if item is None else item.name for item in mesh.materials]


def take_back(mesh: bpy.types.Mesh) -> list[str]:
    """Gives the faces on our slots their former ones again, and removes ours. Not in edit mode.

    Gives sentences as assign() does.
    """
    ours = own_slots(mesh)
    mesh.polygons.foreach_set("material_index", former_slots(mesh, ours))
    if FORMER_SLOTS in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[FORMER_SLOTS])
    if FORMER_NAMES in mesh:
        del mesh[FORMER_NAMES]
    notes = []
    for slot in reversed(ours):
        former = mesh.materials[slot]
        remove_slot(mesh, slot)
        notes += discard(former)
    mesh.update()
    return notes


def remove_slot(mesh: bpy.types.Mesh, slot: int) -> None:
    """Removes a slot; objects keep the materials that they themselves have in the slots behind it."""
    sharing = [item for item in bpy.data.objects if item.data == mesh and item.library is None]
    kept = [[(one.link, one.material) for one in item.material_slots] for item in sharing]
    actives = [item.active_material_index for item in sharing]
    mesh.materials.pop(index=slot)  # objects keep a slot, though an empty one, when it was the last
    for item, rows, active in zip(sharing, kept, actives, strict=True):
        for one, (link, material) in zip(item.material_slots, rows[:slot] + rows[slot + 1 :], strict=False):
            one.link = link
            if link == "OBJECT":
                one.material = material
        item.active_material_index = active - (active > slot)


def discard(material: bpy.types.Material | None) -> list[str]:
    """Removes one of our materials that nothing uses any more; one that was changed stays, and a sentence says so."""
    if material is None or material.users or DESCRIPTOR not in material:
        return []
    if tuned.is_as_left(material):
        bpy.data.materials.remove(material)
        return []
    material.use_fake_user = True  # Blender saves only what is used
    return [f'The material "{material.name}" was changed since it was made, and stays in the file.']
