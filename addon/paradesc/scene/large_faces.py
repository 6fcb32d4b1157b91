"""Tells whether faces of objects are too large for vertex colors, quickly enough for a panel to ask at each draw."""

from collections.abc import Sequence

import bpy
import numpy as np

from ..core import large_faces, source_kinds
from . import source_meshes, targets
from .arrays import read_array

# A mesh with more faces than this is fine enough.
MOST_FACES = 200_000
# The answers of late, by what tells meshes apart without reading them.
_found: dict[tuple, bool] = {}
MOST_KEPT = 256
# So many of the selected meshes are asked.
MOST_ASKED = 32


def of_chosen(context: bpy.types.Context) -> bool:
    """Whether that is so of the meshes that a bake takes, as it measures them; the first ones tell."""
    return every(targets.chosen(context)[:MOST_ASKED], context.scene.paradesc_animation.source)


def every(objects: Sequence[bpy.types.Object], source: str) -> bool:
    """Whether that is so of all these objects, of which there is one at least, as this source has them."""
    return bool(objects) and all(are_too_large(target, source) for target in objects)


def are_too_large(target: bpy.types.Object, source: str) -> bool:
    """Whether that is so of one; outside of object mode people change a mesh, or want its colors."""
    if target.mode != "OBJECT" or len(target.data.polygons) > MOST_FACES:
        return False
    modifiers = [] if source == source_kinds.ORIGINAL else source_meshes.shown_modifiers(target)
    shown = target.evaluated_get(bpy.context.evaluated_depsgraph_get()) if modifiers else target
    key = (
        target.data.as_pointer(),
        *map(counts, (target.data, shown.data)),
        *((item.type, getattr(item, "levels", 0)) for item in modifiers),
    )
    if key not in _found:
        if len(_found) >= MOST_KEPT:
            _found.clear()
        _found[key] = measured(shown)
    return _found[key]


def counts(mesh: bpy.types.Mesh) -> tuple[int, int]:
    """The numbers that are quick to ask of a mesh and seldom stays when it becomes another."""
    return len(mesh.vertices), len(mesh.polygons)


def measured(shown: bpy.types.Object) -> bool:
    """Reads a mesh and tells."""
    mesh = shown.to_mesh()
    try:
        if len(mesh.polygons) > MOST_FACES:
            return False
        mesh.calc_loop_triangles()
        triangles = read_array(mesh.loop_triangles, "vertices", np.int32, 3)
        return large_faces.are_too_large(read_array(mesh.vertices, "co", np.float32, 3), triangles)
    finally:
        shown.to_mesh_clear()
