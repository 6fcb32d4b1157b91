"""Bakes from detailed objects onto low-poly ones: finds which belong together, and opens and measures them."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..bridge import InputError
from ..core import job, pair_names, transfer
from ..files.reading import Read, part_of
from .common import Parser, UsageError
from .sources import Opened, Source, Target


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
    """Returns whether the options ask for values of detailed objects."""
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


def picked(source: Source, arguments: argparse.Namespace) -> Opened:
    """The objects to work on; with --pairs the low-poly ones by their names, unless --object names them."""
    if not arguments.pairs or arguments.object:
        return source.picked()
    lows = [item for item in source.meshes if pair_names.LOW.fullmatch(item.name)]
    if not lows:
        raise InputError("No mesh object has a name that ends in _low.")
    return Opened(sorted(lows, key=lambda item: item.name))


@contextmanager
def with_highs(
    source: Source, lows: list[Target], arguments: argparse.Namespace
) -> Iterator[dict[Target, list[Target]]]:
    """Yields the detailed objects of each low-poly one. Those of another file are in the open scene until the end."""
    with source.detailed() as there:
        if arguments.pairs:
            yield by_name(lows, there)
            return
        (low,) = lows
        found = source.named(there, arguments.from_objects)
        if low in found:
            raise UsageError(f'The object "{low.name}" cannot be detailed and low-poly at once; name another one.')
        yield {low: found}


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


def run_onto(
    source: Source,
    low: Target,
    read: Read,
    highs: list[Target],
    settings: job.Settings,
    arguments: argparse.Namespace,
    tiles: tuple[int, ...],
    progress: object,
) -> tuple[job.Results, list[str]]:
    """Measures the detailed objects for one low-poly object; also returns notes about how they were read."""
    if read.arrays.map_fault:
        raise InputError(f'The mesh "{source.mesh_name(low)}" {read.arrays.map_fault}; unwrap it.')
    found = [source.read_high(high, settings) for high in highs]
    # The detailed objects themselves get no results, so notes about where they would go are left out.
    notes = [note for one in found for note in one.sentences if note not in one.source_notes]
    onto, *parts = map(part_of, (low, *highs), (read, *found))
    size, cage = settings.options.texels, arguments.cage or 0.0
    results = transfer.run(onto, parts, settings, size, cage, progress, tiles)
    return results, [*notes, *results.notes]
