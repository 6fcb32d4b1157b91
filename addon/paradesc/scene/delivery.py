"""Brings results back to an object: to its own vertices, or to a result object if modifiers lose some of these."""

from dataclasses import replace

import bpy
import numpy as np

from ..bridge import MeshArrays
from ..core.job import Results
from . import mesh_io, ownership, record, source_meshes
from .arrays import attribute_values, kind_of, set_values

RESULT_SUFFIX = "_paradesc"


def deliver(target: bpy.types.Object, results: Results, reading: source_meshes.Reading) -> list[str]:
    """Writes the results where they belong; gives sentences about that and about what was replaced."""
    if reading.own:
        return mesh_io.write_results(target, on_original(results, reading))
    holder, notes = result_object(target, reading.arrays)
    notes += [f'The results are in "{holder.name}".', *mesh_io.write_results(holder, results)]
    ownership.leave_object(holder)
    return notes


def on_original(results: Results, reading: source_meshes.Reading) -> Results:
    """Brings the results to the object's own vertices."""
    if reading.vertices is None:
        return results
    at = reading.vertices
    corners = results.corners
    if corners is not None:
        painted = corners.painted[at]
        place = {int(vertex): index for index, vertex in reversed(list(enumerate(at)))}
        kept = [vertex for vertex in corners.vertices.tolist() if vertex in place]
        own = np.array([place[vertex] for vertex in kept], corners.vertices.dtype)
        corners = replace(corners, vertices=own, painted=painted)
    return replace(
        results,
        values={name: values[at] for name, values in results.values.items()},
        coverage=results.coverage[at],
        areas=None if results.areas is None else results.areas[at],
        mask=results.mask[at],
        near_seam=None if results.near_seam is None else results.near_seam[at],
        seam_error={name: values[at] for name, values in results.seam_error.items()},
        unwrapped=None,  # it is a layout of the evaluated mesh, which nothing keeps
        corners=corners,
    )


def result_object(target: bpy.types.Object, arrays: MeshArrays) -> tuple[bpy.types.Object, list[str]]:
    """The object "<name>_paradesc" with the evaluated mesh; that of an earlier bake gets the new mesh.

    It stays as it is, and another one is made, if somebody has renamed or edited it; a sentence says so.
    """
    mesh = evaluated_copy(target, arrays)
    holder, notes = None, []
    for item in results_of(target):
        if ownership.is_object_as_left(item):
            holder = item
        else:
            notes = [f'The object "{item.name}" of an earlier bake was edited since, and stays as it is.']
    if holder is not None:
        former = holder.data
        keep_results(former, mesh)
        holder.data = mesh
        if former.users == 0:
            bpy.data.meshes.remove(former)
    else:
        holder = bpy.data.objects.new(target.name + RESULT_SUFFIX, mesh)
        holder[record.PROPERTY] = target.name
        for collection in target.users_collection or [bpy.context.scene.collection]:
            collection.objects.link(holder)
    record.take_over(target.data, mesh)  # modifiers carry its attributes along
    mesh.name = holder.name
    if ownership.is_where_left(holder):
        holder.matrix_world = target.matrix_world
    return holder, notes


def results_of(target: bpy.types.Object) -> list[bpy.types.Object]:
    """The result objects that bakes of this object have made; copies and renamed ones are the user's."""
    usual = target.name + RESULT_SUFFIX
    marked = [item for item in bpy.data.objects if item.get(record.PROPERTY) == target.name and item.library is None]
    return [item for item in marked if item.name == ownership.given_name(item, usual)]


def evaluated_copy(target: bpy.types.Object, arrays: MeshArrays) -> bpy.types.Mesh:
    """A mesh of its own as the modifiers make it."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(
        target.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
    )
    if len(mesh.vertices) != len(arrays.positions):
        bpy.data.meshes.remove(mesh)
        raise mesh_io.refuse(f'The object "{target.name}" was changed while it was being computed; run it again.')
    for name in (record.PROPERTY, ownership.PROPERTY):
        if name in mesh:
            del mesh[name]  # they are of the object's own mesh
    return mesh


def keep_results(former: bpy.types.Mesh, mesh: bpy.types.Mesh) -> None:
    """Brings the results of earlier bakes along to a mesh with the same faces."""
    if source_meshes.same_vertices(former, mesh):
        names = record.attributes_of(former)
        mesh_io.make_attributes(mesh, names)
        for name in names:
            if kind_of(mesh.attributes[name]) == kind_of(former.attributes[name]) == mesh_io.wanted_kind(name):
                set_values(mesh.attributes[name], attribute_values(former.attributes[name]))
        for name in (record.PROPERTY, ownership.PROPERTY):
            if name in former:
                mesh[name] = former[name]
