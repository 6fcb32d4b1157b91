"""Finds the meshes of a command: in files that Paradesc itself reads, or in Blender's scene by the add-on."""

import argparse
import re
import sys
import unicodedata
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any

import numpy as np

from ..bridge import InputError, MeshArrays, ParadescError, abi
from ..core import job, uv_faults
from ..core.polygons import PolygonMesh
from ..core.standard_streams import quiet
from ..files import mesh_files, reading
from ..files.map_images import MapChoice
from ..files.paths import is_file
from ..files.reading import Read, ReadRequest
from .common import BLENDER, BLENDER_PART, UsageError, has_blender, lacking, saves_scene
from .images import paths_of

Target = Any  # a PolygonMesh, or an object of Blender's scene
READERS = ("auto", "blender", "files")
KNOWN = ", ".join(mesh_files.SUFFIXES)
# In place of what is lacking, where all is there and cannot be imported.
BROKEN = "Blender's Python module bpy cannot be imported here", "install it again"
# Options that concern data only .blend files have, or work that Blender does.
BY_BLENDER = {
    "scene_settings": "--scene-settings takes the panel's settings from a .blend",
    "material_maps": "--material-maps takes images from Blender's materials",
}
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


class Source:
    """The meshes of a command's input: of a FileSource, or of the add-on's SceneSource, which has more methods."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments

    def picked(self) -> Opened:
        """The meshes that --all or --object ask for, or the one that stands out."""
        return self.all() if self.arguments.all else Opened(self.asked() or [self.one()])

    def asked(self) -> list[Target]:
        """The meshes that --object names, each once."""
        return [self.one(name) for name in dict.fromkeys(self.arguments.object)]

    def request(self) -> ReadRequest:
        """The request for reading a mesh that the options make."""
        given = self.arguments
        scale = given.displacement_scale
        maps = MapChoice(given.displacement, given.midlevel, scale, given.normal_map, given.material_maps)
        buffers, images = given.dump_buffers is not None, bool(paths_of(given))
        shape, source = given.shape_key or "basis", given.source
        return ReadRequest(shape, maps, source, buffers, images, saves_scene(given), "give --space world")


class FileSource(Source):
    """The meshes of a file that Paradesc itself reads. A mesh has only its shape, so the file's mesh is the object."""

    unwraps = False
    meshes: list[PolygonMesh]

    def open(self) -> list[str]:
        """Reads the file."""
        check_options(self.arguments)
        self.meshes = mesh_files.read(self.arguments.input)
        return []

    def all(self) -> Opened:
        """The meshes that --all asks for."""
        return Opened(self.meshes)

    def described(self) -> list[PolygonMesh]:
        """All meshes, or those that --object names."""
        return self.asked() or self.meshes

    def one(self, name: str | None = None) -> PolygonMesh:
        """The mesh of this name, or the largest."""
        return chosen(self.meshes, name)

    @contextmanager
    def detailed(self) -> Iterator[list[PolygonMesh]]:
        """The meshes of --from-file, or of the input."""
        other = self.arguments.from_file
        yield self.meshes if other is None else mesh_files.read(other)

    def named(self, there: list[PolygonMesh], names: list[str]) -> list[PolygonMesh]:
        """The meshes of these names, each once; all without names."""
        return [chosen(there, name) for name in dict.fromkeys(names)] or there

    def mesh_name(self, mesh: PolygonMesh) -> str:
        """The name of the object's mesh, which objects in a scene may share."""
        return mesh.name

    def read(self, mesh: PolygonMesh, settings: job.Settings) -> Read:
        """Reads the mesh as the options ask; the mesh stays as it is."""
        return reading.read_mesh(mesh, settings, self.request())

    def read_high(self, mesh: PolygonMesh, settings: job.Settings) -> Read:
        """Reads a detailed mesh. It is measured at its vertices and needs no UV map."""
        settings = replace(settings, options=replace(settings.options, evaluate="vertex"))
        return reading.read_mesh(mesh, settings, replace(self.request(), images=False))

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


def chosen(meshes: list[PolygonMesh], name: str | None) -> PolygonMesh:
    """The mesh of this name; without one the mesh with the most vertices."""
    return max(meshes, key=lambda mesh: len(mesh.arrays.positions)) if name is None else find(meshes, name)


def find(there: list[Target], name: str, numbered: bool = False) -> Target:
    """The mesh object of this name, also if its letters and accents are composed otherwise, as macOS writes them.

    numbered: a number that Blender appended to the name counts as well.
    """
    composed = unicodedata.normalize("NFC", name)
    found = [item for item in there if item.name == name]
    found = found or [item for item in there if unicodedata.normalize("NFC", item.name) == composed]
    if not found and numbered:
        found = [item for item in there if re.fullmatch(re.escape(name) + r"\.\d{3,}", item.name)]
    if not found:
        known = ", ".join(f'"{item.name}"' for item in there[:8]) or "none"
        raise InputError(f'There is no object "{name}"; mesh objects: {known}.')
    return found[0]


# ---- Who reads a file


def source_of(arguments: argparse.Namespace) -> Source:
    """The source of the input, which is not open yet."""
    return FileSource(arguments) if reads_files(arguments) else scene_source(arguments)


def scene_source(arguments: argparse.Namespace) -> Any:
    """Blender's scene: by the add-on that is enabled, else by the package beside this one."""
    is_open = "bpy" in sys.modules  # in Blender, and in scripts that made a scene
    try:
        with quiet(getattr(arguments, "verbose", False)):
            kind = BLENDER[-1] if BLENDER else import_module(f"{BLENDER_PART}.source").SceneSource
    except ImportError as error:
        raise missing(arguments) from error
    return kind(arguments, is_open)


def reads_files(arguments: argparse.Namespace) -> bool:
    """Returns whether the input is read without Blender: by --reader, or as Blender is missing or lacks the format."""
    if arguments.input is None or arguments.reader == "blender":
        return False
    suffix = arguments.input.suffix.lower()
    if arguments.reader == "files":
        return True
    return suffix in mesh_files.BLENDER_LACKS or (suffix in mesh_files.SUFFIXES and not has_blender())


def missing(arguments: argparse.Namespace) -> Exception:
    """The error where Blender's module is needed to open the input and is not installed."""
    if arguments.input is None:
        return UsageError(f"INPUT is missing; give a file: {KNOWN}.")
    (found, remedy), suffix = lacking() or BROKEN, arguments.input.suffix.lower()
    if suffix in mesh_files.SUFFIXES:
        sentence = f"{found}; {remedy}, or leave --reader blender out."
    elif is_file(arguments.input):
        sentence = f'{found} to open "{arguments.input}"; {remedy}, or give one of {KNOWN}.'
    else:
        return InputError(f'There is no file "{arguments.input}".')
    return ParadescError(abi.STATUS_UNSUPPORTED, sentence)


def check_options(arguments: argparse.Namespace) -> None:
    """Refuses options that need Blender, before any file is read."""
    other = getattr(arguments, "from_file", None)
    opened = other is not None and is_file(other) and other.suffix.lower() not in mesh_files.SUFFIXES
    needs = [what for name, what in BY_BLENDER.items() if getattr(arguments, name, None)]
    needs += [f'"{other}" is opened by Blender'] if opened else []
    needs += ["A .blend is written by Blender"] if saves_scene(arguments) else []
    if needs and has_blender():
        raise UsageError(f"{needs[0]}; choose --reader blender and a file that Blender opens, or leave it out.")
    if needs:
        found, remedy = lacking()
        raise ParadescError(abi.STATUS_UNSUPPORTED, f"{needs[0]}, and {found}; {remedy}, or leave it out.")
