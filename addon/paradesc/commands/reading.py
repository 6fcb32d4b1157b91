"""Reads an object as the options ask: its shape, the images that change it, and the space it is measured in."""

import argparse
from typing import TYPE_CHECKING, Union

import numpy as np

from ..core import job
from ..core.standard_streams import quiet
from ..files.mesh_files import FileMesh
from .common import saves_scene
from .file_reading import FileRead, map_sources, read_mesh

if TYPE_CHECKING:
    import bpy

    from ..scene.targets import Read

# A command works on an object of Blender's scene, or on a mesh of a file that was read without Blender.
Target = Union["bpy.types.Object", FileMesh]


def read_object(target: Target, settings: job.Settings, arguments: argparse.Namespace) -> "Read | FileRead":
    """Reads the object's mesh, by --source before or after modifiers; the mesh stays as it is."""
    if isinstance(target, FileMesh):
        return read_mesh(target, settings, arguments)
    from ..scene import targets

    shape = arguments.shape_key or "basis"
    buffers = getattr(arguments, "dump_buffers", None) is not None
    maps, remedy = map_sources(arguments), "give --space world"
    request = targets.ReadRequest(shape, maps, arguments.source, buffers, saves_scene(arguments), remedy)
    with quiet(arguments.verbose):
        read = targets.read(target, settings, request)
    read.notes += [*read.warnings, *read.map_notes]
    return read


def mesh_name(target: Target) -> str:
    """The name of the object's mesh; objects that share a mesh have the same."""
    return target.name if isinstance(target, FileMesh) else target.data.name_full


def world_matrix(target: Target) -> np.ndarray:
    """(4, 4) float64 matrix from object space to world space."""
    return np.array(target.matrix_world, np.float64)
