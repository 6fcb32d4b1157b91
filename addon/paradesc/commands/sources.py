"""Finds the meshes of a command: in files that Paradesc itself reads, or in Blender's scene by the add-on."""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any

import numpy as np

from ..bridge import MeshArrays
from ..core import job, uv_faults
from ..core.polygons import PolygonMesh
from ..core.standard_streams import quiet
from ..files import mesh_files
from . import file_reading
from .common import BLENDER, BLENDER_PART

Target = Any  # a PolygonMesh, or an object of Blender's scene
Source = Any  # a FileSource, or the add-on's SceneSource
Read = Any  # a FileRead, or the add-on's targets.Read
UV_NAME = "UVMap"  # of the only UV map in a file whose format has no names for UV maps


@dataclass
class Opened:
    """The objects to work on, and notes about how they were found."""

    objects: list[Target]
    notes: list[str] = field(default_factory=list)


@dataclass
class Subject:
    """A mesh to describe: facts that are always reported, and a function that reads the mesh."""

    facts: dict[str, object]
    vertices: int
    faces: int
    uv_name: str | None
    uvs: np.ndarray | None  # (corner_count, 2) float32 of the active UV map, even an unusable one
    read: Callable[[], MeshArrays]  # raises ParadescError if it cannot be read
    notes: list[str] = field(default_factory=list)


class FileSource:
    """The meshes of a file that Paradesc itself reads; SceneSource has these methods, and more, for Blender's scene."""

    unwraps = False

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments, self.meshes = arguments, []

    def open(self) -> list[str]:
        """Reads the file."""
        file_reading.check_options(self.arguments)
        self.meshes = mesh_files.read(self.arguments.input)
        return []

    def one(self, name: str | None) -> PolygonMesh:
        """The mesh of this name; without one, the object that stands out, which is the largest."""
        return file_reading.chosen(self.meshes, [] if name is None else [name])[0]

    def picked(self) -> Opened:
        """The meshes that --all or --object ask for, or the largest."""
        names = self.arguments.object
        return Opened(self.meshes if self.arguments.all else file_reading.chosen(self.meshes, names))

    def everything(self) -> list[PolygonMesh]:
        """All meshes of the file."""
        return self.meshes

    def described(self) -> list[PolygonMesh]:
        """All meshes, or those that --object names."""
        names = self.arguments.object
        return file_reading.chosen(self.meshes, names) if names else self.meshes

    @contextmanager
    def detailed(self) -> Iterator[list[PolygonMesh]]:
        """The meshes of --from-file, or of the input."""
        other = self.arguments.from_file
        yield self.meshes if other is None else mesh_files.read(other)

    def named(self, there: list[PolygonMesh], names: list[str]) -> list[PolygonMesh]:
        """The meshes of these names, each once."""
        return file_reading.chosen(there, names)

    def has_faces(self, _mesh: PolygonMesh) -> bool:
        """Meshes of files always have some."""
        return True

    def mesh_name(self, mesh: PolygonMesh) -> str:
        """The name of the object's mesh, which objects may share; of files, the mesh is the object."""
        return mesh.name

    def read(self, mesh: PolygonMesh, settings: job.Settings) -> file_reading.FileRead:
        """Reads the mesh as the options ask; the mesh stays as it is."""
        return file_reading.read_mesh(mesh, settings, self.arguments)

    def read_high(self, mesh: PolygonMesh, settings: job.Settings) -> file_reading.FileRead:
        """Reads a detailed mesh. It is measured at its vertices and needs no UV map."""
        settings = replace(settings, options=replace(settings.options, evaluate="vertex"))
        return file_reading.read_mesh(mesh, settings, self.arguments, has_images=False)

    def subject(self, mesh: PolygonMesh) -> Subject:
        """A mesh has only its shape; formats with one UV map do not name it."""
        arrays, uvs = mesh.arrays, mesh.arrays.corner_uvs
        facts: dict[str, object] = {
            "object": mesh.name,
            "mesh": mesh.name,
            "renders": True,
            "linked": False,
            "scale": [round(float(size), 6) for size in np.linalg.norm(mesh.matrix_world[:3, :3], axis=0)],
            "modifiers": [],
            "shape_keys": 0,
            "uv_maps": [] if uvs is None else [UV_NAME],
            "baked": [],
            "obstacle": "",
        }
        if uv_faults.fault(uvs, arrays.triangle_corners):
            arrays = replace(arrays, corner_uvs=None)
        name = None if uvs is None else UV_NAME
        return Subject(facts, len(arrays.positions), mesh.face_count, name, uvs, lambda: arrays, mesh.notes)


def source_of(arguments: argparse.Namespace) -> Source:
    """The source of the input, which is not open yet."""
    return FileSource(arguments) if file_reading.reads_files(arguments) else scene_source(arguments)


def scene_source(arguments: argparse.Namespace) -> Any:
    """Blender's scene: by the add-on that is enabled, else by the package beside this one."""
    is_open = "bpy" in sys.modules  # in Blender, and in scripts that made a scene
    try:
        with quiet(getattr(arguments, "verbose", False)):
            kind = BLENDER[-1] if BLENDER else import_module(f"{BLENDER_PART}.source").SceneSource
    except ImportError as error:
        raise file_reading.missing(arguments) from error
    return kind(arguments, is_open)


def world_matrix(target: Target) -> np.ndarray:
    """(4, 4) float64 matrix from object space to world space."""
    return np.array(target.matrix_world, np.float64)
