"""Opens mesh files without Blender: decides who reads a file, picks its meshes, and reads them as the options ask."""

import argparse
from dataclasses import dataclass, field, replace

from .. import bridge
from ..bridge import InputError, ParadescError, abi
from ..core import job, spaces, uv_faults
from ..files import mesh_files
from ..files.mesh_files import FileMesh
from .common import UsageError, has_blender
from .images import paths_of

READERS = ("auto", "blender", "files")
BLENDER_LACKS = (".off",)
KNOWN = ", ".join(mesh_files.SUFFIXES)
# Options that are about what only Blender's files have, or that Blender does.
BY_BLENDER = {
    "scene_settings": "--scene-settings takes the panel's settings from a .blend",
    "material_maps": "--material-maps takes images from Blender's materials",
    "displacement": "--displacement has Blender read an image",
    "normal_map": "--normal-map has Blender read an image",
}


@dataclass
class FileRead:
    """One mesh of a file, as targets.Read is one of an object."""

    arrays: bridge.MeshArrays  # as the file holds it
    measured: bridge.MeshArrays  # the same in the space that is measured
    notes: list[str]
    reading: None = field(default=None)  # its results belong to no scene


def reads_files(arguments: argparse.Namespace) -> bool:
    """Whether the input is read without Blender: where --reader says so, or where Blender is missing or cannot."""
    if arguments.input is None or arguments.reader == "blender":
        return False
    suffix = arguments.input.suffix.lower()
    if arguments.reader == "files":
        return True
    return suffix in BLENDER_LACKS or (suffix in mesh_files.SUFFIXES and not has_blender())


def missing(arguments: argparse.Namespace) -> Exception:
    """The error where Blender's module is needed to open the input and is not installed."""
    if arguments.input is None:
        return UsageError(f"INPUT is missing; give a file: {KNOWN}.")
    found, suffix = "Blender's Python module bpy is not installed here", arguments.input.suffix.lower()
    if suffix in mesh_files.SUFFIXES:
        sentence = f"{found}; pip install bpy, or leave --reader blender out."
    elif arguments.input.is_file():
        sentence = f'{found} to open "{arguments.input}"; pip install bpy, or give one of {KNOWN}.'
    else:
        return InputError(f'There is no file "{arguments.input}".')
    return ParadescError(abi.STATUS_UNSUPPORTED, sentence)


def refused(what: str) -> Exception:
    """The error for what files alone do not offer."""
    if has_blender():
        return UsageError(f"{what}; choose --reader blender and a file that Blender opens, or leave it out.")
    sentence = f"{what}, and Blender's Python module bpy is not installed here; pip install bpy, or leave it out."
    return ParadescError(abi.STATUS_UNSUPPORTED, sentence)


def open_files(arguments: argparse.Namespace) -> list[FileMesh]:
    """The meshes of the input."""
    check_options(arguments)
    return mesh_files.read(arguments.input)


def check_options(arguments: argparse.Namespace) -> None:
    """Refuses options that need Blender, before anything is read."""
    for name, what in BY_BLENDER.items():
        if getattr(arguments, name, None):
            raise refused(what)
    other = getattr(arguments, "from_file", None)
    if other is not None and other.is_file() and other.suffix.lower() not in mesh_files.SUFFIXES:
        raise refused(f'"{other}" is opened by Blender')
    if any(path.suffix.lower() == ".blend" for path in getattr(arguments, "output", [])):
        raise refused("A .blend is written by Blender")


def chosen(meshes: list[FileMesh], names: list[str]) -> list[FileMesh]:
    """The meshes of these names, each once; without names the one with the most vertices."""
    if not names:
        return [max(meshes, key=lambda mesh: len(mesh.arrays.positions))]
    by_name = {mesh.name: mesh for mesh in meshes}
    for name in names:
        if name not in by_name:
            known = ", ".join(f'"{other}"' for other in list(by_name)[:8])
            raise InputError(f'There is no object "{name}"; mesh objects: {known}.')
    return [by_name[name] for name in dict.fromkeys(names)]


def read_mesh(
    mesh: FileMesh, settings: job.Settings, arguments: argparse.Namespace, has_images: bool = True
) -> FileRead:
    """Reads a mesh of a file as it is measured: with a usable UV map or none, in the space that is asked for.

    has_images: those that are asked for are of its UV map.
    """
    arrays = replace(mesh.arrays)
    reason = uv_faults.fault(arrays.corner_uvs, arrays.triangle_corners)
    if reason:
        if job.needs_uvs(job.without_uvs(settings)) or (has_images and writes_images(arguments)):
            raise InputError(
                f'The mesh "{mesh.name}" {reason}, and without Blender it cannot be unwrapped; give it one, or '
                "pip install bpy, or compute at vertices (--backend cpu, no image)."
            )
        arrays.corner_uvs = None
    if settings.options.normals == "mesh":
        if mesh.corner_normals is None:
            raise InputError(f'The file has no normals for "{mesh.name}"; choose fitted ones.')
        arrays.corner_normals = spaces.unit(mesh.corner_normals)
    measured, notes = spaces.measured(arrays, mesh.matrix_world, mesh.name, settings.space, "give --space world")
    return FileRead(arrays, measured, [*mesh.notes, *notes])


def writes_images(arguments: argparse.Namespace) -> bool:
    """Whether what is asked for lies over UV coordinates, wherever it is computed."""
    buffers = getattr(arguments, "dump_buffers", None) is not None
    return buffers or (hasattr(arguments, "map") and bool(paths_of(arguments)))
