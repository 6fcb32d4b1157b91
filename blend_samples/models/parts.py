"""The parts that every model needs: an object of points and faces, a UV map, rough skin, smooth steps."""

import math
from collections.abc import Iterable

import bpy
import numpy as np
from mathutils import Vector, noise


def place(name: str, mesh: bpy.types.Mesh) -> bpy.types.Object:
    """An object of a mesh, in the scene, selected alone and active."""
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    return made


def build(name: str, points: np.ndarray, faces: Iterable, smooth: bool = True) -> bpy.types.Object:
    """An object of points (n, 3) and faces."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(points).tolist(), [], np.asarray(faces).tolist())
    mesh.polygons.foreach_set("use_smooth", np.full(len(mesh.polygons), smooth))
    mesh.update()
    return place(name, mesh)


def unwrap(made: bpy.types.Object, margin: float = 0.003) -> None:
    """Gives the active object a UV map by Smart UV Project."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=math.radians(66), island_margin=margin)
    bpy.ops.object.mode_set(mode="OBJECT")


def rough(points: np.ndarray, quads: np.ndarray, layers: Iterable[tuple[float, float, int]]) -> np.ndarray:
    """Points moved along their normals by layers of noise: strength, size, octaves."""
    a, b, c, d = (points[quads[:, side]] for side in range(4))
    across, normals = np.cross(c - a, d - b), np.zeros_like(points)
    for axis in range(3):
        for side in range(4):
            normals[:, axis] += np.bincount(quads[:, side], across[:, axis], len(points))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    height = np.zeros(len(points))
    for strength, size, octaves in layers:
        height += strength * np.array([noise.fractal(Vector(point / size), 0.9, 2.0, octaves) for point in points])
    return points + height[:, None] * normals


def ramp(values: np.ndarray, begin: float, end: float) -> np.ndarray:
    """0 at the begin, 1 at the end, smooth between them."""
    share = np.clip((values - begin) / (end - begin), 0, 1)
    return share * share * (3 - 2 * share)
