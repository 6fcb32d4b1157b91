"""Writes images of baked values over the UV maps, tile after tile if a map has UDIM tiles."""

import argparse
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from .. import bridge
from ..bridge import MeshArrays, ProgressFunction
from ..core import udim
from ..files import exr, file_names, image_files, maps, tile_names
from ..files.results import Baked, write_whole

Rows = list[dict[str, object]]


def paths_of(arguments: argparse.Namespace) -> list[Path]:
    """The paths of all images to write: those of --map, and outputs that are .exr files."""
    return [*arguments.map, *(path for path in arguments.output if path.suffix.lower() == ".exr")]


def tiles_of(name: str, arrays: MeshArrays, arguments: argparse.Namespace) -> tuple[int, ...]:
    """The UDIM tiles that the images of an object have; refuses a map without any where a path wants their numbers."""
    paths, tiling = paths_of(arguments), udim.of_mesh(arrays)
    asked = [path for path in paths if tile_names.TOKEN in path.name]
    if asked and arrays.map_fault:
        raise bridge.InputError(f'The mesh of "{name}" {arrays.map_fault}; unwrap it.')
    if asked and not (tiling.tiles or tiling.first):
        why = tiling.why or udim.OUTSIDE
        raise bridge.InputError(f'"{asked[0].name}" stands for the UDIM tiles of "{name}", which has none. {why}')
    return tiling.tiles if paths else ()


def write_images(baked: list[Baked], arguments: argparse.Namespace, progress: ProgressFunction | None = None) -> Rows:
    """Writes the images of each object, with its name if there are several; returns their rows of the report."""
    paths = paths_of(arguments)
    rows: list[Rows] = [[] for _ in paths]
    for one in baked if paths else []:
        tiling = udim.of_mesh(one.arrays)
        pngs = any(path.suffix.lower() == ".png" for path in arguments.map) and spans_values(arguments)
        # The range that .png images of several tiles share.
        ends = maps.ends_of_tiles(one, tiling.tiles, progress) if pngs and len(tiling.tiles) > 1 else {}
        for tile in tiling.tiles or (None,):
            part = replace(one, results=one.results.of_tile(tile, progress))
            for path, found in zip(paths, rows, strict=True):
                own = path if len(baked) == 1 else tile_names.with_word(path, file_name(one, baked))
                found += written(own, part, tile, ends, arguments)
        one.results.finish_tiles()
        said = [*maps.notes(one), *tiling.notes, *one.results.notes]
        one.notes += [note for note in said if note not in one.notes]
        one.results.warnings += [line for line in tiling.warnings if line not in one.results.warnings]
    return [row for found in rows for row in found]


def spans_values(arguments: argparse.Namespace) -> bool:
    """Returns whether .png images span the range from the smallest value to the largest."""
    return not arguments.pack and arguments.png_range != "colors"


def written(
    path: Path, part: Baked, tile: int | None, ends: dict[str, tuple[float, float]], arguments: argparse.Namespace
) -> Rows:
    """Writes the images of one object and tile that belong to a path."""
    shown = maps.cut_of(part, tile)
    number = udim.FIRST if tile is None and tile_names.TOKEN in path.name else tile
    rows: Rows = []

    def write(name: Path, writer: Callable[..., dict[str, object] | None], *more: object) -> None:
        place = tile_names.of_tile(name, tile)
        row = {"path": str(place), "object": part.object_name, **({} if number is None else {"tile": number})}
        write_whole(place, part, lambda at, content: row.update(writer(at, content, *more) or {}))
        rows.append(row)

    places = maps.png_paths(path, list(part.results.values))
    if path.suffix.lower() == ".exr":
        write(path, lambda at, content: exr.write_exr(at, maps.channels_of(content, shown)))
    elif spans_values(arguments):
        for name, place in places.items():
            write(place, maps.write_png, name, shown, ends.get(name))
    elif not arguments.pack:
        for name, place in places.items():
            write(place, write_texture, [name], shown)
    else:
        for suffix in part.results.field_reports:  # of each radius
            place = tile_names.with_word(path, f"{image_files.PACKED_WORD}{suffix}")
            write(place, write_texture, [name + suffix for name in arguments.pack], shown)
    return rows


def write_texture(path: Path, baked: Baked, names: list[str], shown: udim.Cut | None) -> dict[str, object]:
    """Writes descriptors as channels over the range of their colors; returns the facts about them."""
    sources = [(baked, name) for name in names]
    made = image_files.encoded(sources, baked.results.settings.options.texels, shown=shown)
    path.write_bytes(made.content)
    described = [
        {"descriptor": name, "minimum": scale.low, "maximum": scale.high}
        for name, scale in zip(names, made.scales, strict=True)
    ]
    return described[0] if len(names) == 1 else {"channels": described}


def file_name(one: Baked, baked: list[Baked]) -> str:
    """An object's name as part of a file name, with a number if some file system takes two objects' names for one."""
    names = file_names.distinct([re.sub(f"[^.{file_names.KEPT}]+", "_", other.object_name) for other in baked])
    return next(name for name, other in zip(names, baked, strict=True) if other is one)
