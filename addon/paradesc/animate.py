"""The animate command: frames of an animation to a folder of files, resumable and on any number of machines."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from . import cache, job, results

if TYPE_CHECKING:
    import bpy

    from .frames import Done, FrameBaker

STAGES = ("depsgraph", "read", "upload", "prepare", "bake", "evaluate", "write")
DEFAULT_FOLDER = "paradesc_cache"


def add_source(parser: argparse.ArgumentParser, default: str) -> None:
    """The option that says which mesh is measured."""
    parser.add_argument(
        "--source", choices=("original", "deformed", "evaluated"), default=default,
        help="the object's own mesh, as deforming modifiers and shape keys move it, or after all its modifiers "
        "(default: %(default)s)",
    )  # fmt: skip


def add_command(commands: "argparse._SubParsersAction", cli: ModuleType) -> None:
    """Adds animate to the command line, whose module lends what commands share."""
    parser = commands.add_parser("animate", help="compute descriptors at frames of an animation into a frame cache")
    cli.add_mesh_options(parser)
    cli.add_map_options(parser)
    add_source(parser, "deformed")
    add = parser.add_argument
    add("--frames", metavar="A:B[:STEP]", help="which frames (default: those of the scene)")
    add("--cache", metavar="FOLDER", type=Path,
        help="where frames are kept, in a folder for each object (default: paradesc_cache by the .blend)")  # fmt: skip
    add("--relative-to-rest", action="store_true", help="also the change against the rest pose, as NAME_change")
    add("--range", metavar="LOW:HIGH", dest="value_range",
        help="colors span these values in all frames (default: what follows from all frames together)")  # fmt: skip
    add("--force", action="store_true", help="compute frames again that are there already")
    add("--json", metavar="REPORT", type=Path, help="write frames, ranges and times as JSON")
    parser.set_defaults(run=lambda arguments: run(arguments, cli))


def run(arguments: argparse.Namespace, cli: ModuleType) -> None:
    """Bakes the frames that are missing, and says what there is then."""
    settings = cli.settings_of(arguments)
    fixed = parse_range(arguments.value_range, cli)
    chosen = parse_frames(arguments.frames, cli)
    cli.check_outputs([arguments.json] if arguments.json else [])
    target = cli.open_object(arguments)
    import bpy

    from . import frames, surface_maps

    scene = bpy.context.scene
    folder = cache.object_folder(cache_folder(arguments, cli), target.name)
    check_folder(folder)
    maps = surface_maps.Sources(
        arguments.displacement,
        arguments.midlevel,
        arguments.displacement_scale,
        arguments.normal_map,
        arguments.material_maps,
    )
    request = frames.Request(
        settings, folder, arguments.source, arguments.relative_to_rest, arguments.force, maps if maps.any else None
    )
    wanted = chosen or range(scene.frame_start, scene.frame_end + 1, max(1, scene.frame_step))
    with cli.quiet(arguments.verbose):
        baker = frames.FrameBaker(scene, target, request)
    with baker:
        with cli.Progress() as progress, frames.frame_kept(scene), baker.evaluating():
            made = bake(baker, wanted, progress)
        if fixed:
            cache.write_fixed(folder, {"": fixed})
        report = summary(baker, wanted, made)
    if arguments.json:
        cli.write_whole(arguments.json, report, results.write_json)
    print_summary(target, report, cli)


def bake(baker: "FrameBaker", wanted: range, progress: job.ProgressFunction) -> "list[Done]":
    """The frames that had to be made."""
    made = []
    for index, frame in enumerate(wanted):
        task = baker.prepare(frame)
        if task is not None:
            made.append(baker.run(task, part_of(progress, frame, index, len(wanted))))
        elif not progress(f"frame {frame}", (index + 1) / len(wanted)):
            raise KeyboardInterrupt
    return made


def part_of(progress: job.ProgressFunction, frame: int, index: int, count: int) -> Callable[[str, float], bool]:
    """The same progress for one of the frames."""
    return lambda stage, fraction: progress(f"frame {frame}: {stage}", (index + fraction) / count)


def parse_range(text: str | None, cli: ModuleType) -> tuple[float, float] | None:
    """The two numbers of LOW:HIGH."""
    if text is None:
        return None
    try:
        low, high = (float(word) for word in text.split(":"))
    except ValueError:
        low = high = 0.0
    if not (low < high and abs(low) < float("inf") and abs(high) < float("inf")):
        raise cli.UsageError(f'"{text}" is no range of values; give LOW:HIGH, for example --range=-5:5.')
    return low, high


def parse_frames(text: str | None, cli: ModuleType) -> range | None:
    """The frames asked for, or None for the scene's."""
    if text is None:
        return None
    from . import frames

    try:
        return frames.parse_frames(text)
    except ValueError as error:
        raise cli.UsageError(str(error)) from error


def cache_folder(arguments: argparse.Namespace, cli: ModuleType) -> Path:
    """The folder asked for, or the one beside the .blend."""
    import bpy

    if arguments.cache is not None:
        return arguments.cache
    if not bpy.data.filepath:
        raise cli.UsageError("There is no .blend to keep the frames beside; give --cache FOLDER.")
    return Path(bpy.data.filepath).parent / DEFAULT_FOLDER


def check_folder(folder: Path) -> None:
    """Makes the folder, or says why it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cache.refused(f'The folder "{folder}" cannot be made: {error.strerror or error}.') from error
    if not os.access(folder, os.W_OK):
        raise cache.refused(f'The folder "{folder}" cannot be written.')


def summary(baker: "FrameBaker", wanted: range, made: "list[Done]") -> dict[str, object]:
    """Everything about a run but its values."""
    folder = baker.request.folder
    neighbors = sorted(path for path in folder.parent.iterdir() if path.is_dir())
    own = cache.locked_ranges([folder], baker.key)
    shared = cache.locked_ranges(neighbors)
    seconds = {stage: sum(done.seconds[stage] for done in made) / len(made) for stage in STAGES} if made else {}
    warnings = list(dict.fromkeys(sentence for done in made for sentence in done.warnings))
    return {
        "object": baker.target.name,
        "settings": baker.request.settings.as_dict(),
        "source": baker.request.source,
        "relative_to_rest": baker.request.relative,
        "folder": str(folder),
        "key": baker.key,
        "frames": list(wanted),
        "made": [done.frame for done in made],
        "kept": [frame for frame in wanted if frame not in {done.frame for done in made}],
        "device": made[0].device if made else "",
        "seconds_per_frame": seconds,
        "ranges": {name: [shown.minimum, shown.maximum] for name, shown in own.items()},
        "ranges_of_all_objects": {name: [shown.minimum, shown.maximum] for name, shown in shared.items()},
        "notes": baker.notes,
        "warnings": warnings,
    }


def print_summary(target: "bpy.types.Object", report: dict, cli: ModuleType) -> None:
    """What was made, in a few lines."""
    made, kept = len(report["made"]), len(report["kept"])
    print(f'object "{target.name}": {made:,} frames made, {kept:,} were there already, source {report["source"]}')
    if made:
        seconds = report["seconds_per_frame"]
        stages = ", ".join(f"{name} {1000 * value:.1f}" for name, value in seconds.items())
        print(f"{1 / sum(seconds.values()):.2f} frames/s on {report['device']}; ms a frame: {stages}")
    for name, (low, high) in report["ranges"].items():
        unit = job.registry_row(name).unit
        print(f"  {name}: {low:.6g} to {high:.6g} {unit}".rstrip() + " over all frames")
    cli.print_notes([*report["notes"], *report["warnings"]])
    print(f"wrote {report['folder']}")
