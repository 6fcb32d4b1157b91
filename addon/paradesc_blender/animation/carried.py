"""Carries live values to the vertices that modifiers make, at every frame, with the same carrier as bakes."""

from dataclasses import dataclass

import bpy
import numpy as np

from paradesc.bridge import MeshArrays

from ..scene import arrays, carrying, delivery, mesh_io, ownership, record
from . import painting, surfaces


@dataclass(frozen=True, eq=False)
class Made:
    """The mesh that modifiers made."""

    arrays: MeshArrays
    keeps_own: bool  # every original vertex is among the arrays'
    earlier: dict[str, np.ndarray]  # values of earlier bakes that were carried to its vertices, by attribute
    rendering: bool


def paint(painter: painting.Painter, target: bpy.types.Object, values: painting.Values, made: Made) -> None:
    """Writes the values to the carrier's mesh, as the painter wrote those of the object's own mesh.

    A render never makes a carrier. If it finds one that does not fit, because the render has another subdivision level,
    Blender interpolates the values of the object's own vertices there.
    """
    names, measured = values.names(painter.at), delivery.measured(made.arrays, not made.keeps_own)
    mesh = carrying.carrier_of(target)
    fits = mesh is not None and painting.has_all(mesh, names) and counts_of(target) == counts(measured)
    if made.rendering and not fits:
        if made.keeps_own:
            return
        raise surfaces.lost(target)
    if not fits:
        earlier = {name: array for name, array in made.earlier.items() if name not in names}
        mesh = delivery.carrier_mesh(target, made.arrays, not made.keeps_own, earlier)
        mesh_io.make_attributes(mesh, names)
    ownership.forget(mesh, names)
    for name, array in painter.attribute_values(values):
        arrays.set_values(mesh.attributes[name], array)
    if not fits:
        painting.leave_record(mesh, values, painter.ranges, painter.at)
        carrying.carry(target, mesh, measured)
    mesh.update()


def counts(measured: carrying.Measured) -> tuple[int, int]:
    """The vertex and corner counts that tell whether a carrier fits a mesh."""
    return measured.points, measured.corners


def counts_of(target: bpy.types.Object) -> tuple[int, int]:
    """The vertex and corner counts of the mesh for which the object's carrier was made."""
    return counts(carrying.measured_of(carrying.modifier_of(target).node_group))


def leave(target: bpy.types.Object) -> None:
    """Keeps fingerprints of carried values that no longer change."""
    mesh = carrying.carrier_of(target) if target.type == "MESH" else None
    if mesh is not None:
        known = ownership.fingerprints(mesh)
        ownership.leave(mesh, [name for name in record.attributes_of(mesh) if name not in known])
