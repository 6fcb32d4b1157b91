"""The command line: bake, compare, list. Runs as `python -m paradesc …` and as `blender -b FILE -P cli.py -- …`."""

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

if __name__ == "__main__":  # run by Blender as a script: find the package that this file lies in
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from paradesc import bridge, compare, corners, job, maps, results
from paradesc.bridge import ParadescError, abi
from paradesc.look_options import add_look_options, look_of
from paradesc.streams import quiet

if TYPE_CHECKING:
    import bpy

WRITERS: dict[str, Callable[[Path, results.Baked], None]] = {
    ".npz": results.write_npz,
    ".ply": results.write_ply,
    ".png": results.write_picture,
    ".exr": maps.write_exr,
}
OUTPUT_SUFFIXES = (*WRITERS, ".blend")
EXIT_FAILED, EXIT_USAGE, EXIT_INTERRUPTED = 1, 2, 130
COLUMNS = (
    ("mean_percent_ae", "mean %"),
    ("median_percent_ae", "median %"),
    ("p99_percent_ae", "p99 %"),
    ("max_percent_ae", "max %"),
    ("seam_mean_percent_ae", "near seams %"),
    ("seam_error_mean", "seam error %"),
    ("seam_error_p99", "seam p99 %"),
    ("coverage_mean", "coverage"),
    ("undefined", "undefined"),
)


class UsageError(Exception):
    """The arguments make no sense; the text is one sentence."""


