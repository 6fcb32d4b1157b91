"""Reads real meshes into arrays, and changes an existing mesh for a case. Plain numpy, the same for both trees."""

import json
import math
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshes  # tests/accuracy
import numpy as np
from surfaces import as_arrays  # tests/accuracy

from paradesc import bridge

# glTF 2.0, accessor.componentType and accessor.type
COMPONENTS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
IMAGE = 64  # texels along a side of the surface maps


def read(path: Path) -> bridge.MeshArrays:
    """Reads a .obj or .glb; a mesh without a UV map gets projected charts."""
    arrays = read_glb(path) if path.suffix == ".glb" else meshes.read_obj(path)
    if arrays.corner_uvs is None:
        arrays = meshes.project_charts(arrays, cells=6)
    normals = np.nan_to_num(meshes.max_normals(arrays.positions.astype(np.float64), arrays.triangle_vertices))
    normals[np.linalg.norm(normals, axis=1) < 0.5] = (0.0, 0.0, 1.0)
    return replace(arrays, corner_normals=normals[arrays.corner_vertices].astype(np.float32))


def read_glb(path: Path) -> bridge.MeshArrays:
    """Reads all triangles of a binary glTF file in the pose of its accessors, without its nodes."""
    content = path.read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    scene, binary = json.loads(content[20 : 20 + length]), content[28 + length :]

    def accessor(number: int) -> np.ndarray:
        entry = scene["accessors"][number]
        view, width = scene["bufferViews"][entry["bufferView"]], WIDTHS[entry["type"]]
        kind = np.dtype(COMPONENTS[entry["componentType"]])
        start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        rows = np.ndarray((entry["count"], width), kind, binary, start, (stride, kind.itemsize))
        return np.array(rows)

    points, triangles, places, count = [], [], [], 0
    for mesh in scene["meshes"]:
        for primitive in mesh["primitives"]:
            given = primitive["attributes"]
            position = accessor(given["POSITION"])
            used = np.arange(len(position)) if "indices" not in primitive else accessor(primitive["indices"])
            used = used.reshape(-1, 3).astype(np.int64)
            uvs = accessor(given["TEXCOORD_0"]) if "TEXCOORD_0" in given else None
            points.append(position)
            places.append(None if uvs is None else uvs[used] * [1, -1] + [0, 1])
            triangles.append(used + count)
            count += len(position)
    whole = all(place is not None for place in places)
    return as_arrays(np.concatenate(points), np.concatenate(triangles), np.concatenate(places) if whole else None)


def waves() -> tuple[np.ndarray, np.ndarray]:
    """(n, n) phases of a repeating picture, along u and v."""
    steps = np.arange(IMAGE) * (2 * math.pi / IMAGE)
    return np.meshgrid(3 * steps, 5 * steps)


def bent(arrays: bridge.MeshArrays) -> np.ndarray:
    """Positions of another shape; a mere scale would cancel in the units of the buffer."""
    points = arrays.positions.astype(np.float64)
    size = np.ptp(points, axis=0).max()
    turned = points / size * 4
    return (points + size * 0.06 * np.sin(turned[:, [1, 2, 0]])).astype(np.float32)


def moved(mesh: bridge.Mesh, arrays: bridge.MeshArrays) -> None:
    """Gives the mesh other positions."""
    mesh.set_positions(bent(arrays))


def displaced(mesh: bridge.Mesh, arrays: bridge.MeshArrays) -> None:
    """Gives the mesh a displacement map."""
    u, v = waves()
    size = float(np.ptp(arrays.positions.astype(np.float64), axis=0).max())
    mesh.set_displacement((0.5 + 0.5 * np.sin(u) * np.cos(v)).astype(np.float32), 0.4, 0.004 * size)


def normal_mapped(mesh: bridge.Mesh, arrays: bridge.MeshArrays) -> None:
    """Gives the mesh a normal map, with some tangent at every corner."""
    u, v = waves()
    colors = np.stack([0.5 + 0.2 * np.sin(u), 0.5 + 0.2 * np.cos(v), np.full_like(u, 0.95)], axis=-1)
    normals = arrays.corner_normals.astype(np.float64)
    across = np.eye(3)[np.abs(normals).argmin(axis=1)]
    tangents = np.cross(normals, across)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    signs = np.where(np.arange(len(normals)) // 3 % 2, 1.0, -1.0)[:, None]
    mesh.set_normal_map(colors.astype(np.float32), np.hstack([tangents, signs]).astype(np.float32))


def both(mesh: bridge.Mesh, arrays: bridge.MeshArrays) -> None:
    """Gives the mesh both maps over other positions."""
    moved(mesh, arrays)
    displaced(mesh, arrays)
    normal_mapped(mesh, arrays)


CHANGES: dict[str, Callable[[Any, Any], None]] = {
    "moved": moved,
    "displaced": displaced,
    "normal mapped": normal_mapped,
    "moved, both maps": both,
}


def undo(mesh: bridge.Mesh, arrays: bridge.MeshArrays) -> None:
    """Makes the mesh as it was read."""
    mesh.set_displacement(None)
    mesh.set_normal_map(None)
    mesh.set_positions(arrays.positions)


def shaded(arrays: bridge.MeshArrays) -> bridge.MeshArrays:
    """The same mesh with some flat faces and sharp edges."""
    triangles = arrays.triangle_vertices
    smooth = (np.arange(len(triangles)) % 7 != 0).astype(np.uint8)
    return replace(arrays, triangle_smooth=smooth, sharp_edges=np.ascontiguousarray(triangles[::5, :2]))
