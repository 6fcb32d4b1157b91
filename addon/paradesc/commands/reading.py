"""An object as the options ask for it: its shape, the images that change it, and the space it is measured in."""

import argparse
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .. import bridge, job, spaces
from ..streams import quiet

if TYPE_CHECKING:
    import bpy


@dataclass
class Read:
    """One object's mesh."""

    arrays: bridge.MeshArrays  # in object space, as files hold it
    measured: bridge.MeshArrays  # the same in the space that is measured
    notes: list[str]


def read_object(target: "bpy.types.Object", settings: job.Settings, arguments: argparse.Namespace) -> Read:
    """Reads the object's mesh, before modifiers; the mesh stays as it is."""
    from .. import mesh_io, targets

    arrays = mesh_io.read_object(target, settings.options.normals == "mesh", settings.backend != "reference")
    notes = targets.take_shape(target, arrays, arguments.shape_key or "basis")
    notes += add_maps(target, arrays, arguments)
    measured, matrix = replace(arrays), mesh_io.world_matrix(target)
    if settings.space == "world":
        if arrays.maps is not None:
            measured.maps = replace(arrays.maps)
        spaces.to_world(measured, matrix, target.name)
    elif not spaces.is_even(matrix):
        notes.append(
            f'The object "{target.name}" is scaled differently along its axes, but was measured without its scale; '
            "give --space world, or apply the scale."
        )
    return Read(arrays, measured, notes)


def add_maps(target: "bpy.types.Object", arrays: bridge.MeshArrays, arguments: argparse.Namespace) -> list[str]:
    """Puts the maps asked for into the arrays; gives a sentence about each. compare has no such options."""
    if not hasattr(arguments, "displacement"):
        return []
    from .. import surface_maps

    sources = surface_maps.Sources(
        arguments.displacement,
        arguments.midlevel,
        arguments.displacement_scale,
        arguments.normal_map,
        arguments.material_maps,
    )
    with quiet(arguments.verbose):
        return surface_maps.add_maps(target, arrays, sources)
