"""Opens mesh files without Blender: decides who reads a file, picks its meshes, and reads them as the options ask."""

import argparse
from dataclasses import dataclass, field, replace

from .. import bridge
from ..bridge import InputError, ParadescError, abi
from ..core import job, spaces, tangents, uv_faults
from ..core.polygons import PolygonMesh
from ..files import map_images, mesh_files
from ..files.map_images import MapChoice
from ..files.paths import is_file
from .common import UsageError, has_blender, lacking, saves_scene
from .images import paths_of

READERS = ("auto", "blender", "files")
KNOWN = ", ".join(mesh_files.SUFFIXES)
# In place of what is lacking, where all is there and cannot be imported.
BROKEN = "Blender's Python module bpy cannot be imported here", "install it again"
# Options that concern data only .blend files have, or work that Blender does.
BY_BLENDER = {
    "scene_settings": "--scene-settings takes the panel's settings from a .blend",
    "material_maps": "--material-maps takes images from Blender's materials",
}


@dataclass
class FileRead:
    """One mesh of a file that was read; targets.Read is its counterpart for objects."""

    arrays: bridge.MeshArrays  # as the file holds it
    measured: bridge.MeshArrays  # the same in the space that is measured
    notes: list[str]
    reading: None = field(default=None)  # None, because the results belong to no scene


def reads_files(arguments: argparse.Namespace) -> bool:
    """Whether the input is read without Blender: by --reader, or because Blender is missing or lacks the format."""
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


def refused(what: str) -> Exception:
    """The error for a request that needs Blender."""
    if has_blender():
        return UsageError(f"{what}; choose --reader blender and a file that Blender opens, or leave it out.")
    found, remedy = lacking()
    sentence = f"{what}, and {found}; {remedy}, or leave it out."
    return ParadescError(abi.STATUS_UNSUPPORTED, sentence)


def check_options(arguments: argparse.Namespace) -> None:
    """Refuses options that need Blender, before any file is read."""
    for name, what in BY_BLENDER.items():
        if getattr(arguments, name, None):
            raise refused(what)
    other = getattr(arguments, "from_file", None)
    if other is not None and is_file(other) and other.suffix.lower() not in mesh_files.SUFFIXES:
        raise refused(f'"{other}" is opened by Blender')
    if saves_scene(arguments):
        raise refused("A .blend is written by Blender")


def chosen(meshes: list[PolygonMesh], names: list[str]) -> list[PolygonMesh]:
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
    mesh: PolygonMesh,
    settings: job.Settings,
    arguments: argparse.Namespace,
    has_images: bool = True,
    maps: MapChoice | None = None,
) -> FileRead:
    """Reads a mesh of a file as it is measured: with a usable UV map or none, in the space that is asked for.

    has_images: those that are asked for are of its UV map. maps: those that the options name, if none are given.
    """
    maps = map_sources(arguments) if maps is None else maps
    arrays = replace(mesh.arrays)
    reason = arrays.uv_fault = uv_faults.fault(arrays.corner_uvs, arrays.triangle_corners)
    if reason:
        buffers = getattr(arguments, "dump_buffers", None) is not None
        are_written = has_images and (buffers or (hasattr(arguments, "map") and bool(paths_of(arguments))))
        if are_written or job.needs_uvs(settings):
            raise InputError(
                f'The mesh "{mesh.name}" {reason}, and without Blender it cannot be unwrapped; give it one, or '
                "pip install bpy, or compute at vertices (--backend cpu, no image)."
            )
        arrays.corner_uvs = None
    map_notes = add_maps(mesh, arrays, reason, maps)
    if settings.options.normals == "mesh":
        if mesh.corner_normals is None:
            raise InputError(f'The file has no normals for "{mesh.name}"; choose fitted ones.')
        arrays.corner_normals = spaces.unit(mesh.corner_normals)
    measured, notes = spaces.measured(arrays, mesh.matrix_world, mesh.name, settings.space, "give --space world")
    if reason and mesh.arrays.corner_uvs is not None:
        notes.append(f'The mesh "{mesh.name}" {reason}, which was left out.')
    return FileRead(arrays, measured, [*mesh.notes, *notes, *map_notes])


def map_sources(arguments: argparse.Namespace) -> MapChoice:
    """The displacement and normal maps that the options name; compare has no such options."""
    if not hasattr(arguments, "displacement"):
        return MapChoice()
    return MapChoice(
        arguments.displacement,
        arguments.midlevel,
        arguments.displacement_scale,
        arguments.normal_map,
        arguments.material_maps,
    )


def add_maps(mesh: PolygonMesh, arrays: bridge.MeshArrays, uv_fault: str, choice: MapChoice) -> list[str]:
    """Adds the maps, and the mesh data that they need, to the arrays; returns a note about each map."""
    if not choice.any:
        return []
    if uv_fault:
        raise InputError(f'The mesh "{mesh.name}" {uv_fault} for displacement and normal maps; unwrap it.')
    if choice.normal_map is not None and mesh.corner_normals is None:
        sentence = f'The file has no normals for "{mesh.name}", in whose tangent space a normal map lies'
        raise InputError(f"{sentence}; export them with it.")
    maps = bridge.SurfaceMaps()
    notes = map_images.of_files(choice, maps, map_images.read_image)
    if maps.normals is not None:
        arrays.corner_normals = spaces.unit(mesh.corner_normals)
        maps.corner_tangents = tangents.corner_tangents(arrays)
    arrays.maps = maps
    return notes
