"""Finds which meshes give their detail to which: by their names, else the selected ones to the active one."""

import bpy
import numpy as np
from mathutils import Vector

from ..core import pair_names, transfer
from . import mesh_io, targets

Pairs = dict[bpy.types.Object, list[bpy.types.Object]]


def chosen(context: bpy.types.Context) -> Pairs:
    """The low-poly objects of the selection with their detailed ones, which names may find unselected ones for."""
    active = context.active_object
    if active is not None and active.mode != "OBJECT":
        return {}
    selected = targets.chosen(context)
    named = named_among(context, selected)
    return named or ({active: selected[1:]} if len(selected) > 1 and selected[0] == active else {})


def meant(context: bpy.types.Context) -> Pairs:
    """The same where the selection looks like a pair: by names, or two meshes, or all others lie about the active one.

    Forty props that stand in a row are no detail of one of them.
    """
    found = chosen(context)
    if len(found) != 1:
        return found
    ((low, highs),) = found.items()
    is_pair = len(highs) == 1 or pair_names.is_one_of_a_pair(low.name) or all(overlap(low, high) for high in highs)
    return found if is_pair else {}


def overlap(first: bpy.types.Object, second: bpy.types.Object) -> bool:
    """Whether the boxes that two objects have along the world's axes overlap."""
    (low, high), (other_low, other_high) = bounds(first), bounds(second)
    return bool((low <= other_high).all() and (other_low <= high).all())


def bounds(target: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """(3,) the least and the largest corner of an object's box along the world's axes."""
    corners = np.array([target.matrix_world @ Vector(corner) for corner in target.bound_box])
    return corners.min(axis=0), corners.max(axis=0)


def named_among(context: bpy.types.Context, selected: list[bpy.types.Object]) -> Pairs:
    """The pairs by name of which a part is selected."""
    if not any(pair_names.is_one_of_a_pair(item.name) for item in selected):
        return {}
    named = by_name([item for item in context.view_layer.objects if item.type == "MESH"])
    return {low: highs for low, highs in named.items() if low in selected or set(highs) & set(selected)}


def by_name(objects: list[bpy.types.Object]) -> Pairs:
    """The pairs among these objects."""
    named = {item.name: item for item in objects}
    found = pair_names.pairs_of(named)
    return {named[low]: [named[high] for high in highs] for low, highs in found.items()}


def part_of(target: bpy.types.Object, read: targets.Read) -> transfer.Part:
    """The object as it stands in the world, as it was read."""
    return transfer.Part(target.name, read.arrays, read.measured, mesh_io.world_matrix(target))
