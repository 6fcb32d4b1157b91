"""paradesc bake: computes descriptors of one object or of several and writes them to files."""

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

from .. import bridge
from ..core import corners, job, source_kinds, texel_tiles
from ..core.face_centers import DOMAINS
from ..files import preset_rules, results
from ..files.reading import world_matrix
from . import common, images, options, pairs
from .look_options import add_look_options, look_of
from .outputs import add_output_files, check_files, check_values, files_of, write_files
from .sources import Source, Target, scene_source, source_of

HELP = "compute descriptors and write them to files"


def add_options(parser: common.Parser) -> None:
    """The command's options."""
    options.add_objects(parser, source_kinds.ORIGINAL, source_kinds.AUTOMATIC)
    options.add_computation_options(parser)
    options.add_map_options(parser)
    pairs.add_pair_options(parser)
    add_output_files(parser)
    add_look_options(parser)
    add = parser.add_argument
    places = "measure at vertices (default), or at the middles of faces (.vtp, .vtk, .ply, .npz)"
    add("--domain", choices=DOMAINS, help=places)
    threshold = "corners have at least this share of the largest response (default: 0.05)"
    add("--corner-threshold", type=float, metavar="T", help=threshold)
    add("--fail-under-coverage", type=float, metavar="SHARE",
        help="end with code 5 if an object's mean coverage is smaller")  # fmt: skip
    add("--fail-over-undefined", type=float, metavar="SHARE",
        help="end with code 5 if a larger share of an object's vertices is undefined")  # fmt: skip
    add("--fail-on-warnings", action="store_true", help="end with code 5 if anything limits the results")


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Reads the meshes, computes, and writes every output; returns the report."""
    check(arguments)
    started = time.monotonic()
    onto = pairs.is_asked(arguments)
    source = source_of(arguments)
    notes = source.open()
    opened = pairs.picked(source, arguments)
    settings = options.opened_settings(arguments)
    notes += opened.notes + options.notes_of_preset(arguments, has_colors=True)
    check_values(arguments, settings)
    common.check_overwriting(files_of(arguments), common.open_file(), arguments.force)
    read = time.monotonic()
    # Detailed objects of another file are removed at the end: no output has them.
    with pairs.with_highs(source, opened.objects, arguments) if onto else nullcontext() as highs:
        baked = bake_objects(source, opened.objects, settings, arguments, highs)
    computed = time.monotonic()
    if common.saves_scene(arguments):
        source.write(opened.objects, baked)
    files = write_files(arguments, baked, source)
    for one in baked:
        print_summary(one)
    common.print_notes(notes)
    for path in files["outputs"]:
        print(f"wrote {path}")
    warnings = [
        f"{one.object_name}: {sentence}" if len(baked) > 1 else sentence
        for one in baked
        for sentence in one.warnings
    ]
    return {
        "settings": settings.as_dict(),
        "backend": baked[0].results.backend,
        "device": baked[0].results.device,
        "fallback": "",  # for readers of earlier versions
        "objects": [results.report(one) for one in baked],
        "notes": notes,
        "warnings": warnings,
        **files,
        "seconds": {"open": read - started, "compute": computed - read, "write": time.monotonic() - computed},
        "failed_checks": failed_checks(arguments, baked, warnings),
    }


def check(arguments: argparse.Namespace) -> None:
    """Refuses options that contradict each other, before any file is opened."""
    if arguments.pack and arguments.descriptors is None:
        arguments.descriptors = arguments.pack
    settings = options.check(arguments)
    lacking = [name for name in arguments.pack if name not in settings.descriptors]
    if lacking:
        raise common.UsageError(f"--pack needs {', '.join(lacking)}; add that to --descriptors.")
    check_files(arguments)
    preset = arguments.preset and Path(arguments.preset)  # which may also be a name
    for given in (arguments.from_file, arguments.displacement, arguments.normal_map, preset):
        common.check_overwriting(files_of(arguments), given, arguments.force)
    pairs.check_pair_options(arguments)
    if arguments.corner_threshold is not None:
        corners.check_threshold(arguments.corner_threshold)
    if arguments.material_maps and (arguments.displacement or arguments.normal_map):
        raise common.UsageError("Maps come from the material or from files; leave --material-maps or the images out.")


def bake_objects(
    source: Source,
    targets: list[Target],
    settings: job.Settings,
    arguments: argparse.Namespace,
    onto: dict[Target, list[Target]] | None,
) -> list[results.Baked]:
    """Computes each object, or the detailed ones in its place. Objects with one mesh share its results, if possible."""
    scene_look = scene_source(arguments).look() if arguments.scene_settings else None
    look = look_of(arguments, preset_rules.look_of(arguments.preset_content, scene_look))
    if common.saves_scene(arguments):
        source.check_writable(targets)
    its_own = arguments.material_maps or settings.space == "world" or arguments.source != "original" or onto
    baked: list[results.Baked] = []
    of_mesh: dict[str, results.Baked] = {}
    with common.Progress(arguments.progress) as progress:
        for index, target in enumerate(targets):
            known = None if its_own else of_mesh.get(source.mesh_name(target))
            if known is None:
                part = job.part_of(progress, index, len(targets))
                with named(target, len(targets)):
                    # The own normals of a low-poly object are not measured.
                    fitted = replace(settings, options=replace(settings.options, normals="fitted"))
                    read = source.read(target, fitted if onto else settings)
                    arrays, notes = read.arrays, read.sentences
                    tiles = images.tiles_of(target.name, arrays, arguments)
                    if onto:
                        highs = onto[target]
                        computed, notes = pairs.run_onto(
                            source, target, read, highs, settings, arguments, tiles, part
                        )
                    else:
                        buffers = arguments.dump_buffers is not None
                        computed = texel_tiles.run_where_asked(
                            read.measured, settings, tiles, part, buffers
                        )
                computed.look = look
            else:
                read, arrays, computed = known.reading, known.arrays, known.results
                notes = [f'It shares the mesh of "{known.object_name}" and has its results.']
            notes = [*notes, *computed.unused_notes()]
            matrix, limits = world_matrix(target), computed.facet_notes()
            baked.append(results.Baked(target.name, computed, arrays, matrix, notes, read, limits))
            of_mesh.setdefault(source.mesh_name(target), baked[-1])
    return baked


@contextmanager
def named(target: Target, count: int) -> Iterator[None]:
    """Adds the object's name to an error if there are several objects."""
    try:
        yield
    except bridge.InputError as error:
        if count > 1:
            raise bridge.InputError(f'Object "{target.name}": {error.sentence}') from error
        raise