class Parser(argparse.ArgumentParser):
    """argparse whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        """Raises instead of printing the usage and exiting."""
        sentence = message[:1].upper() + message[1:].rstrip(".")
        raise UsageError(f"{sentence}; see {self.prog} --help.")


def make_parser() -> Parser:
    """All commands and their options."""
    parser = Parser(
        prog="paradesc", description="Geometric descriptors of UV-mapped meshes, computed in their texture space."
    )
    commands = parser.add_subparsers(
        dest="command", required=True, metavar="bake | compare | list", parser_class=Parser
    )
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
    add_look_options(bake)
    bake.add_argument("--json", metavar="REPORT", type=Path, help="write settings, reports and ranges as JSON")
    bake.add_argument("--corners", metavar="FILE", type=Path, help="write the corners that harris finds as a JSON list")
    bake.add_argument(
        "--corner-threshold", type=float, default=corners.THRESHOLD, metavar="T",
        help="corners have at least this share of the largest response (default: 0.05)",
    )  # fmt: skip
    bake.set_defaults(run=run_bake)
    comparison = commands.add_parser("compare", help="compare a device's results with those of the reference")
    add_mesh_options(comparison)
    comparison.add_argument("--json", metavar="FILE", type=Path, help="write the table as a JSON list of rows")
    comparison.set_defaults(run=run_compare)
    listing = commands.add_parser("list", help="show the descriptors and the devices there are")
    listing.set_defaults(run=run_list)
    return parser


def add_mesh_options(parser: argparse.ArgumentParser) -> None:
    """What bake and compare have in common."""
    defaults = bridge.Options()
    add = parser.add_argument
    add("input", nargs="?", metavar="INPUT", type=Path, help=".blend, .obj, .ply or .glb; in Blender: the open file")
    add("--descriptors", default="mean_curvature", metavar="A,B,C", help="see paradesc list (default: mean_curvature)")
    add("--object", metavar="NAME", help="the mesh object (default: a .blend's active one, else the largest)")
    add("--radius", type=radii, default=(defaults.radius,), metavar="R[,R...]",
        help="support radius (default: 0.02); of several, names end in _r and the radius")  # fmt: skip
    add("--radius-unit", choices=bridge.RADIUS_UNITS, default=defaults.radius_unit,
        help="diagonal: a fraction of the bounding box's (default); absolute: the mesh's own units")  # fmt: skip
    add("--samples", type=int, default=defaults.samples, metavar="N", help="samples around a vertex (default: 256)")
    add("--buffer", type=int, default=defaults.buffer_size, metavar="N", help="side of the buffers (default: 1024)")
    add("--normals", choices=bridge.NORMALS, default=defaults.normals, help="vertex normals (default: fitted)")
    add("--relocation", choices=bridge.RELOCATIONS, default=defaults.relocation,
        help="over seams: by connected cells (default), each sample by affine maps, or as the paper does")  # fmt: skip
    add(
        "--max-jumps",
        type=int,
        default=defaults.max_jumps,
        metavar="N",
        help="affine, paper: seams to cross (default: 8)",
    )
    add("--pattern", choices=bridge.PATTERNS, default=defaults.pattern, help="affine, paper: places of the samples")
    add("--ellipse", choices=bridge.ELLIPSES, default=defaults.ellipse,
        help="affine, paper: extent by the distortion at the center, or the largest on the way")  # fmt: skip
    add("--estimator", choices=bridge.ESTIMATORS, default=defaults.estimator,
        help="curvatures by the least-squares shape operator (default), or by the paper's integrals")  # fmt: skip
    add("--variance-reduction", choices=bridge.VARIANCE_REDUCTIONS, default=defaults.variance_reduction,
        help="integrals with the shape operator as control variate (default), or plain sums")  # fmt: skip
    add("--geodesic", choices=bridge.GEODESICS, default=defaults.geodesic,
        help="along the surface by a local formula (default), or by chords (affine, paper)")  # fmt: skip
    add("--distance", choices=bridge.DISTANCES, default=defaults.distance, help="what the radius bounds")
    add("--adaptive", type=float, nargs="?", const=bridge.ADAPTIVE_THRESHOLD, default=defaults.adaptive,
        metavar="THRESHOLD", help="half of the samples where normals fit to this angle, in radians")  # fmt: skip
    add("--evaluate", choices=bridge.EVALUATIONS, default=defaults.evaluate, help="at vertices, or texels looked up")
    add("--texels", type=int, default=defaults.texels, metavar="N", help="side of the map of texels (default: 512)")
    add("--precision", choices=bridge.PRECISIONS, default=defaults.precision, help="of the buffers (default: full)")
    add("--map-descriptor", default=defaults.map_descriptor, metavar="A",
        help="what the operators (harris, laplacian, ...) work on (default: %(default)s)")  # fmt: skip
    add("--map-sigma", type=float, default=defaults.map_sigma, metavar="S",
        help="of harris' and difference_of_gaussians' windows, times the radius (default: 1)")  # fmt: skip
    add("--harris-k", type=float, default=defaults.harris_k, metavar="K", help="k of harris (default: 0.04)")
    add("--backend", choices=bridge.BACKENDS, default="auto", help="what computes (default: auto)")
    add("--device", type=int, default=-1, metavar="N", help="which device of the backend (default: the first)")
    add("--seed", type=int, default=defaults.seed, metavar="N", help="of the sampling pattern (default: 0)")
    add("--verbose", action="store_true", help="show what Blender itself prints")


def radii(text: str) -> tuple[float, ...]:
    """Numbers between commas."""
    return tuple(float(word) for word in text.split(","))


def add_map_options(parser: argparse.ArgumentParser) -> None:
    """Images that change what is measured; the reference has no texels for them, so compare does without."""
    add = parser.add_argument
    add("--displacement", metavar="IMAGE", type=Path, help="displace the surface by (value - midlevel) scale")
    add("--midlevel", type=float, default=0.5, metavar="X", help="of the displacement (default: 0.5)")
    add("--displacement-scale", type=float, default=1.0, metavar="X", help="in the mesh's units (default: 1)")
    add("--normal-map", metavar="IMAGE", type=Path, help="take the normals from a tangent space normal map")
    add("--material-maps", action="store_true", help="take displacement and normal map from the object's material")


def add_maps(target: "bpy.types.Object", arrays: bridge.MeshArrays, arguments: argparse.Namespace) -> list[str]:
    """Puts the maps asked for into the arrays; gives a sentence about each."""
    from paradesc import surface_maps

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


def settings_of(arguments: argparse.Namespace) -> job.Settings:
    """The computation's settings; unknown descriptors are refused before any file is opened."""
    names = tuple(name.strip() for name in arguments.descriptors.split(",") if name.strip())
    job.check_descriptors(names)
    options = bridge.Options(
        radius=arguments.radius[0],
        samples=arguments.samples,
        buffer_size=arguments.buffer,
        max_jumps=arguments.max_jumps,
        seed=arguments.seed,
        texels=arguments.texels,
        adaptive=arguments.adaptive,
        map_descriptor=arguments.map_descriptor,
        map_sigma=arguments.map_sigma,
        harris_k=arguments.harris_k,
        **{name: getattr(arguments, name) for name in bridge.CHOICES},
    )
    return job.Settings(names, options, arguments.backend, arguments.device, arguments.radius[1:])


def check_outputs(paths: list[Path]) -> None:
    """Refuses what cannot be written before anything is computed."""
    for path in paths:
        if not path.absolute().parent.is_dir():
            raise UsageError(f'There is no folder "{path.absolute().parent}" to write "{path.name}" into.')
        if path.is_dir() or not os.access(path.absolute().parent, os.W_OK):
            raise UsageError(f'"{path}" cannot be written.')


def open_object(arguments: argparse.Namespace) -> "bpy.types.Object":
    """Opens the input, if there is one, and picks the object."""
    try:
        with quiet(arguments.verbose):
            import bpy

            from paradesc import scene_io
    except ImportError as error:
        raise ParadescError(abi.STATUS_UNSUPPORTED, "Blender's Python module bpy is not installed here.") from error
    imported = False
    if arguments.input is not None:
        imported = arguments.input.suffix.lower() != ".blend"
        scene_io.open_scene(arguments.input, arguments.verbose)
    elif not bpy.app.binary_path:
        raise UsageError("INPUT is missing; give a .blend, .obj, .ply or .glb file.")
    return scene_io.choose_object(arguments.object, prefer_active=not imported)


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


