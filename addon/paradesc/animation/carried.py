"""Brings live values to the vertices that modifiers make, by the carrier that bakes use, at every frame anew."""

import bpy

from ..bridge import MeshArrays
from ..scene import arrays, carrying, delivery, mesh_io, ownership, record
from . import painting, surfaces


def paint(
    painter: painting.Painter, target: bpy.types.Object, values: painting.Values, made: MeshArrays, rendering: bool
) -> bool:
    """Fills the carrier with the values of the mesh that modifiers made, as the painter painted the object's own mesh.

    A render finds a carrier of other vertices where it has another level of subdivision. There the object's own
    vertices have to do, which show the values of every frame.
    """
    names, mesh = values.names(painter.at), carrying.carrier_of(target)
    fits = mesh is not None and len(mesh.vertices) == len(made.positions) and painting.has_all(mesh, names)
    if rendering and not fits:
        return False
    if not fits:
        mesh = delivery.carrier_mesh(target, made)
        mesh_io.make_attributes(mesh, names)
    ownership.forget(mesh, names)
    for name, array in painter.attribute_values(values):
        arrays.set_values(mesh.attributes[name], array)
    if not fits:
        painting.leave_record(mesh, values, painter.ranges, painter.at)
        carrying.carry(target, mesh)
    mesh.update()
    if not rendering:
        show_in_renders(target, not surfaces.differs_in_renders(target))
    return True


def show_in_renders(target: bpy.types.Object, wanted: bool) -> None:
    """Lets renders show what is carried, or the object's own values."""
    modifier = carrying.modifier_of(target)
    if modifier is not None and modifier.show_render != wanted:
        modifier.show_render = wanted


def leave(target: bpy.types.Object) -> None:
    """Keeps fingerprints of carried values that change no more."""
    mesh = carrying.carrier_of(target) if target.type == "MESH" else None
    if mesh is not None:
        known = ownership.fingerprints(mesh)
        ownership.leave(mesh, [name for name in record.attributes_of(mesh) if name not in known])
        show_in_renders(target, True)
