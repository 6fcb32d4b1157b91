"""Makes a layout for a mesh without a usable UV map: Blender unwraps a copy, and a hidden attribute keeps it."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import radians

import bpy
import numpy as np

from paradesc.bridge import InputError, Layout, MeshArrays, ParadescError, abi
from paradesc.core import packing
from paradesc.core.digests import digest
from paradesc.core.uv_faults import fault

from .arrays import kind_of, read_array, read_corner_vertices

# It has three floats a corner (u, v, 0), because two would be one more UV map since Blender 3.5. Blender's own lists
# leave out attributes whose names begin with ".hide".
ATTRIBUTE = ".hide_paradesc_uv"
# The angle between directions of one chart. Up to here no chart of the tested meshes overlaps itself; from 55 degrees
# on some do.
ANGLE_LIMIT = radians(50)
# The name of the scene, object and mesh that exist only during the unwrap.
TEMPORARY = "Paradesc unwrap"


def layout(mesh: bpy.types.Mesh, stored: dict[str, str], arrays: MeshArrays, reason: str) -> Layout:
    """The layout that stored describes, if it exists and fits, else a new one. The mesh stays as it is."""
    starts = face_starts(mesh)
    key = digest(arrays.corner_vertices, starts)
    uvs = kept_uvs(mesh, stored, key)
    if uvs is not None:
        return Layout(uvs, reason, key, kept=True)
    finite = np.isfinite(arrays.positions).all(axis=1)
    if not finite.all():
        sentence = f"The position of vertex {np.argmin(finite)} is not finite; repair the mesh before it is unwrapped."
        raise InputError(sentence)
    return Layout(lay_out(arrays, starts), reason, key, kept=False)


# ---- Keeping


def kept_uvs(mesh: bpy.types.Mesh, stored: dict[str, str], key: str) -> np.ndarray | None:
    """The (corner_count, 2) float32 layout in the mesh, if it is the one that stored describes, and fits."""
    attribute = mesh.attributes.get(ATTRIBUTE)
    if attribute is None or stored.get("topology") != key:
        return None
    if kind_of(attribute) != ("FLOAT_VECTOR", "CORNER") or len(attribute.data) != len(mesh.loops):
        return None
    uvs = np.ascontiguousarray(read_array(attribute.data, "vector", np.float32, 3)[:, :2])
    return uvs if stored.get("content") == digest(uvs) and np.isfinite(uvs).all() else None


def keep(mesh: bpy.types.Mesh, made: Layout) -> dict[str, str]:
    """Stores the layout in the mesh; returns its description for the record, or none if the mesh has changed since."""
    if digest(read_corner_vertices(mesh), face_starts(mesh)) != made.topology:
        return {}
    attribute = mesh.attributes.get(ATTRIBUTE)
    if attribute is not None and kind_of(attribute) != ("FLOAT_VECTOR", "CORNER"):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = mesh.attributes.new(ATTRIBUTE, "FLOAT_VECTOR", "CORNER")
    if attribute is None or attribute.name != ATTRIBUTE:
        return {}
    values = np.zeros((len(made.uvs), 3), np.float32)
    values[:, :2] = made.uvs
    attribute.data.foreach_set("vector", values.ravel())
    return {"topology": made.topology, "content": digest(made.uvs)}


# ---- Making


def read_uvs(layer: bpy.types.MeshUVLoopLayer) -> np.ndarray:
    """(corner_count, 2) float32; before Blender 3.5 in a slower way."""
    collection, member = (layer.uv, "vector") if hasattr(layer, "uv") else (layer.data, "uv")
    return read_array(collection, member, np.float32, 2)


def face_starts(mesh: bpy.types.Mesh) -> np.ndarray:
    """(face_count,) int32 first corners."""
    return read_array(mesh.polygons, "loop_start", np.int32)


def write_uvs(layer: bpy.types.MeshUVLoopLayer, uvs: np.ndarray) -> None:
    """Fills a UV map with (corner_count, 2) coordinates."""
    collection, member = (layer.uv, "vector") if hasattr(layer, "uv") else (layer.data, "uv")
    collection.foreach_set(member, np.ascontiguousarray(uvs, np.float32).ravel())


def lay_out(arrays: MeshArrays, starts: np.ndarray, gutter: float = packing.GUTTER) -> np.ndarray:
    """(corner_count, 2) float32 layout of faces whose corners follow each other from starts; 0 for broken faces.

    gutter: how far charts lie apart, as a share of the square's side.
    """
    sizes = np.diff(np.append(starts, len(arrays.corner_vertices)))
    if (sizes < 3).any():
        raise failure("its faces are not stored in a row")
    face_of_corner = np.repeat(np.arange(len(sizes)), sizes)
    positions, corner_vertices = weld(arrays.positions, arrays.corner_vertices, face_of_corner)
    sound = ~repeating_faces(corner_vertices, face_of_corner)
    corners = sound[face_of_corner]
    uvs = np.zeros((len(corner_vertices), 2), np.float32)
    if not sound.any():
        raise failure("none of its faces is sound")
    uvs[corners] = unwrapped(positions, corner_vertices[corners], sizes[sound], gutter)
    reason = fault(uvs, arrays.triangle_corners)
    if reason and has_area(arrays):
        raise failure(f"the copy {reason}")
    return uvs


def has_area(arrays: MeshArrays) -> bool:
    """Returns whether any triangle is wider than rounding."""
    first, second, third = (arrays.positions[arrays.triangle_vertices[:, k]].astype(np.float64) for k in range(3))
    squared = ((second - first) ** 2).sum(axis=1) + ((third - first) ** 2).sum(axis=1)
    return bool((np.linalg.norm(np.cross(second - first, third - first), axis=1) > 1e-6 * squared).any())


def failure(why: str) -> ParadescError:
    """The error for a mesh that Blender cannot unwrap."""
    sentence = f"Blender could not unwrap the mesh ({why}); unwrap it yourself, or choose the processor (cpu)."
    return ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)


def weld(
    positions: np.ndarray, corner_vertices: np.ndarray, face_of_corner: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Merges vertices at one place, which files may split; returns positions (n, 3) and corners. Faces stay whole."""
    order = np.lexsort(positions.T)
    along = positions[order]
    first = np.append(True, (along[1:] != along[:-1]).any(axis=1))
    point = np.empty(len(positions), np.int32)
    point[order] = np.cumsum(first, dtype=np.int32) - 1
    points = along[first]
    welded = point[corner_vertices]
    torn = repeating_faces(welded, face_of_corner)[face_of_corner]
    if torn.any():  # a face that would lose a corner keeps its own vertices
        welded[torn] = corner_vertices[torn] + len(points)
        points = np.concatenate([points, positions])
    return points, welded