def run_bake(arguments: argparse.Namespace) -> None:
    """Reads the mesh, computes, and writes every output and the report."""
    settings, images = check_bake(arguments)
    target = open_object(arguments)
    from paradesc import mesh_io

    saves_scene = any(path.suffix.lower() == ".blend" for path in arguments.output)
    if saves_scene:
        mesh_io.check_writable(target)
    arrays = mesh_io.read_object(target, settings.options.normals == "mesh", settings.backend != "reference")
    mapped = add_maps(target, arrays, arguments)
    with Progress() as progress:
        computed = job.run(arrays, settings, progress, arguments.dump_buffers is not None)
    computed.look = look_of(arguments)
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
    from paradesc import scene_io

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


def write_whole(path: Path, content: object, writer: Callable) -> None:
    """Writes beside the path first: a failure leaves no half file, and an old one as it was."""
    temporary = path.with_name(f".{path.name}.part")
    try:
        writer(temporary, content)
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        sentence = f'"{path}" cannot be written: {error.strerror or error}.'
        raise ParadescError(abi.STATUS_UNKNOWN, sentence) from error


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


def print_notes(sentences: list[str]) -> None:
    """What limits the results, a line each."""
    for sentence in filter(None, sentences):
        print(f"note: {sentence}")


def run_compare(arguments: argparse.Namespace) -> None:
    """Computes on a device and on the reference, and prints the table of errors."""
    if arguments.backend == "reference":
        raise UsageError("The reference is what compare compares with; choose another backend.")
    check_outputs([arguments.json] if arguments.json else [])
    settings = settings_of(arguments)
    target = open_object(arguments)
    from paradesc import mesh_io

    arrays = mesh_io.read_object(target, settings.options.normals == "mesh")
    with Progress() as progress:
        rows, device, reference = compare.compare(arrays, settings, progress)
    if arguments.json:
        write_whole(arguments.json, rows, results.write_json)
    print(f'object "{target.name}", radius {device.radius:.6g}, {settings.options.samples} samples')
    print(f"{device.backend}: {device.device}, {device.field_report['seconds_total']:.2f} s")
    print(f"reference: {reference.device}, {reference.field_report['seconds_total']:.2f} s")
    print_table(rows)
    print_notes([device.fallback, *device.warnings])


def print_table(rows: list[dict[str, object]]) -> None:
    """One line a descriptor."""
    print(f"{'descriptor':26}" + "".join(f"{title:>14}" for _, title in COLUMNS))
    for row in rows:
        cells = "".join(
            f"{row[name]:>14}" if isinstance(row[name], int) else f"{row[name]:>14.4f}" for name, _ in COLUMNS
        )
        print(f"{row['descriptor']:26}{cells}")


def run_list(_arguments: argparse.Namespace) -> None:
    """Prints the registry and the devices."""
    print("Descriptors")
    for row in bridge.descriptors():
        unit = f" [{row.unit}]" if row.unit else ""
        print(f"  {row.name:26}{row.description}{unit}")
    print("Devices")
    for row in bridge.devices():
        print(f"  {row['backend']:26}{row['device'] or 'none: ' + row['missing']}")


class Progress:
    """One line that is written over and over, on a terminal only. Ctrl-C cancels the computation at its next tile."""

    def __init__(self) -> None:
        self.shown = sys.stderr.isatty()
        self.time = 0.0
        self.interrupted = False

    def __call__(self, stage: str, fraction: float) -> bool:
        """Shows the stage and the percentage, ten times a second at most; False after Ctrl-C."""
        now = time.monotonic()
        if self.shown and now - self.time > 0.1:
            self.time = now
            sys.stderr.write(f"\r\x1b[K{fraction:6.1%} {stage}")
            sys.stderr.flush()
        return not self.interrupted

    def __enter__(self) -> "Progress":
        self.former = signal.getsignal(signal.SIGINT)
        if self.former is not None:  # Blender itself keeps the signal in C, and ends by it
            signal.signal(signal.SIGINT, self.interrupt)  # an exception could not pass through C
        return self

    def __exit__(self, *_error: object) -> None:
        if self.former is not None:
            signal.signal(signal.SIGINT, self.former)
        if self.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
        if self.interrupted:
            raise KeyboardInterrupt

    def interrupt(self, *_signal: object) -> None:
        """Remembers Ctrl-C until the native library asks."""
        self.interrupted = True


def main(words: list[str]) -> int:
    """Runs one command; gives the exit code. Whatever fails is one sentence on the standard error stream."""
    try:
        arguments = make_parser().parse_args(words)
        arguments.run(arguments)
    except UsageError as error:
        return fail(str(error), EXIT_USAGE)
    except ParadescError as error:
        return fail(error.sentence, EXIT_FAILED)
    except KeyboardInterrupt:
        return fail("Interrupted.", EXIT_INTERRUPTED)
    except Exception as error:  # a defect of ours; --verbose shows where
        if "--verbose" in words:
            raise
        return fail(f"Unexpected {type(error).__name__}: {error} (--verbose says where).", EXIT_FAILED)
    return 0


def fail(sentence: str, code: int) -> int:
    """Says why, on one line."""
    print("paradesc: " + " ".join(sentence.split()), file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []))
