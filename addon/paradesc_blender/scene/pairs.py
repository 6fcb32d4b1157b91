"""Finds which detailed meshes belong to which low-poly ones: by names, else selected ones to the active one."""

import bpy
import numpy as np
from mathutils import Vector

from paradesc.core import pair_names

from . import targets

Pairs = dict[bpy.types.Object, list[bpy.types.Object]]


def chosen(context: bpy.types.Context) -> Pairs:
    """The selected low-poly objects with their detailed ones. By names, unselected detailed objects count as well."""
    active = context.active_object
    if active is not None and active.mode != "OBJECT":
        return {}
    selected = targets.chosen(context)
    named = {}
    if any(pair_names.is_one_of_a_pair(item.name) for item in selected):
        found = by_name([item for item in context.view_layer.objects if item.type == "MESH"])
        named = {low: highs for low, highs in found.items() if low in selected or set(highs) & set(selected)}
    return named or ({active: selected[1:]} if len(selected) > 1 and selected[0] == active else {})


def meant(context: bpy.types.Context) -> Pairs:
    """The pairs, if the selection looks like one: by names, with two meshes, or if all overlap the active one.

    Forty props that stand in a row are not details of one of them.
    """
    found = chosen(context)
    if len(found) != 1:
        return found
    ((low, highs),) = found.items()
    if len(highs) == 1 or pair_names.is_one_of_a_pair(low.name):
        return found
    start, end = bounds(low)
    overlap = ((start <= last).all() and (first <= end).all() for first, last in map(bounds, highs))
    return found if all(overlap) else {}


def bounds(target: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """The (3,) minimum and maximum corners of an object's world-space bounding box."""
    corners = np.array([target.matrix_world @ Vector(corner) for corner in target.bound_box])
    return corners.min(axis=0), corners.max(axis=0)


def by_name(objects: list[bpy.types.Object]) -> Pairs:
    """The pairs among these objects."""
    named = {item.name: item for item in objects}
    found = pair_names.pairs_of(named)
    return {named[low]: [named[high] for high in highs] for low, highs in found.items()}
