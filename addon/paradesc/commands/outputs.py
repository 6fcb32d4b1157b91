"""Decides which files a bake writes, and writes each whole or not at all."""

import argparse
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

from .. import bridge
from ..bridge import ParadescError, abi, uses_texture_space
from ..core import job
from ..files import maps, neuro_files, results, tile_names, vtk_files
from ..files.results import Baked, folder_fault, write_whole
from .common import Parser, Progress, UsageError, check_outputs, check_overwriting, refuse
from .images import file_name, paths_of, write_images
from .sources import Source

# These formats hold one object, or several joined into one in world space.
WRITERS: dict[str, Callable[[Path, Baked], None]] = {
    ".ply": results.write_ply,
    ".vtp": vtk_files.write_vtp,
    ".vtk": vtk_files.write_vtk,
    ".gii": neuro_files.write_gifti,
    ".curv": neuro_files.write_curv,
}
OF_FACES = (".npz", ".ply", ".vtp", ".vtk")
PNG_RANGES = ("values", "colors")


def add_output_files(parser: Parser) -> None:
    """Adds the options for the files to write."""
    add = parser.add_argument
    output = (
        ".blend, .npz, .ply, .vtp or .vtk (for ParaView), .gii (GIFTI), .curv (FreeSurfer, of one descriptor) or "
        ".exr (image over the UV map); give it again for more"
    )
    image = (
        "write images over the UV map, --texels wide: .exr (32-bit float) or .png (16-bit, a file a descriptor); of "
        "several UDIM tiles one each, whose number stands for <UDIM> in the name, else before the suffix"
    )
    add("--output", "-o", action="append", default=[], metavar="OUT", type=Path, help=output)
    add("--map", action="append", default=[], metavar="IMAGE", type=Path, help=image)
    add("--png-range", choices=PNG_RANGES, default=PNG_RANGES[0],
        help="range of .png images: from the minimum to the maximum of the values (default), or the range of the "
        "colors, in which 0.5 is neutral")  # fmt: skip
    add("--pack", type=packed_names, default=(), metavar="R,G,B[,A]",
        help="write one .png with these descriptors as its channels instead, <stem>_masks.png, over the range of the "
        "colors")  # fmt: skip
    add("--dump-buffers", metavar="FOLDER", type=Path, help="write the baked buffers as .png and .npz")
    add("--corners", metavar="FILE", type=Path, help="write the corners that harris finds as a JSON list")
    add("--force", action="store_true", help="overwrite the input if it is an output as well")


def check_files(arguments: argparse.Namespace) -> None:
    """Refuses outputs that cannot be written, before any file is opened."""
    outputs = (".npz", *WRITERS, ".exr", ".blend")
    for paths, suffixes in ((arguments.output, outputs), (arguments.map, maps.SUFFIXES)):
        for path in paths:
            if path.suffix.lower() == ".png" and ".png" not in suffixes:
                shown = "ParaView and PyVista draw a mesh with its values from a .vtp"
                raise UsageError(f'"{path}" would be an image over the UV map, which --map writes; {shown}.')
            if path.suffix.lower() not in suffixes:
                raise UsageError(f'"{path}" has none of the suffixes {", ".join(suffixes)}.')
    check_tile_names(arguments)
    check_domain(arguments)
    if arguments.pack and not any(path.suffix.lower() == ".png" for path in arguments.map):
        raise UsageError("--pack says what a .png image holds; give --map IMAGE.png as well.")
    paths = files_of(arguments)
    check_outputs(paths)
    check_overwriting(paths, arguments.input, arguments.force)
    corners = arguments.corners
    if corners is not None and corners.resolve() in [path.resolve() for path in arguments.output + arguments.map]:
        raise UsageError(f'"{corners}" is an output already; choose another file for the corners.')
    folder = arguments.dump_buffers
    if folder is None and not paths:
        raise UsageError("There is nothing to write; give --output, --map, --dump-buffers or --json.")
    named = arguments.backend if arguments.backend != "auto" else None
    if folder is not None and named and not uses_texture_space(named):
        raise UsageError(f"The backend {arguments.backend} bakes no buffers to dump; choose another.")
    refuse(folder_fault(folder) if folder is not None else "")


