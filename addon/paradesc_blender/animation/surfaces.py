"""Reads the surface that live values measure, which is the one that a bake of the same source measures.

A bake evaluates a mesh itself. Here, a view layer or a render has already evaluated it, and it may only be read.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import numpy as np

from paradesc.bridge import InputError, MeshArrays
from paradesc.core import source_kinds
from paradesc.core.job import Settings, needs_uvs
from paradesc.files.reading import Read

from ..scene import arrays, carrying, delivery, mesh_io, sculpt_masks, source_meshes
from ..settings.snapshot import identity

# Modifiers that only append vertices: the original ones come first, in their order (tested).
APPENDING = {"SUBSURF", "MULTIRES", "MIRROR", "SOLIDIFY", "ARRAY"}


@dataclass(frozen=True, eq=False)
class Surface:
    """The surface to measure. Its mesh exists only while shown() is open."""

    mesh: bpy.types.Mesh  # the mesh whose faces are measured
    generated: bool  # whether its faces may differ from those of the object's own mesh
    positions: np.ndarray  # (vertex_count, 3) float32
    posed: bpy.types.Mesh  # the same mesh at these positions, whose normals are used where the settings ask for them

    def read(self, target: bpy.types.Object, settings: Settings) -> Read:
        """The surface as arrays. The object's own mesh is read at rest."""
        wanted = (settings.options.normals == "mesh", needs_uvs(settings))
        if not self.generated:
            return Read(mesh_io.read_object(target, *wanted))
        made = source_meshes.read_made(target, self.mesh, *wanted)
        return Read(made, earlier=carrying.carried_values(target, self.mesh))

    def normals(self, settings: Settings) -> np.ndarray | None:
        """(corner_count, 3) float32 where the settings ask for them."""
        return mesh_io.read_corner_normals(self.posed) if settings.options.normals == "mesh" else None

    def has_corners_of(self, known: MeshArrays) -> bool:
        """Returns whether modifiers have made the same faces as before. Edits of other meshes are compared at rest."""
        return not self.generated or np.array_equal(arrays.read_corner_vertices(self.mesh), known.corner_vertices)


@contextmanager
def shown(
    target: bpy.types.Object, evaluated: bpy.types.Object, source: str, rendering: bool
) -> Iterator[Surface]:
    """The surface by its source, as the depsgraph of this evaluated object has it."""
    own = target.data
    still = source == source_kinds.ORIGINAL and not deforms(target, evaluated, rendering)
    if target.mode == "SCULPT" or still:
        yield Surface(own, False, own_positions(target), own)
        return
    if source == source_kinds.EVALUATED and changing(target, rendering):
        mesh = evaluated.to_mesh()
        try:
            generated = not source_meshes.same_vertices(mesh, own)
            yield Surface(mesh if generated else own, generated, mesh_io.read_positions(mesh), mesh)
        finally:
            evaluated.to_mesh_clear()
        return
    yield Surface(own, False, deformed_positions(target, evaluated, rendering), evaluated.data)


def source_of(scene: bpy.types.Scene) -> str:
    """The source that a bake uses. The choice "as shown" counts as "with modifiers".

    Values that follow an animation measure the base mesh as deformed, as they did before sources could be chosen.
    """
    chosen = scene.paradesc_animation.source
    return source_kinds.EVALUATED if chosen == source_kinds.AUTOMATIC else chosen


def own_positions(target: bpy.types.Object) -> np.ndarray:
    """(vertex_count, 3) float32 of the mesh before modifiers: of the shape key that is sculpted, or of the basis."""
    key = source_meshes.shape_key(target, active=target.mode == "SCULPT")
    return mesh_io.read_positions(target.data) if key is None else arrays.read_array(key.data, "co", np.float32, 3)


def deformed_positions(target: bpy.types.Object, evaluated: bpy.types.Object, rendering: bool) -> np.ndarray:
    """(vertex_count, 3) float32 of the original vertices in object space after all modifiers."""
    count, found = len(target.data.vertices), len(evaluated.data.vertices)
    if cuts(target, rendering) or (count != found and not appends(target, count, found, rendering)):
        raise lost(target)
    return mesh_io.read_positions(evaluated.data)[:count]


