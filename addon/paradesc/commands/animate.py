"""paradesc animate: bakes frames of an animation into a folder of files, resumably and on any number of machines."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from ..bridge import ProgressFunction
from ..core import job, legend
from ..files import cache
from ..files.frame_baking import Baker, Done, FrameRequest
from ..files.results import make_folder
from . import animate_files, common, options
from .look_options import fixed_range

STAGES = ("depsgraph", "read", "upload", "prepare", "bake", "evaluate", "write")


HELP = "compute descriptors at frames of an animation into a frame cache"


def add_options(parser: common.Parser) -> None:
    """The command's options."""
    options.add_objects(parser, "deformed")
    options.add_computation_options(parser)
    options.add_map_options(parser)
    add = parser.add_argument
    add("--frames", metavar="A:B[:STEP]", help="frames to compute (default: those of the scene, or all files)")
    add("--cache", metavar="FOLDER", type=Path,
        help="folder of the frames, one below it for each object (default: paradesc_cache by the input)")  # fmt: skip
    add("--relative-to-rest", action="store_true",
        help="also store the change from the rest pose as NAME_change; of files, from the first")  # fmt: skip
    add("--range", action="append", type=fixed_range, default=[], metavar="[NAME=]A:B",
        help="values that the colors span in all frames (default: the range over all frames)")  # fmt: skip
    add("--force", action="store_true", help="compute existing frames again")


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Bakes the missing frames; returns the report on all frames that exist then."""
    options.check(arguments)
    chosen = animate_files.parse_frames(arguments.frames)
    source = animate_files.source_of_frames(arguments)
    notes = source.open()
    opened = source.picked()
    settings = options.opened_settings(arguments)
    if isinstance(source, animate_files.SequenceSource):
        arguments.source = animate_files.SOURCE
    notes += opened.notes + options.notes_of_preset(arguments)
    wanted, root = chosen or source.frame_range(), source.cache_folder()
    reports = []
    with common.Progress(arguments.progress) as progress:
        for index, target in enumerate(opened.objects):
            folder = cache.object_folder(root, target.name)
            make_folder(folder)
            if not os.access(folder, os.W_OK):
                raise cache.refused(f'The folder "{folder}" cannot be written.')
            request = FrameRequest(settings, folder, arguments.source, arguments.relative_to_rest, arguments.force)
            with source.frame_baker(target, request) as baker:
                part = job.part_of(progress, index, len(opened.objects))
                reports.append(report_of(baker, wanted, bake_frames(baker, wanted, part)))
            if arguments.range:
                cache.write_fixed(folder, dict(arguments.range))
    shared = cache.locked_ranges(dict.fromkeys(sorted(path for path in root.iterdir() if path.is_dir()), ""))
    for report in reports:
        report["ranges"] = cache.locked_ranges({Path(report["folder"]): report["key"]})
        print_summary(report, settings)
        report["ranges"] = {name: [shown.minimum, shown.maximum] for name, shown in report["ranges"].items()}
    common.print_notes(notes)
    return {
        "settings": settings.as_dict(),
        "source": arguments.source,
        "relative_to_rest": arguments.relative_to_rest,
        "frames": list(wanted),
        "objects": reports,
        "ranges": {name: [shown.minimum, shown.maximum] for name, shown in shared.items()},
        "notes": notes,
        "warnings": list(dict.fromkeys(sentence for report in reports for sentence in report["warnings"])),
    }


def bake_frames(baker: Baker, wanted: Sequence[int], progress: ProgressFunction) -> list[Done]:
    """Bakes one frame after the other; returns those that had to be computed."""
    made = []
    for index, frame in enumerate(wanted):
        part = job.part_of(progress, index, len(wanted), f"frame {frame}: ")
        if not part("read", 0.0):
            raise KeyboardInterrupt
        task = baker.prepare(frame)
        if task is not None:
            made.append(baker.run(task, part))
    return made


def report_of(baker: Baker, wanted: Sequence[int], made: list[Done]) -> dict[str, object]:
    """The report on an object's frames: everything except values."""
    frames = [done.frame for done in made]
    seconds = {stage: sum(done.seconds[stage] for done in made) / len(made) for stage in STAGES} if made else {}
    return {
        "object": baker.object_name,
        "folder": str(baker.request.folder),
        "key": baker.key,
        "made": frames,
        "kept": sorted(set(wanted) - set(frames)),
        "device": made[0].device if made else "",
        "seconds_per_frame": seconds,
        "notes": baker.notes,
        "warnings": list(dict.fromkeys(sentence for done in made for sentence in done.warnings)),
    }


def print_summary(report: dict, settings: job.Settings) -> None:
    """Prints a summary of the baked frames in a few lines."""
    print(f'object "{report["object"]}": {len(report["made"]):,} frames made, {len(report["kept"]):,} kept')
    if report["made"]:
        seconds = report["seconds_per_frame"]
        stages = ", ".join(f"{name} {1000 * value:.1f}" for name, value in seconds.items())
        print(f"{1 / sum(seconds.values()):.2f} frames/s, {report['device']}; ms a frame: {stages}")
    for name, shown in report["ranges"].items():
        unit = legend.unit_of(name, settings.options.map_descriptor)
        print(f"  {name}: {shown.minimum:.6g} to {shown.maximum:.6g} {unit}".rstrip())
    common.print_notes([*report["notes"], *report["warnings"]])
    print(f"wrote {report['folder']}")
