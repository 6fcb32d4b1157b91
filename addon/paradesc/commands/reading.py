"""An object as the options ask for it: its shape, the images that change it, and the space it is measured in."""

import argparse
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .. import bridge, job, spaces
from ..streams import quiet

if TYPE_CHECKING:
    import bpy

    from .. import sources


@dataclass
class Read:
    """One object's mesh."""

    arrays: bridge.MeshArrays  # in object space, as files hold it
    measured: bridge.MeshArrays  # the same in the space that is measured
    notes: list[str]
    reading: "sources.Reading"  # where its results belong


def read_object(target: "bpy.types.Object", settings: job.Settings, arguments: argparse.Namespace) -> Read:
    """Reads the object's mesh, by --source before or after modifiers; the mesh stays as it is."""
    from .. import mesh_io, sources, targets

    own_normals, needs_uvs = settings.options.normals == "mesh", settings.backend != "reference"
    reading = sources.read(target, arguments.source, own_normals, needs_uvs)
    arrays, notes = reading.arrays, list(reading.notes)
    if reading.source == "original":
        notes += targets.take_shape(target, arrays, arguments.shape_key or "basis")
    notes += add_maps(target, arrays, arguments)
    sources.check_maps(reading)
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
    return Read(arrays, measured, notes, reading)


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
