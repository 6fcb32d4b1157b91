"""Brings results back to an object: to its own vertices, and to those that its modifiers make."""

from dataclasses import replace

import bpy
import mathutils
import numpy as np

from paradesc.bridge import MeshArrays
from paradesc.core.job import Results
from paradesc.files.reading import Read, on_original

from . import carrying, mesh_io, modes, ownership, record
from .arrays import set_values
from .unwrap import fill

COPY_SUFFIX = "_paradesc"


def deliver(target: bpy.types.Object, results: Results, read: Read | None = None) -> list[str]:
    """Writes the results where they belong, or nothing on failure; returns notes about what was kept beside them.

    Those of a generated mesh are carried to it. The object's own vertices get their values, or the nearest ones.
    """
    mesh_io.check_writable(target)
    mesh, is_generated = target.data, read is not None and (not read.own or read.vertices is not None)
    with modes.object_mode(target):
        own, surface = results, None
        if is_generated:
            arrays, is_lost = read.arrays, read.vertices is None
            own = on_original(results, nearest(mesh, arrays) if is_lost else read.vertices)
            triangles = arrays.triangle_vertices
            surface = arrays.positions, triangles[:: 1 + len(triangles) // mesh_io.ENOUGH_FACES]
        mesh_io.check_count(mesh, own)
        extras = mesh_io.extras_on(mesh, results)
        at = mesh_io.places(mesh, results.values, extras)
        drawn = mesh_io.drawing(results, *(surface or mesh_io.surface_of(mesh)))
        mesh_io.write_at(mesh, own, at, drawn)
        if is_generated:
            carrier = carrier_mesh(target, arrays, is_lost, read.earlier)
            mesh_io.write_at(carrier, replace(results, unwrapped=None), at, drawn)
            carrying.carry(target, carrier, (len(arrays.positions), len(arrays.corner_vertices)), is_lost)
        else:
            carrying.release(mesh, mesh_io.attribute_names(results.values, extras, at))
    return mesh_io.moved_notes(at)


def carrier_mesh(
    target: bpy.types.Object, arrays: MeshArrays, is_lost: bool, earlier: dict[str, np.ndarray]
) -> bpy.types.Mesh:
    """A carrier's mesh, with values of earlier bakes whose attributes still exist on the object's own mesh.

    It has faces only if own vertices are lost, because the nearest place on them is then looked up.
    """
    mesh, faces = carrying.emptied(target), arrays.triangle_vertices if is_lost else np.empty((0, 3), np.int32)
    fill(mesh, arrays.positions, faces.ravel(), np.full(len(faces), 3))
    kept = {name: values for name, values in earlier.items() if name in target.data.attributes}
    mesh_io.make_attributes(mesh, list(kept))
    for name, values in kept.items():
        set_values(mesh.attributes[name], values)
    record.take_over(target.data, mesh)
    return mesh


def nearest(mesh: bpy.types.Mesh, arrays: MeshArrays) -> np.ndarray:
    """(vertex_count,) int64 vertex of the arrays that is nearest to each of the mesh's own."""
    tree = mathutils.kdtree.KDTree(len(arrays.positions))
    for vertex, position in enumerate(arrays.positions.tolist()):
        tree.insert(position, vertex)
    tree.balance()
    return np.array([tree.find(position)[1] for position in mesh_io.read_positions(mesh).tolist()], np.int64)


# ---- Copies


def copy_with_values(target: bpy.types.Object) -> bpy.types.Object:
    """A copy of the object with its modifiers applied and all values on the resulting vertices."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(
        target.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
    )
    for name in (record.PROPERTY, ownership.PROPERTY):
        if name in mesh:
            del mesh[name]  # a record may name attributes that do not exist here
    record.take_over(target.data, mesh)
    ownership.leave(mesh, record.attributes_of(mesh))
    active = target.data.color_attributes.active_color
    if active is not None and active.name in mesh.color_attributes:
        colors = mesh.color_attributes
        colors.active_color, colors.render_color_index = colors[active.name], colors.find(active.name)
    copy = bpy.data.objects.new(target.name + COPY_SUFFIX, mesh)
    mesh.name = copy.name
    for collection in target.users_collection:
        collection.objects.link(copy)
    for own, slot in zip(target.material_slots, copy.material_slots, strict=False):
        if own.link == "OBJECT":  # the mesh has none of these
            slot.link, slot.material = own.link, own.material
    copy.matrix_world = target.matrix_world
    return copy
