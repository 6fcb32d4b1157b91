"""A crate: planks in a frame with braces, metal corners and bolts, as one surface of flat faces with narrow bevels."""

import math
from collections.abc import Sequence
from itertools import pairwise

import bmesh
import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector

from .parts import place

SPACING = 0.028  # of the vertices inside flat faces
SIDES = [Euler((0, 0, math.radians(turn))) for turn in (0, 90, 180, 270)]
SIDES += [Euler((math.radians(turn), 0, 0)) for turn in (90, -90)]  # what looks up, what looks down


def crate(spacing: float = SPACING) -> bpy.types.Object:
    """A crate 1 wide; spacing 0 leaves its flat faces whole."""
    generator, shape = np.random.default_rng(2), bmesh.new()
    add_block(shape, (0, 0, 0), (0.45, 0.45, 0.45), Matrix(), 0.004)
    for turn in SIDES:
        frame = turn.to_matrix().to_4x4()
        add_planks(shape, frame, generator)
        if turn != SIDES[-1]:
            add_corners(shape, frame)
    for turn in SIDES[:4]:
        add_brace(shape, turn.to_matrix().to_4x4())
    for axis in range(3):
        for first in (-1, 1):
            for second in (-1, 1):
                center, half = [0.455 * first, 0.455 * second], [0.055 + 0.0015 * axis] * 2
                center.insert(axis, 0)
                half.insert(axis, 0.507 + 0.0025 * (axis == 2))
                add_block(shape, center, half, Matrix(), 0.008)
    made = united(shape)
    if spacing:
        divide(made, spacing)
    return made


def add_block(shape: bmesh.types.BMesh, center: Sequence, half: Sequence, frame: Matrix, bevel: float) -> None:
    """A box with beveled edges in a frame."""
    size = Matrix.Diagonal((*(2 * length for length in half), 1))
    verts = bmesh.ops.create_cube(shape, size=1, matrix=frame @ Matrix.Translation(center) @ size)["verts"]
    edges = {edge for vertex in verts for edge in vertex.link_edges}
    bmesh.ops.bevel(shape, geom=list(edges), offset=bevel, segments=2, profile=0.5, affect="EDGES")


def add_bolt(
    shape: bmesh.types.BMesh, center: Sequence, radius: float, height: float, frame: Matrix, sides: int
) -> None:
    """A head with a slanted rim that looks to the front of a frame."""
    rims = []
    for share, width in ((0.5, 1.0), (-0.1, 1.0), (-0.5, 0.65)):
        turns = [2 * math.pi * (k + 0.5) / sides for k in range(sides)]
        ring = [(radius * width * math.cos(t), share * height, radius * width * math.sin(t)) for t in turns]
        rims.append([shape.verts.new(frame @ (Vector(center) + Vector(place))) for place in ring])
    for low, high in pairwise(rims):
        for k in range(sides):
            shape.faces.new((low[k - 1], low[k], high[k], high[k - 1]))
    for rim in (rims[0], rims[-1]):
        shape.faces.new(rim)


def add_planks(shape: bmesh.types.BMesh, frame: Matrix, generator: np.random.Generator) -> None:
    """Five planks side by side, none quite like another, with nails."""
    for k in range(5):
        z = 0.164 * (k - 2)
        depth, turn = (
            0.468 + generator.uniform(-0.004, 0.004),
            Euler((0, math.radians(generator.uniform(-0.35, 0.35)), 0)),
        )
        add_block(shape, (0, -depth, z), (0.425, 0.022, 0.0765), frame @ turn.to_matrix().to_4x4(), 0.006)
        for x in (-0.375, 0.375):
            for shift in (-0.04, 0.04):
                add_bolt(shape, (x, -0.022 - depth, z + shift), 0.009, 0.012, frame, 8)


def add_brace(shape: bmesh.types.BMesh, frame: Matrix) -> None:
    """A board from corner to corner, with bolts."""
    turned = frame @ Matrix.Rotation(math.radians(45), 4, "Y")
    add_block(shape, (0, -0.48, 0), (0.57, 0.022, 0.05), turned, 0.006)
    for x in (-0.44, -0.2, 0, 0.2, 0.44):
        add_bolt(shape, (x, -0.504, 0), 0.017, 0.022, turned, 12)


def add_corners(shape: bmesh.types.BMesh, frame: Matrix) -> None:
    """Metal plates with three bolts at the corners of a side."""
    for x in (-1, 1):
        for z in (-1, 1):
            for half, center in (((0.1, 0.009, 0.045), (0.42, 0.475)), ((0.044, 0.0085, 0.1), (0.4755, 0.42))):
                add_block(shape, (x * center[0], -0.513, z * center[1]), half, frame, 0.004)
            for a, b in ((0.475, 0.475), (0.36, 0.475), (0.475, 0.36)):
                add_bolt(shape, (x * a, -0.523, z * b), 0.016, 0.024, frame, 12)


def united(shape: bmesh.types.BMesh) -> bpy.types.Object:
    """All parts as one surface without what lies inside."""
    mesh = bpy.data.meshes.new("crate")
    bmesh.ops.recalc_face_normals(shape, faces=shape.faces)
    shape.to_mesh(mesh)
    shape.free()
    made = place("crate", mesh)
    far = bpy.data.objects.new("far", bpy.data.meshes.new("far"))
    bpy.context.collection.objects.link(far)
    modifier = made.modifiers.new("union", "BOOLEAN")
    modifier.operation, modifier.solver, modifier.object, modifier.use_self = "UNION", "EXACT", far, True
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    bpy.data.objects.remove(far)
    return made


def divide(made: bpy.types.Object, spacing: float) -> None:
    """Cuts all faces along planes, so that flat ones have vertices inside."""
    shape = bmesh.new()
    shape.from_mesh(made.data)
    reach = 0.5
    for axis in range(3):
        normal = Vector([float(k == axis) for k in range(3)])
        for k in range(math.ceil(2 * reach / spacing)):
            parts = shape.verts[:] + shape.edges[:] + shape.faces[:]
            bmesh.ops.bisect_plane(
                shape, geom=parts, plane_co=normal * ((k + 0.5) * spacing - reach), plane_no=normal, dist=1e-5
            )
    shape.to_mesh(made.data)
    shape.free()
