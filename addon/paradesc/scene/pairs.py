"""Finds which meshes give their detail to which: by their names, else the selected ones to the active one."""

import bpy

from ..core import pair_names, transfer
from . import mesh_io, targets


def chosen(context: bpy.types.Context) -> dict[bpy.types.Object, list[bpy.types.Object]]:
    """The low-poly objects of the selection with their detailed ones, which names may find unselected ones for."""
    active = context.active_object
    if active is not None and active.mode != "OBJECT":
        return {}
    selected = targets.chosen(context)
    if any(pair_names.is_one_of_a_pair(item.name) for item in selected):
        named = by_name([item for item in context.view_layer.objects if item.type == "MESH"])
        found = {low: highs for low, highs in named.items() if low in selected or set(highs) & set(selected)}
        if found:
            return found
    return {active: selected[1:]} if len(selected) > 1 and selected[0] == active else {}


def by_name(objects: list[bpy.types.Object]) -> dict[bpy.types.Object, list[bpy.types.Object]]:
    """The pairs among these objects."""
    named = {item.name: item for item in objects}
    found = pair_names.pairs_of(named)
    return {named[low]: [named[high] for high in highs] for low, highs in found.items()}


def part_of(target: bpy.types.Object, read: targets.Read) -> transfer.Part:
    """The object as it stands in the world, as it was read."""
    return transfer.Part(target.name, read.arrays, read.measured, mesh_io.world_matrix(target))