def repeating_faces(corner_vertices: np.ndarray, face_of_corner: np.ndarray) -> np.ndarray:
    """(face_count,) bool: whether the face uses a vertex twice."""
    order = np.lexsort((corner_vertices, face_of_corner))
    vertices, faces = corner_vertices[order], face_of_corner[order]
    again = (vertices[1:] == vertices[:-1]) & (faces[1:] == faces[:-1])
    repeating = np.zeros(face_of_corner[-1] + 1, bool)
    repeating[faces[1:][again]] = True
    return repeating


def unwrapped(
    positions: np.ndarray, corner_vertices: np.ndarray, sizes: np.ndarray, gutter: float = packing.GUTTER
) -> np.ndarray:
    """(corner_count, 2) float32 layout by Blender's operators, on a temporary mesh."""
    mesh = bpy.data.meshes.new(TEMPORARY)
    try:
        fill(mesh, positions, corner_vertices, sizes)
        mesh.uv_layers.new(name="UVMap", do_init=False)
        with edit_mode(mesh):
            run_operator()
        if not np.array_equal(read_corner_vertices(mesh), corner_vertices):
            raise failure("edit mode changed its faces")
        uvs = read_uvs(mesh.uv_layers[0])
    except RuntimeError as error:
        raise failure(" ".join(str(error).split()).rstrip(".")) from error
    finally:
        bpy.data.meshes.remove(mesh)
    if not np.isfinite(uvs).all():
        raise failure("the copy has a UV map with coordinates that are not finite")
    return packing.pack(uvs, corner_vertices, sizes, gutter)


def fill(mesh: bpy.types.Mesh, positions: np.ndarray, corner_vertices: np.ndarray, sizes: np.ndarray) -> None:
    """Gives an empty mesh its vertices and faces."""
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(positions, np.float32).ravel())
    mesh.loops.add(len(corner_vertices))
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(corner_vertices, np.int32))
    mesh.polygons.add(len(sizes))
    mesh.polygons.foreach_set("loop_start", (np.cumsum(sizes) - sizes).astype(np.int32))
    if bpy.app.version < (3, 6, 0):
        mesh.polygons.foreach_set("loop_total", sizes.astype(np.int32))
    mesh.update(calc_edges=True)


@contextmanager
def edit_mode(mesh: bpy.types.Mesh) -> Iterator[None]:
    """Enters edit mode on the mesh in a temporary scene, so that the open scene with its selection and modes stays."""
    scene = bpy.data.scenes.new(TEMPORARY)
    target = bpy.data.objects.new(TEMPORARY, mesh)
    try:
        scene.collection.objects.link(target)
        layer = scene.view_layers[0]
        layer.objects.active = target
        place = {"scene": scene, "view_layer": layer, "object": target, "active_object": target}
        with bpy.context.temp_override(**place):
            bpy.ops.object.mode_set(mode="EDIT")
        with bpy.context.temp_override(**place, edit_object=target):
            try:
                yield
            finally:
                bpy.ops.object.mode_set(mode="OBJECT")
    finally:
        bpy.data.objects.remove(target)
        bpy.data.scenes.remove(scene)


def run_operator() -> None:
    """Projects charts that are made by direction.

    Flattening each chart by its angles would take ten times as long for a fifth of the error, and make charts overlap.
    Blender does not pack the charts: with gutters, its version 3.4 takes minutes for thousands of them.
    """
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=ANGLE_LIMIT, island_margin=0.0)
