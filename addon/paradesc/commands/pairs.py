"""bake from detailed objects onto low-poly ones: which belong together, and where the detailed ones come from."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..core import job, pair_names, transfer
from ..core.standard_streams import quiet
from .common import Parser, UsageError
from .file_reading import open_files, reads_files
from .opening import Opened, open_input, open_objects
from .reading import read_object

if TYPE_CHECKING:
    import bpy

    from ..scene.targets import Read


def add_pair_options(parser: Parser) -> None:
    """Adds the options that bring values of detailed objects to the UV map of low-poly ones."""
    add = parser.add_argument
    add("--from", action="append", default=[], dest="from_objects", metavar="HIGH",
        help="measure this detailed object, for the UV map and the vertices of --object; again for more")  # fmt: skip
    add("--from-file", metavar="FILE", type=Path,
        help="look for detailed objects in this file (without --from and --pairs: all of its objects)")  # fmt: skip
    add("--pairs", action="store_true",
        help="measure X_high, X_high_bolts, ... for every object X_low, or for those of --object")  # fmt: skip
    add("--cage", type=float, metavar="D",
        help="how far from the low-poly surface, to both sides along its normals, the detailed one is looked for, in "
        "the world's units (default: a tenth of its diagonal)")  # fmt: skip


def is_asked(arguments: argparse.Namespace) -> bool:
    """Whether values come from other objects."""
    return bool(arguments.from_objects or arguments.from_file or arguments.pairs)


def check_pair_options(arguments: argparse.Namespace) -> None:
    """Refuses what makes no sense, before any file is opened."""
    if not is_asked(arguments):
        if arguments.cage is not None:
            raise UsageError("--cage is the distance to detailed objects; give --from, --from-file or --pairs as well.")
        return
    if arguments.cage is not None:
        transfer.check_cage(arguments.cage)
    if arguments.from_objects and arguments.pairs:
        raise UsageError("Detailed objects are named or found by their names; give --from or --pairs, not both.")
    if arguments.all:
        raise UsageError("Low-poly objects are few; give --object or --pairs instead of --all.")
    if len(arguments.object) > 1 and not arguments.pairs:
        raise UsageError("--from and --from-file belong to one --object; give --pairs to tell more by their names.")
    for option, given in (("--dump-buffers", arguments.dump_buffers), ("--corners", arguments.corners)):
        if given is not None:
            raise UsageError(f"{option} is about the mesh that is measured; leave it out, or bake that mesh itself.")
    if arguments.displacement or arguments.normal_map or arguments.material_maps:
        raise UsageError("Maps belong to the mesh that is measured; leave them out, or bake that mesh itself.")


def highs_of(
    lows: list["bpy.types.Object"], arguments: argparse.Namespace
) -> dict["bpy.types.Object", list["bpy.types.Object"]]:
    """The detailed objects of each low-poly one, added to the open scene if they are in another file."""
    from ..scene import scene_io

    if arguments.from_file is not None:
        there = scene_io.add_objects(arguments.from_file, arguments.verbose)
    else:
        there = scene_io.mesh_objects()
    if arguments.pairs:
        return by_name(lows, there)
    (low,) = lows
    if arguments.from_objects:
        added = arguments.from_file is not None
        found = [scene_io.find_among(there, name, numbered=added) for name in dict.fromkeys(arguments.from_objects)]
    else:
        found = [item for item in there if item.data.polygons]
    if low in found:
        raise UsageError(f'The object "{low.name}" cannot be detailed and low-poly at once; name another one.')
    return {low: found}


def opened_lows(arguments: argparse.Namespace) -> Opened:
    """Opens the input and picks the low-poly objects: with --pairs by their names, unless --object names them."""
    if not arguments.pairs or arguments.object:
        return open_objects(arguments)
    if reads_files(arguments):
        open_files(arguments)  # which refuses
    _, notes = open_input(arguments)
    from ..scene import mesh_io, scene_io

    lows = [item for item in scene_io.mesh_objects() if pair_names.LOW.fullmatch(item.name)]
    if not lows:
        raise mesh_io.refuse("No mesh object has a name that ends in _low.")
    return Opened(sorted(lows, key=lambda item: item.name), notes)


def by_name(
    lows: list["bpy.types.Object"], there: list["bpy.types.Object"]
) -> dict["bpy.types.Object", list["bpy.types.Object"]]:
    """The detailed objects of each low-poly one by their names; refuses one without any."""
    from ..scene import mesh_io, pairs

    named = pairs.by_name(list({*lows, *there}))
    found = {low: [item for item in named.get(low, []) if item in there] for low in lows}
    for low, highs in found.items():
        if not highs:
            raise mesh_io.refuse(f'No mesh object is named as "{low.name}" with _high in place of _low.')
    return found


def run_onto(
    low: "bpy.types.Object",
    read: "Read",
    highs: list["bpy.types.Object"],
    settings: job.Settings,
    arguments: argparse.Namespace,
    tiles: tuple[int, ...],
    progress: object,
) -> tuple[job.Results, list[str]]:
    """Measures the detailed objects for one low-poly one, which has been read; sentences about how they were read."""
    from ..scene import mesh_io, pairs

    if read.arrays.corner_uvs is None or read.arrays.layout is not None:
        raise mesh_io.refuse(f'The mesh "{low.data.name}" has no usable UV map; unwrap it.')
    parts, notes = [], []
    for high in highs:
        with quiet(arguments.verbose):
            found = read_object(high, settings, arguments)
        notes += pairs.notes_of(found)
        parts.append(pairs.part_of(high, found))
    size, cage = settings.options.texels, arguments.cage or 0.0
    results = transfer.run(pairs.part_of(low, read), parts, settings, size, cage, progress, tiles)
    return results, [*notes, *results.notes]
