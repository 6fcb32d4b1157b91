"""Bakes from detailed objects onto low-poly ones: finds which belong together, and opens and measures them."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..bridge import InputError
from ..core import job, pair_names, transfer
from ..core.standard_streams import quiet
from ..files import mesh_files
from ..files.mesh_files import FileMesh
from .common import Parser, UsageError
from .file_reading import FileRead, chosen, open_files, read_mesh, reads_files
from .opening import Opened, open_input, open_objects
from .reading import Target, mesh_name, read_object, world_matrix

if TYPE_CHECKING:
    from ..scene.targets import Read


def add_pair_options(parser: Parser) -> None:
    """Adds the options that bring values of detailed objects to the UV map of low-poly ones."""
    add = parser.add_argument
    add("--from", action="append", default=[], dest="from_objects", metavar="HIGH",
        help="measure this detailed object, for the UV map and the vertices of --object; again for more")  # fmt: skip
    add("--from-file", metavar="FILE", type=Path,
        help="search detailed objects in this file (without --from and --pairs: all of its objects)")  # fmt: skip
    add("--pairs", action="store_true",
        help="measure X_high, X_high_bolts, ... for every object X_low, or for those of --object")  # fmt: skip
    add("--cage", type=float, metavar="D",
        help="distance from the low-poly surface, to both sides along its normals, within which the detailed one is "
        "searched, in units of the world (default: a tenth of its diagonal)")  # fmt: skip


def is_asked(arguments: argparse.Namespace) -> bool:
    """Whether the options ask for values of detailed objects."""
    return bool(arguments.from_objects or arguments.from_file or arguments.pairs)


def check_pair_options(arguments: argparse.Namespace) -> None:
    """Refuses options that contradict each other, before any file is opened."""
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


def opened_lows(arguments: argparse.Namespace) -> Opened:
    """Opens the input and picks the low-poly objects: with --pairs by their names, unless --object names them."""
    if not arguments.pairs or arguments.object:
        return open_objects(arguments)
    if reads_files(arguments):
        there, notes = open_files(arguments), []
        opened = Opened([], beside=there)
    else:
        _, notes = open_input(arguments)
        from ..scene import scene_io

        there = scene_io.mesh_objects()
        opened = Opened([], notes)
    lows = [item for item in there if pair_names.LOW.fullmatch(item.name)]
    if not lows:
        raise InputError("No mesh object has a name that ends in _low.")
    opened.objects = sorted(lows, key=lambda item: item.name)
    return opened


@contextmanager
def with_highs(opened: Opened, arguments: argparse.Namespace) -> Iterator[dict[Target, list[Target]]]:
    """Yields the detailed objects of each low-poly one. Those of another file are in the open scene until the end."""
    if reads_files(arguments):
        other = arguments.from_file
        yield highs_of(opened.objects, opened.beside if other is None else mesh_files.read(other), arguments)
        return
    from ..scene import scene_io

    with scene_io.without_added():
        if arguments.from_file is not None:
            there = scene_io.add_objects(arguments.from_file, arguments.verbose)
        else:
            there = scene_io.mesh_objects()
        yield highs_of(opened.objects, there, arguments)


def highs_of(lows: list[Target], there: list[Target], arguments: argparse.Namespace) -> dict[Target, list[Target]]:
    """The detailed objects of each low-poly one, taken from the existing objects."""
    if arguments.pairs:
        return by_name(lows, there)
    (low,) = lows
    found = named(there, arguments) if arguments.from_objects else [item for item in there if has_faces(item)]
    if low in found:
        raise UsageError(f'The object "{low.name}" cannot be detailed and low-poly at once; name another one.')
    return {low: found}


def named(there: list[Target], arguments: argparse.Namespace) -> list[Target]:
    """The objects that --from names, each once."""
    if reads_files(arguments):
        return chosen(there, arguments.from_objects)
    from ..scene import scene_io

    added = arguments.from_file is not None
    return [scene_io.find_among(there, name, numbered=added) for name in dict.fromkeys(arguments.from_objects)]


def has_faces(target: Target) -> bool:
    """Whether the object has faces; meshes of files always have some."""
    return isinstance(target, FileMesh) or bool(target.data.polygons)


def by_name(lows: list[Target], there: list[Target]) -> dict[Target, list[Target]]:
    """The detailed objects of each low-poly one, by names; refuses a low-poly one without any."""
    among = {item.name: item for item in there}
    pairs = pair_names.pairs_of(dict.fromkeys([*(low.name for low in lows), *among]))
    found = {low: [among[name] for name in pairs.get(low.name, []) if name in among] for low in lows}
    for low, highs in found.items():
        if not highs:
            raise InputError(f'No mesh object is named as "{low.name}" with _high in place of _low.')
    return found


# ---- Baking


def read_low(low: Target, settings: job.Settings, arguments: argparse.Namespace) -> "Read | FileRead":
    """Reads the low-poly object; its own normals are not measured."""
    options = replace(settings.options, normals="fitted")
    return read_object(low, replace(settings, options=options), arguments)


def read_high(high: Target, settings: job.Settings, arguments: argparse.Namespace) -> "Read | FileRead":
    """Reads a detailed object. It is measured at its vertices and needs no UV map."""
    if isinstance(high, FileMesh):
        options = replace(settings.options, evaluate="vertex")
        return read_mesh(high, replace(settings, options=options), arguments, has_images=False)
    with quiet(arguments.verbose):
        return read_object(high, settings, arguments)


def part_of(target: Target, read: "Read | FileRead") -> transfer.Part:
    """The object as transfer takes it: as it was read, with its place in the world."""
    return transfer.Part(target.name, read.arrays, read.measured, world_matrix(target))


def run_onto(
    low: Target,
    read: "Read | FileRead",
    highs: list[Target],
    settings: job.Settings,
    arguments: argparse.Namespace,
    tiles: tuple[int, ...],
    progress: object,
) -> tuple[job.Results, list[str]]:
    """Measures the detailed objects for one low-poly object; also returns notes about how they were read."""
    if read.arrays.map_fault:
        raise InputError(f'The mesh "{mesh_name(low)}" {read.arrays.map_fault}; unwrap it.')
    parts, notes = [], []
    for high in highs:
        found = read_high(high, settings, arguments)
        # The detailed object itself gets no results, so notes about where they would go are left out.
        notes += [note for note in found.notes if found.reading is None or note not in found.reading.notes]
        parts.append(part_of(high, found))
    size, cage = settings.options.texels, arguments.cage or 0.0
    results = transfer.run(part_of(low, read), parts, settings, size, cage, progress, tiles)
    return results, [*notes, *results.notes]
