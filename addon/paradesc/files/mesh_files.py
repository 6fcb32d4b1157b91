"""Reads mesh files without Blender, each format by its own reader; nibabel reads GIFTI and FreeSurfer's files.

A file's own vertices are kept in their order, whether a face uses them or not. Only the triangles of .stl, which have
no common vertices, are welded.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..bridge import InputError, ParadescError, origin
from ..core.polygons import PolygonMesh
from . import gltf_file, neuro_files, obj_file, off_file, ply_file, stl_file, vtk_legacy_file, vtp_file, wrong_kinds
from .gltf_file import UnknownError
from .paths import is_file

BLENDER_LACKS = (".off", ".vtp", ".vtk", ".gii", *neuro_files.SURFACES)
SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf", *BLENDER_LACKS)

def read(path: Path) -> list[PolygonMesh]:
    """Reads the meshes of a file that have faces, each with a unique name; raises InputError with one sentence."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f'"{path}" is none of {", ".join(SUFFIXES)}.')
    found = [mesh for mesh in polygon_meshes(path) if len(mesh.arrays.triangle_corners)]
    if not found:
        raise InputError(f'"{path}" has no faces; there is no surface to measure.')
    taken: set[str] = set()
    for mesh in found:
        stem, number = mesh.name, 0
        while mesh.name in taken:
            number += 1
            mesh.name = f"{stem}.{number:03}"
        taken.add(mesh.name)
    return found


def check(path: Path) -> int:
    """Raises the error of read() if a file that this module can read is damaged, whichever program reads it afterwards.

    Returns how many sound faces another reader has to find: 0 for files that this module does not know.
    """
    if path.suffix.lower() not in SUFFIXES:
        return 0
    try:
        return sum(map(sound_faces, polygon_meshes(path)))
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


def polygon_meshes(path: Path) -> list[PolygonMesh]:
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
            read = READERS[suffix](path)
            found = read if isinstance(read, list) else [read] if read else []
            for mesh in found:
                mesh.name = mesh.name or path.stem
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


# Each gives the meshes of a file: a list, or the only one, or None.
READERS: dict[str, Callable[[Path], list[PolygonMesh] | PolygonMesh | None]] = {
    ".obj": obj_file.read,
    ".ply": ply_file.read,
    ".stl": stl_file.read,
    ".off": off_file.read,
    ".glb": gltf_file.read,
    ".gltf": gltf_file.read,
    ".vtp": vtp_file.read,
    ".vtk": vtk_legacy_file.read,
    ".gii": neuro_files.read_gifti,
    **dict.fromkeys(neuro_files.SURFACES, neuro_files.read_freesurfer),
}
