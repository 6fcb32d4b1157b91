"""Reads an object as the options ask: its shape, the images that change it, and the space it is measured in."""

import argparse
from typing import TYPE_CHECKING

from ..core import job
from ..core.standard_streams import quiet

if TYPE_CHECKING:
    import bpy

    from ..scene.surface_maps import MapChoice
    from ..scene.targets import Read


def read_object(target: "bpy.types.Object", settings: job.Settings, arguments: argparse.Namespace) -> "Read":
    """Reads the object's mesh, by --source before or after modifiers; the mesh stays as it is."""
    from ..scene import targets

    shape = arguments.shape_key or "basis"
    buffers = getattr(arguments, "dump_buffers", None) is not None
    request = targets.ReadRequest(shape, map_sources(arguments), arguments.source, buffers, "give --space world")
    with quiet(arguments.verbose):
        read = targets.read(target, settings, request)
    read.notes += [*read.warnings, *read.map_notes]
    return read


def map_sources(arguments: argparse.Namespace) -> "MapChoice":
    """Where displacement and normal map come from; compare has no such options."""
    from ..scene import surface_maps

    if not hasattr(arguments, "displacement"):
        return surface_maps.MapChoice()
    return surface_maps.MapChoice(
        arguments.displacement,
        arguments.midlevel,
        arguments.displacement_scale,
        arguments.normal_map,
        arguments.material_maps,
    )
