"""Gives faces a material slot of ours, and restores theirs. Slots that the user has changed meanwhile stay."""

import bpy
import numpy as np

from ..scene import arrays, carrying
from . import tuned

# The face attribute with the former slot of each face.
FORMER_SLOTS = ".hide_paradesc_slots"
# The custom property of a mesh with the names of the materials in its former slots.
FORMER_NAMES = "paradesc_slots"
# The custom property of our materials with the descriptor that they show.
DESCRIPTOR = "paradesc_descriptor"


def own_slots(mesh: bpy.types.Mesh) -> list[int]:
    """The indices of slots with our materials."""
    return [index for index, item in enumerate(mesh.materials) if item is not None and DESCRIPTOR in item]


def shown_descriptor(target: bpy.types.Object) -> str:
    """The descriptor that an object's faces show with one of our materials, or ""."""
    found = own_slots(target.data)
    return target.data.materials[found[0]][DESCRIPTOR] if found else ""


def assign(mesh: bpy.types.Mesh, material: bpy.types.Material) -> list[str]:
    """Gives all faces a slot with this material, and remembers their former slots. Not in edit mode.

    Returns a note about a former material of ours that was kept because somebody had changed it.
    """
    found, notes = own_slots(mesh), []
    slots = former_slots(mesh, found)
    if FORMER_SLOTS in mesh.attributes:
        mesh.attributes.remove(mesh.attributes[FORMER_SLOTS])
    mesh.attributes.new(FORMER_SLOTS, "INT", "FACE").data.foreach_set("value", slots)
    mesh[FORMER_NAMES] = slot_names(mesh)
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


def former_slots(mesh: bpy.types.Mesh, ours: list[int]) -> np.ndarray:
    """(face_count,) int32 slots of faces, or the former ones of faces on our slots. Slots assigned since then stay.

    Slots that were moved since then are found by the names of their materials.
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
    """Gives the faces on our slots their former slots, and removes ours. Not in edit mode.

    Returns notes as assign() does.
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
    """Removes a slot. Objects keep their own materials in the slots after it."""
    sharing = carrying.sharing(mesh)
    kept = [[(one.link, one.material) for one in item.material_slots] for item in sharing]
    actives = [item.active_material_index for item in sharing]
    if len(mesh.materials) == 1 and not any(link == "OBJECT" for rows in kept for link, _ in rows):
        mesh.materials.clear()  # the last one that is popped leaves objects an empty slot
        return
    mesh.materials.pop(index=slot)
    for item, rows, active in zip(sharing, kept, actives, strict=True):
        for one, (link, material) in zip(item.material_slots, rows[:slot] + rows[slot + 1 :], strict=False):
            one.link = link
            if link == "OBJECT":
                one.material = material
        item.active_material_index = active - (active > slot)


def discard(material: bpy.types.Material | None) -> list[str]:
    """Removes an unused material of ours; one that somebody has changed is kept, and a note says so."""
    if material is None or material.users or DESCRIPTOR not in material:
        return []
    if tuned.is_as_left(material):
        bpy.data.materials.remove(material)
        return []
    material.use_fake_user = True  # Blender saves only what is used
    return [f'The material "{material.name}" was changed since it was made, so it is kept in the file.']
