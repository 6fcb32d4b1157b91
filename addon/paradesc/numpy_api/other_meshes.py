"""Takes meshes of trimesh, PyVista and Open3D by the arrays they have, and gives values back to them.

None of these packages is imported: a mesh is recognized by its attributes. Never imports bpy.
"""

from collections.abc import Mapping

import numpy as np

from ..bridge import InputError
from ..core.polygons import Polygons, listed_polygons, triangles_of
from .inputs import numbers, whole

# Triangles, polygons and quads among VTK's types of cells.
FLAT_CELLS = (5, 7, 9)
LEGACY = (
    "A legacy Open3D TriangleMesh has no place for values at vertices; "
    "make one that has by open3d.t.geometry.TriangleMesh.from_legacy(mesh)."
)

CLOUD = (
    "Points without faces are no surface; make a mesh of them first, for example by Open3D's "
    "TriangleMesh.create_from_point_cloud_poisson."
)


def kind_of(mesh: object) -> str:
    """The kind of a mesh: "open3d tensor", "open3d legacy", "trimesh", "polydata", "grid", or "" for none of these."""
    for name, attributes in {
        "open3d tensor": ("vertex", "triangle"),
        "trimesh": ("vertices", "faces"),  # which has triangles too, as points
        "open3d legacy": ("vertices", "triangles"),
        "polydata": ("points", "faces"),
        "grid": ("points", "cells", "celltypes"),
    }.items():
        if all(hasattr(mesh, attribute) for attribute in attributes):
            return name
    return ""


def vertices_and_faces(mesh: object) -> tuple[object, object]:
    """The vertices and faces of a mesh of another package; (mesh, None) for any other object."""
    kind = kind_of(mesh)
    if kind == "open3d tensor":
        return tensor(mesh.vertex, "positions"), tensor(mesh.triangle, "indices")
    if kind == "open3d legacy":
        return mesh.vertices, mesh.triangles
    if kind == "trimesh":
        return mesh.vertices, mesh.faces
    if kind == "polydata":
        return mesh.points, polydata_faces(mesh)
    if kind == "grid":
        kinds = numbers(mesh.celltypes, "celltypes", "VTK's numbers are needed")
        if not np.isin(kinds, FLAT_CELLS).all():
            sentence = "The grid has cells that are no polygons"
            raise InputError(f"{sentence}; give its surface, for example extract_surface().")
        return mesh.points, vtk_polygons(mesh.cells)
    if type(mesh).__name__ == "PointCloud":  # of trimesh and Open3D
        raise InputError(CLOUD)
    return mesh, None


def tensor(mapping: object, name: str) -> object:
    """The array of one of a tensor mesh's attributes, brought from whatever device."""
    if name not in mapping:
        raise InputError(f"The Open3D mesh has no {name}.")
    found = mapping[name]
    return found.cpu().numpy() if hasattr(found, "cpu") else found


def polydata_faces(mesh: object) -> Polygons:
    """The polygons of a PolyData, and then the triangles of its strips."""
    listed = getattr(mesh, "strips", ())
    if not len(listed):
        found = vtk_polygons(mesh.faces)
        if not len(found.sizes):
            raise InputError(CLOUD)
        return found
    strips = vtk_polygons(listed)
    triangles = triangles_of(strips.corner_vertices, strips.sizes)
    if not len(mesh.faces):
        return triangles
    polygons = vtk_polygons(mesh.faces)
    return Polygons(
        np.concatenate([polygons.corner_vertices, triangles.corner_vertices]),
        np.concatenate([polygons.sizes, triangles.sizes]),
    )


def vtk_polygons(cells: object) -> Polygons:
    """The faces of VTK's list: the number of corners of a face, then its vertices, then the next face."""
    wanted = "VTK's list of faces (corners, vertex, vertex, vertex, corners, …) is needed"
    found = listed_polygons(whole(cells, "faces", wanted, 1).astype(np.int64))
    if found is None:
        raise InputError(f"faces ends within a face; {wanted}.")
    return found


def write_to(mesh: object, values: Mapping[str, np.ndarray], domain: str) -> None:
    """Gives copies of (n,) and (n, 3) arrays to a mesh with n vertices or faces, where its package keeps such values."""
    kind = kind_of(mesh)
    if kind == "open3d legacy":
        raise InputError(LEGACY)
    if not kind:
        sentence = f"Values cannot be given to a {type(mesh).__name__}"
        raise InputError(f"{sentence}; trimesh, PyVista and Open3D's tensor meshes take them.")
    points, faces = vertices_and_faces(mesh)
    at_faces = domain == "faces"
    count = len(points) if not at_faces else len(faces.sizes) if isinstance(faces, Polygons) else len(faces)
    wanted = len(next(iter(values.values())))
    if count != wanted:
        raise InputError(f"The mesh has {count} {domain}, but the result belongs to one with {wanted}.")
    if at_faces and kind == "polydata":
        values = at_cells(mesh, values)
    for name, array in values.items():
        array = array.copy()  # packages keep the very array, in which changes of the mesh would change the result
        if kind == "trimesh":
            (mesh.face_attributes if at_faces else mesh.vertex_attributes)[name] = array
        elif kind in ("polydata", "grid"):
            (mesh.cell_data if at_faces else mesh.point_data)[name] = array
        else:
            positions = mesh.vertex["positions"]  # a tensor (n, 1) or (n, 3) on the same device, so that files keep it
            given = type(positions).from_numpy(array.reshape(len(array), -1))
            (mesh.triangle if at_faces else mesh.vertex)[name] = given.to(positions.device)


def at_cells(mesh: object, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Values at the cells of a PolyData, in VTK's order: vertices and lines, which have NaN, then the polygons."""
    if len(mesh.strips):
        raise InputError("A triangle strip is one cell, and has no place for the values of its faces; triangulate it.")
    others = mesh.n_verts + mesh.n_lines
    return {name: np.concatenate([np.full_like(array, np.nan, shape=(others, *array.shape[1:])), array])
            for name, array in values.items()}  # fmt: skip