def failed_checks(arguments: argparse.Namespace, baked: list[results.Baked], warnings: list[str]) -> list[str]:
    """One sentence for each failed check."""
    failed = []
    least, most = arguments.fail_under_coverage, arguments.fail_over_undefined
    for one in baked:
        for suffix, field in one.results.field_reports.items():
            at = f" at {suffix.removeprefix('_')}" if suffix else ""
            coverage = field["coverage_mean"]
            if least is not None and not coverage >= least:
                failed.append(
                    f'The coverage of "{one.object_name}"{at} is {coverage:.4g}, below the {least:g} asked for.'
                )
            share, places = field["undefined_vertices"] / max(len(one.results.coverage), 1), one.results.settings.domain
            if most is not None and not share <= most:
                of_all = f"{share:.4g} of the {places} are undefined"
                failed.append(f'In "{one.object_name}"{at}, {of_all}; {most:g} are allowed.')
    if arguments.fail_on_warnings and warnings:
        failed.append(f"There are warnings ({len(warnings)}): {warnings[0]}")
    return failed


def print_summary(baked: results.Baked) -> None:
    """Prints a summary of the results in a few lines."""
    found = baked.results
    mesh, field = found.mesh_report, found.field_report
    measured = "" if found.transfer is None else f', measured on "{found.transfer.sources[0]}"'
    print(
        f'object "{baked.object_name}"{measured}: {mesh["vertex_count"]:,} vertices, '
        f"{mesh['triangle_count']:,} triangles, {mesh['charts']:,} charts, {mesh['seam_edges']:,} seam edges"
    )
    texels = f" ({field['radius_in_texels']:.1f} texels)" if field["radius_in_texels"] > 0 else ""
    print(
        f"radius {field['radius']:.6g}{texels}, "
        f"coverage {100 * field['coverage_mean']:.3f} %, "
        f"undefined {found.settings.domain} {field['undefined_vertices']:,}"
    )
    buffers = f", buffers {field['buffer_megabytes']:.1f} MB" if field["buffer_megabytes"] > 0 else ""
    places = f"{field['places']:,} places evaluated, memory about {field['memory_megabytes']:,.0f} MB"
    print(f"{field['seconds_total']:.2f} s, {places}{buffers}, {found.backend}: {found.device}")
    for name, row in results.report(baked)["descriptors"].items():
        if row["minimum"] is None:
            print(f"  {name}: undefined everywhere")
        else:
            print(f"  {name}: {row['minimum']:.6g} to {row['maximum']:.6g} {row['unit']}".rstrip())
    if found.corners is not None:
        print(f"  corners: {len(found.corners.vertices):,}")
    common.print_notes([*baked.notes, *baked.warnings])
