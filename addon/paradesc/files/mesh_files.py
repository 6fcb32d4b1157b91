"""Reads mesh files without Blender, each format by its own reader; nibabel reads GIFTI and FreeSurfer's files.

A file's own vertices are kept in their order, whether a face uses them or not. Only the triangles of .stl, which have
no common vertices, are welded.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..bridge import InputError, MeshArrays, ParadescError, origin
from ..core.polygons import PolygonMesh
from . import (
    gltf_file,
    neuro_files,
    obj_file,
    off_file,
    ply_file,
    stl_file,
    vtk_legacy_file,
    vtp_file,
    wrong_kinds,
)
from .gltf_file import UnknownError
from .paths import is_file

BLENDER_LACKS = (".off", ".vtp", ".vtk", ".gii", *neuro_files.SURFACES)
SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf", *BLENDER_LACKS)
# A mesh in a file: its name, the mesh, and its (4, 4) transform to the world.
Found = tuple[str, PolygonMesh, np.ndarray]


@dataclass(eq=False)
class FileMesh:
    """A mesh of a file, as triangles."""

    name: str
    arrays: MeshArrays
    matrix_world: np.ndarray  # (4, 4) float64
    corner_normals: np.ndarray | None = None  # (corner_count, 3) float32, the file's own; not in the arrays
    face_count: int = 0  # with polygons
    notes: list[str] = field(default_factory=list)  # what was done to it


def read(path: Path) -> list[FileMesh]:
    """Reads the meshes of a file that have faces, each with a unique name; raises InputError with one sentence."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f'"{path}" is none of {", ".join(SUFFIXES)}.')
    found = [triangulated(one) for one in polygon_meshes(path)]
    found = [mesh for mesh in found if len(mesh.arrays.triangle_corners)]
    if not found:
        raise InputError(f'"{path}" has no faces; there is no surface to measure.')
    return with_own_names(found)


def check(path: Path) -> int:
    """Raises the error of read() if a file that this module can read is damaged, whichever program reads it afterwards.

    Returns how many sound faces another reader has to find: 0 for files that this module does not know.
    """
    if path.suffix.lower() not in SUFFIXES:
        return 0
    try:
        return sum(sound_faces(mesh) for _, mesh, _ in polygon_meshes(path))
    except InputError as error:
        if isinstance(error.__cause__, UnknownError):
            return 0
        raise


def sound_faces(mesh: PolygonMesh) -> int:
    """The number of faces with three or more distinct vertices; faces with the same vertices count once."""
    starts, count = np.cumsum(mesh.sizes) - mesh.sizes, 0
    for size in np.unique(mesh.sizes[mesh.sizes > 2]):
        rows = np.sort(mesh.corner_vertices[starts[mesh.sizes == size, None] + np.arange(size)], axis=1)
        rows = rows[(rows[:, 1:] != rows[:, :-1]).all(axis=1)]
        rows = rows[np.lexsort(rows.T)]
        count += len(rows) and 1 + int((rows[1:] != rows[:-1]).any(axis=1).sum())
    return count


def polygon_meshes(path: Path) -> list[Found]:
    """The meshes of a file, with or without faces; raises InputError with one sentence."""
    suffix = path.suffix.lower()
    if not is_file(path):
        raise InputError(f'There is no file "{path}".')
    try:
        with path.open("rb") as file:
            fault = wrong_kinds.fault(suffix, file.read(wrong_kinds.FIRST_BYTES))
        if fault:
            raise ValueError(fault)
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused below
            found = READERS[suffix](path)
            for _, mesh, _ in found:
                origin.check_finite(mesh.positions)
    except MemoryError as error:
        raise InputError(f'"{path}" cannot be read: there is not enough memory for it.') from error
    except ParadescError as error:
        raise InputError(f'"{path}" cannot be used. {error.sentence}') from error
    except (ValueError, OSError) as error:
        said = getattr(error, "strerror", None) or error
        said = " ".join(str(said).split()).rstrip(".")[:300] or type(error).__name__
        raise InputError(f'"{path}" cannot be read: {said}.') from error
    return found


def with_own_names(meshes: list[FileMesh]) -> list[FileMesh]:
    """Makes names unique by appended numbers."""
    taken: set[str] = set()
    for mesh in meshes:
        stem, number = mesh.name, 0
        while mesh.name in taken:
            number += 1
            mesh.name = f"{stem}.{number:03}"
        taken.add(mesh.name)
    return meshes


def triangulated(found: Found) -> FileMesh:
    """A mesh of polygons as triangles."""
    name, mesh, place = found
    return FileMesh(name, mesh.arrays(), place, mesh.corner_normals, len(mesh.sizes), mesh.notes)


def of_one(reader: Callable[[Path], PolygonMesh | None]) -> Callable[[Path], list[Found]]:
    """A reader of files with a single mesh. It has the name of the file, and no transform."""

    def read(path: Path) -> list[Found]:
        mesh = reader(path)
        return [] if mesh is None else [(path.stem, mesh, np.eye(4))]

    return read


def read_obj(path: Path) -> list[Found]:
    """The objects of a Wavefront file."""
    return [(name or path.stem, mesh, np.eye(4)) for name, mesh in obj_file.read(path)]


READERS: dict[str, Callable[[Path], list[Found]]] = {
    ".obj": read_obj,
    ".ply": of_one(ply_file.read),
    ".stl": of_one(stl_file.read),
    ".off": of_one(off_file.read),
    ".glb": gltf_file.read,
    ".gltf": gltf_file.read,
    ".vtp": of_one(vtp_file.read),
    ".vtk": of_one(vtk_legacy_file.read),
    ".gii": of_one(neuro_files.read_gifti),
    **dict.fromkeys(neuro_files.SURFACES, of_one(neuro_files.read_freesurfer)),
}