def check_tile_names(arguments: argparse.Namespace) -> None:
    """Refuses the token for UDIM tiles in paths of outputs that have no tiles."""
    images, token = paths_of(arguments), tile_names.TOKEN
    for path in images:
        refuse(tile_names.fault(path))
    for path in (*files_of(arguments), arguments.dump_buffers):
        if path and path not in images and token in str(path):
            raise UsageError(f'"{path}" has no UDIM tiles that {token} could stand for; leave it out there.')


def check_domain(arguments: argparse.Namespace) -> None:
    """Refuses outputs that cannot hold values of faces, and formats for which a package is not installed."""
    for path in arguments.output:
        suffix = path.suffix.lower()
        if arguments.domain == "faces" and suffix not in OF_FACES:
            raise UsageError(f'"{path}" holds no values of faces; give one of {", ".join(OF_FACES)}.')
        if suffix in neuro_files.SUFFIXES and neuro_files.fault():
            raise ParadescError(abi.STATUS_UNSUPPORTED, f'"{path}" cannot be written: {neuro_files.fault()}.')
    others = {"--map": arguments.map, "--dump-buffers": arguments.dump_buffers, "--corners": arguments.corners}
    others |= {"--from": arguments.from_objects, "--from-file": arguments.from_file, "--pairs": arguments.pairs}
    for option, given in others.items():
        if arguments.domain == "faces" and given:
            raise UsageError(f"{option} has nothing to do with values of faces; leave it or --domain out.")


def check_values(arguments: argparse.Namespace, settings: job.Settings) -> None:
    """Refuses outputs that do not suit the values of these settings."""
    names = settings.value_names()
    if arguments.corners and "harris" not in settings.descriptors:
        raise UsageError("Corners are found by the descriptor harris; add it to --descriptors.")
    single = len(names) == 1 and bridge.components(settings.descriptors[0]) == 1
    for path in arguments.output if not single else ():
        if path.suffix.lower() == ".curv":
            sentence = f'"{path}" holds one number at each vertex; ask for one descriptor at one radius, or give a .gii'
            raise UsageError(f"{sentence}.")


def files_of(arguments: argparse.Namespace) -> list[Path]:
    """All files that will be written, without folders."""
    return arguments.output + arguments.map + [path for path in (arguments.json, arguments.corners) if path]


def write_files(arguments: argparse.Namespace, baked: list[Baked], source: Source) -> dict[str, object]:
    """Writes all files, a .blend by its source; returns their part of the report."""
    whole = baked[0] if len(baked) == 1 else results.joined(baked)
    written = [path for path in arguments.output if path.suffix.lower() != ".exr"]
    for path in written:
        suffix = path.suffix.lower()
        if suffix == ".blend":
            source.save(path)
        elif suffix == ".npz":
            write_whole(path, baked, results.write_npz)
        else:
            write_whole(path, whole, WRITERS[suffix])
    are_drawn_now = any(one.results.tiles for one in baked)
    with Progress(arguments.progress) if are_drawn_now else nullcontext() as progress:
        described = write_images(baked, arguments, progress)
    written += [Path(str(row["path"])) for row in described]
    for one in baked if arguments.dump_buffers else []:
        folder = arguments.dump_buffers
        if len(baked) > 1:  # each has a folder in it
            folder.mkdir(exist_ok=True)
            folder /= file_name(one, baked)
        written += maps.write_buffers(folder, one)
    if arguments.corners:
        several = len(baked) > 1
        rows = [(one.object_name, row) for one in baked for row in results.listed_corners(one)]
        listed = [{"object": name, **row} if several else row for name, row in rows]
        write_whole(arguments.corners, listed, results.write_json)
        written.append(arguments.corners)
    return {"outputs": [str(path) for path in written], "maps": described}


def packed_names(text: str) -> tuple[str, ...]:
    """Parses three or four names of descriptors with one component between commas."""
    names = tuple(name.strip() for name in text.split(","))
    known = [row.name for row in bridge.descriptors() if row.components == 1]
    for name in names:
        if name not in known:
            raise argparse.ArgumentTypeError(f'"{name}" is not a descriptor for a channel; choose {", ".join(known)}')
    if len(names) not in (3, 4) or len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f'"{text}" must be three or four different descriptors with commas between')
    return names