# ---- Original vertices


def places_of(target: bpy.types.Object, made: MeshArrays, rendering: bool) -> tuple[np.ndarray, bool]:
    """(original_count,) int64 vertex of the arrays that modifiers made for each original vertex; whether all are there.

    Vertices that modifiers keep are found by marks, as in a bake; a render cannot do so. Otherwise the nearest counts.
    """
    count, found = len(target.data.vertices), len(made.positions)
    if appends(target, count, found, rendering):
        return np.arange(count), True
    places = np.empty(0) if rendering else source_meshes.origins(target)
    if len(places) != count or (places < 0).any() or (places >= found).any():
        return delivery.nearest(target.data, made), False
    return places, True


def lost(target: bpy.types.Object) -> Exception:
    """The error for modifiers that take vertices away."""
    return InputError(f'The modifiers of "{target.name}" take vertices away, which Live needs: bake instead.')


def appends(target: bpy.types.Object, count: int, found: int, rendering: bool) -> bool:
    """Returns whether the modifiers in use keep all original vertices and only append others."""
    if cuts(target, rendering):
        return False
    return found >= count and all(item.type in APPENDING for item in changing(target, rendering))


def cuts(target: bpy.types.Object, rendering: bool) -> bool:
    """Returns whether a Mirror modifier with Bisect cuts vertices away. Their count may stay the same all the same."""
    return any(item.type == "MIRROR" and any(item.use_bisect_axis) for item in changing(target, rendering))


def deforms(target: bpy.types.Object, evaluated: bpy.types.Object, rendering: bool) -> bool:
    """Returns whether anything moves the vertices of the object's own mesh; nodes may do so if they keep the number."""
    own, kinds = target.data, {item.type for item in source_meshes.shown_modifiers(target, rendering)}
    moved = own.shape_keys is not None or own.animation_data is not None
    nodes = "NODES" in kinds and len(evaluated.data.vertices) == len(own.vertices)
    return moved or nodes or bool(kinds - source_meshes.GENERATING - {"NODES"})


def changing(target: bpy.types.Object, rendering: bool) -> list[bpy.types.Modifier]:
    """The modifiers in use that may change the vertices or faces of the object's own mesh."""
    kinds = {*source_meshes.GENERATING, "NODES"}
    return [item for item in source_meshes.shown_modifiers(target, rendering) if item.type in kinds]


# ---- Where there is none


def waiting_sentence(target: bpy.types.Object) -> str:
    """The reason why values wait in the mode of the object, or "".

    In edit mode and with dynamic topology Blender works on a copy of the mesh; vertex paint keeps tables of its own.
    """
    if target.data.is_editmode or target.mode == "VERTEX_PAINT":
        return "Values follow when this mode is left."
    if target.mode == "SCULPT" and target.use_dynamic_topology_sculpting:
        return "Values follow when dynamic topology is switched off."
    if target.mode == "SCULPT" and sculpt_masks.sculpts_multires(target):
        return "Values follow when sculpt mode is left, because Multires is sculpted."
    return ""


def evaluated_object(target: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bpy.types.Object | None:
    """The object in the depsgraph; None if it is missing there, or if its mesh is in edit mode."""
    if waiting_sentence(target):
        return None
    evaluated = target.evaluated_get(depsgraph)
    return evaluated if evaluated.is_evaluated and evaluated.type == "MESH" else None


def topology_of(
    target: bpy.types.Object, surface: Surface, settings: Settings, maps: bool
) -> tuple[object, ...]:
    """A summary that changes with most changes of a mesh except its positions, and is quick enough for every frame."""
    mesh = surface.mesh
    layer = mesh.uv_layers.active
    counts = (len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons))
    names = (surface.generated, "" if layer is None else layer.name, settings.options.normals)
    return (identity(target.data), *counts, *names, needs_uvs(settings), maps)
