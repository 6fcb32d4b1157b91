"""Finds the meshes of a command: in files that Paradesc itself reads, or in Blender's scene by the add-on."""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, Protocol

import numpy as np

from ..bridge import MeshArrays
from ..core import job, uv_faults
from ..core.standard_streams import quiet
from ..files import mesh_files
from ..files.mesh_files import FileMesh
from . import file_reading
from .common import BLENDER, BLENDER_PART

Target = Any  # a FileMesh, or an object of Blender's scene
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


class Read(Protocol):
    """A mesh that was read: as it is, as it is measured, and for Blender where its results go."""

    arrays: MeshArrays
    measured: MeshArrays
    notes: list[str]
    reading: Any


class Source(Protocol):
    """The calls that commands make of any input. SceneSource has more: for files, what only Blender does is refused."""

    unwraps: bool

    def open(self) -> list[str]:
        """Opens the input; returns notes about it."""

    def one(self, name: str | None) -> Target:
        """The object of this name; without one, the object that stands out."""

    def picked(self) -> Opened:
        """The objects to work on: --all of them, those that --object names, or the one that stands out."""

    def everything(self) -> list[Target]:
        """All mesh objects."""

    def described(self) -> list[Target]:
        """The objects to describe: those that --object names, or all that are shapes of their own."""

    def detailed(self) -> AbstractContextManager[list[Target]]:
        """The objects among which detailed ones are looked for; those of --from-file are there until the end."""

    def named(self, there: list[Target], names: list[str]) -> list[Target]:
        """The objects of these names, each once."""

    def has_faces(self, target: Target) -> bool:
        """Whether the object has faces."""

    def mesh_name(self, target: Target) -> str:
        """The name of the object's mesh; objects that share a mesh have the same."""

    def subject(self, target: Target) -> Subject:
        """The object as something to describe."""

    def read(self, target: Target, settings: job.Settings) -> Read:
        """Reads the object's mesh as the options ask; the mesh stays as it is."""

    def read_high(self, target: Target, settings: job.Settings) -> Read:
        """Reads a detailed object. It is measured at its vertices and needs no UV map."""


class FileSource:
    """The meshes of a file that Paradesc itself reads; SceneSource has the same methods for Blender's scene."""

    unwraps = False

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments, self.meshes = arguments, []

    def open(self) -> list[str]:
        """Reads the file."""
        self.meshes = file_reading.open_files(self.arguments)
        return []

    def one(self, name: str | None) -> FileMesh:
        """The mesh of this name, or the largest."""
        return file_reading.chosen(self.meshes, [] if name is None else [name])[0]

    def picked(self) -> Opened:
        """The meshes that --all or --object ask for, or the largest."""
        names = self.arguments.object
        return Opened(self.meshes if self.arguments.all else file_reading.chosen(self.meshes, names))

    def everything(self) -> list[FileMesh]:
        """All meshes of the file."""
        return self.meshes

    def described(self) -> list[FileMesh]:
        """All meshes, or those that --object names."""
        names = self.arguments.object
        return file_reading.chosen(self.meshes, names) if names else self.meshes

    @contextmanager
    def detailed(self) -> Iterator[list[FileMesh]]:
        """The meshes of --from-file, or of the input."""
        other = self.arguments.from_file
        yield self.meshes if other is None else mesh_files.read(other)

    def named(self, there: list[FileMesh], names: list[str]) -> list[FileMesh]:
        """The meshes of these names."""
        return file_reading.chosen(there, names)

    def has_faces(self, _mesh: FileMesh) -> bool:
        """Meshes of files always have some."""
        return True

    def mesh_name(self, mesh: FileMesh) -> str:
        """The mesh is the object."""
        return mesh.name

    def read(self, mesh: FileMesh, settings: job.Settings) -> file_reading.FileRead:
        """Reads the mesh with the images that the options name."""
        return file_reading.read_mesh(mesh, settings, self.arguments)

    def read_high(self, mesh: FileMesh, settings: job.Settings) -> file_reading.FileRead:
        """Reads the mesh for values at its vertices."""
        settings = replace(settings, options=replace(settings.options, evaluate="vertex"))
        return file_reading.read_mesh(mesh, settings, self.arguments, has_images=False)

    def subject(self, mesh: FileMesh) -> Subject:
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
