"""Tells whether an object's faces are too large for vertex colors, fast enough for a panel that asks at each draw."""

from collections.abc import Sequence

import bpy
import numpy as np

from paradesc.core import large_faces, source_kinds

from . import source_meshes, targets
from .arrays import read_array

# A mesh with more faces than this is always fine enough.
MOST_FACES = 200_000
# Recent answers, by facts that tell meshes apart without reading them.
_found: dict[tuple, bool] = {}
MOST_KEPT = 256
# At most so many of the selected meshes are checked.
MOST_ASKED = 32


def of_chosen(context: bpy.types.Context) -> bool:
    """Tells whether faces are too large on the meshes that a bake takes, as it measures them; checks the first only."""
    return every(targets.chosen(context)[:MOST_ASKED], context.scene.paradesc_animation.source)


def every(objects: Sequence[bpy.types.Object], source: str) -> bool:
    """Returns whether faces of all these objects, at least one, are too large as this source measures them.

    They are never too large in other modes than object mode, in which people work.
    """
    return bool(objects) and all(target.mode == "OBJECT" and are_too_large(target, source) for target in objects)


def are_too_large(target: bpy.types.Object, source: str) -> bool:
    """Tells whether an object's faces are too large, as this source measures them in the object's mode."""
    if len(target.data.polygons) > MOST_FACES:
        return False
    is_base = source == source_kinds.ORIGINAL or source_meshes.is_edited(target)
    modifiers = [] if is_base else source_meshes.shown_modifiers(target)
    shown = target.evaluated_get(bpy.context.evaluated_depsgraph_get()) if modifiers else target
    # Counts are quick to get and seldom stay the same when a mesh changes.
    counts = ((len(mesh.vertices), len(mesh.polygons)) for mesh in (target.data, shown.data))
    levels = ((item.type, getattr(item, "levels", 0)) for item in modifiers)
    key = (target.data.as_pointer(), *counts, *levels)
    if key not in _found:
        if len(_found) >= MOST_KEPT:
            _found.clear()
        _found[key] = measured(shown)
    return _found[key]


def measured(shown: bpy.types.Object) -> bool:
    """Reads the evaluated mesh and tells whether its faces are too large."""
    mesh = shown.to_mesh()
    try:
        if len(mesh.polygons) > MOST_FACES:
            return False
        mesh.calc_loop_triangles()
        triangles = read_array(mesh.loop_triangles, "vertices", np.int32, 3)
        return large_faces.are_too_large(read_array(mesh.vertices, "co", np.float32, 3), triangles)
    finally:
        shown.to_mesh_clear()
