"""paradesc bake: computes descriptors of one object and writes them to files."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from .. import bridge, corners, job, maps, results
from ..results import write_whole
from ..streams import quiet
from .common import Parser, Progress, UsageError, check_outputs, open_object, print_notes
from .options import add_map_options, add_mesh_options, settings_of

if TYPE_CHECKING:
    import bpy

WRITERS: dict[str, Callable[[Path, results.Baked], None]] = {
    ".npz": results.write_npz,
    ".ply": results.write_ply,
    ".png": results.write_picture,
    ".exr": maps.write_exr,
}
OUTPUT_SUFFIXES = (*WRITERS, ".blend")


def add_command(commands: "argparse._SubParsersAction[Parser]") -> None:
    """The command and its options."""
    bake = commands.add_parser("bake", help="compute descriptors and write them to files")
    add_mesh_options(bake)
    bake.add_argument(
        "--output", "-o", action="append", default=[], metavar="OUT", type=Path,
        help="where to write: .blend, .npz, .ply, .png (picture), .exr (image over the UV map); give it again for more",
    )  # fmt: skip
    bake.add_argument(
        "--map", action="append", default=[], metavar="IMAGE", type=Path,
        help="write images over the UV map, --texels wide: .exr (32-bit float) or .png (16-bit, a file a descriptor)",
    )  # fmt: skip
    bake.add_argument("--dump-buffers", metavar="FOLDER", type=Path, help="write the baked buffers as .png and .npz")
    add_map_options(bake)
    bake.add_argument("--json", metavar="REPORT", type=Path, help="write settings, reports and ranges as JSON")
    bake.add_argument("--corners", metavar="FILE", type=Path, help="write the corners that harris finds as a JSON list")
    bake.add_argument(
        "--corner-threshold", type=float, default=corners.THRESHOLD, metavar="T",
        help="corners have at least this share of the largest response (default: 0.05)",
    )  # fmt: skip
    bake.set_defaults(run=run)


def add_maps(target: "bpy.types.Object", arrays: bridge.MeshArrays, arguments: argparse.Namespace) -> list[str]:
    """Puts the maps asked for into the arrays; gives a sentence about each."""
    from .. import surface_maps

    files = (arguments.displacement, arguments.normal_map)
    if arguments.material_maps and any(files):
        raise UsageError("Maps come from the material or from files; leave --material-maps or the images out.")
    sources = surface_maps.Sources(
        arguments.displacement,
        arguments.midlevel,
        arguments.displacement_scale,
        arguments.normal_map,
        arguments.material_maps,
    )
    with quiet(arguments.verbose):
        return surface_maps.add_maps(target, arrays, sources)


def check_bake(arguments: argparse.Namespace) -> tuple[job.Settings, list[tuple[Path, str]]]:
    """The settings, and the images to write; whatever makes no sense is refused before anything is computed."""
    for path in arguments.output:
        if path.suffix.lower() not in OUTPUT_SUFFIXES:
            raise UsageError(f'"{path}" has none of the suffixes {", ".join(OUTPUT_SUFFIXES)}.')
    settings = settings_of(arguments)
    images = image_paths(arguments.map, settings)
    check_outputs(arguments.output + [path for path, _ in images] + report_paths(arguments))
    check_folder(arguments)
    settings.corner_threshold = arguments.corner_threshold
    if not 0 < settings.corner_threshold <= 1:
        raise UsageError(f"The corner threshold is {settings.corner_threshold}; it must be above 0 and at most 1.")
    if arguments.corners and "harris" not in settings.descriptors:
        raise UsageError("Corners are found by the descriptor harris; add it to --descriptors.")
    return settings, images


def report_paths(arguments: argparse.Namespace) -> list[Path]:
    """Files that are written last."""
    return [path for path in (arguments.json, arguments.corners) if path]


def run(arguments: argparse.Namespace) -> None:
    """Reads the mesh, computes, and writes every output and the report."""
    settings, images = check_bake(arguments)
    target = open_object(arguments)
    from .. import mesh_io

    saves_scene = any(path.suffix.lower() == ".blend" for path in arguments.output)
    if saves_scene:
        mesh_io.check_writable(target)
    arrays = mesh_io.read_object(target, settings.options.normals == "mesh", settings.backend != "reference")
    mapped = add_maps(target, arrays, arguments)
    with Progress() as progress:
        computed = job.run(arrays, settings, progress, arguments.dump_buffers is not None)
    baked = results.Baked(target.name, computed, arrays, mesh_io.world_matrix(target))
    notes = mapped + (mesh_io.write_results(target, computed) if saves_scene else [])
    written, notes = write_outputs(arguments, baked, images, notes)
    print_summary(baked, notes)
    for path in written:
        print(f"wrote {path}")


def write_outputs(
    arguments: argparse.Namespace, baked: results.Baked, images: list[tuple[Path, str]], notes: list[str]
) -> tuple[list[Path], list[str]]:
    """Writes all files; gives them, and the notes with those about images."""
    from .. import scene_io

    for path in arguments.output:
        if path.suffix.lower() == ".blend":
            scene_io.save_blend(path, arguments.verbose)
        else:
            write_whole(path, baked, WRITERS[path.suffix.lower()])
    described = [write_image(path, baked, name) for path, name in images]
    written = arguments.output + [path for path, _ in images]
    if images or any(path.suffix.lower() == ".exr" for path in written):
        notes = notes + maps.notes(baked)
    if arguments.dump_buffers:
        written += maps.write_buffers(arguments.dump_buffers, baked)
    if arguments.json:
        outputs = {"outputs": [str(path) for path in written], "maps": described}
        write_whole(arguments.json, {**results.report(baked), "notes": notes, **outputs}, results.write_json)
    if arguments.corners:
        write_whole(arguments.corners, results.listed_corners(baked), results.write_json)
    return written + report_paths(arguments), notes


def image_paths(paths: list[Path], settings: job.Settings) -> list[tuple[Path, str]]:
    """The files that --map writes, each with its descriptor; "" for all of them in one."""
    found: list[tuple[Path, str]] = []
    for path in paths:
        if path.suffix.lower() not in maps.SUFFIXES:
            raise UsageError(f'"{path}" has none of the suffixes {", ".join(maps.SUFFIXES)}.')
        if path.suffix.lower() == ".exr":
            found.append((path, ""))
        else:
            found += [(one, name) for name, one in maps.png_paths(path, settings.value_names()).items()]
    return found


def check_folder(arguments: argparse.Namespace) -> None:
    """Refuses a bake that writes nothing, and a folder for buffers that cannot be."""
    folder = arguments.dump_buffers
    if folder is None and not arguments.output + arguments.map:
        raise UsageError("There is nothing to write; give --output, --map or --dump-buffers.")
    if folder is not None and arguments.backend == "reference":
        raise UsageError("The reference bakes no buffers to dump; choose another backend.")
    if folder is not None and not (folder.is_dir() or (folder.absolute().parent.is_dir() and not folder.exists())):
        raise UsageError(f'"{folder}" is no folder and cannot become one.')


def write_image(path: Path, baked: results.Baked, name: str) -> dict[str, object]:
    """Writes one image of --map; gives what the report says of it."""
    described: dict[str, object] = {"path": str(path)}
    if name:
        write_whole(path, baked, lambda place, content: described.update(maps.write_png(place, content, name)))
    else:
        write_whole(path, baked, maps.write_exr)
    return described


def print_summary(baked: results.Baked, notes: list[str]) -> None:
    """What was found, in a few lines."""
    found = baked.results
    mesh, field = found.mesh_report, found.field_report
    print(
        f'object "{baked.object_name}": {mesh["vertex_count"]:,} vertices, {mesh["triangle_count"]:,} triangles, '
        f"{mesh['charts']:,} charts, {mesh['seam_edges']:,} seam edges"
    )
    texels = f" ({field['radius_in_texels']:.1f} texels)" if field["radius_in_texels"] > 0 else ""
    print(
        f"radius {field['radius']:.6g}{texels}, "
        f"coverage {100 * field['coverage_mean']:.3f} %, undefined vertices {field['undefined_vertices']:,}"
    )
    buffers = f", buffers {field['buffer_megabytes']:.1f} MB" if field["buffer_megabytes"] > 0 else ""
    places = f"{field['places']:,} places evaluated"
    print(f"{field['seconds_total']:.2f} s, {places}{buffers}, {found.backend}: {found.device}")
    for name, row in results.report(baked)["descriptors"].items():
        if row["minimum"] is None:
            print(f"  {name}: undefined everywhere")
        else:
            print(f"  {name}: {row['minimum']:.6g} to {row['maximum']:.6g} {row['unit']}".rstrip())
    if found.corners is not None:
        print(f"  corners: {len(found.corners.vertices):,}")
    print_notes([*notes, found.fallback, *found.warnings])
