"""paradesc tasks: lists the tasks into which another command divides, for engines that share them out over machines.

Each task is a line of JSON: name, stage (tasks of a stage run in any order, after the stage before), command (with its
arguments), input and outputs.
"""

import argparse
import json
import math
import shlex
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..bridge import InputError, ParadescError
from ..files import cache, results
from ..files.results import folder_fault, write_whole
from . import animate, animate_files, assets, bundles, library
from .common import Parser, UsageError, add_output_options, check_outputs, has_blender
from .options import opened_settings, settings_of
from .sources import source_of

DIVIDED = ("animate", "library")
FRAMES_A_TASK = 10
PARTS = 16  # of a library in a bundle, unless --chunk says how many assets each has
# OURS are options that each task gets from here. REFUSED are options with which tasks would write the same files or
# compute the same parts.
OURS = {"animate": ("--frames",), "library": ()}
REFUSED = {"animate": ("--json",), "library": ("--json", "--part", "--asset", "--dask")}


@dataclass
class Listed:
    """The tasks of a command, and the values of a bundle's parameters."""

    tasks: list[dict]
    parameters: dict[str, object]
    notes: list[str] = field(default_factory=list)


def add_command(commands: "argparse._SubParsersAction[Parser]") -> None:
    """The command and its options."""
    tasks = commands.add_parser("tasks", help="list the tasks of animate or library, for render farms")
    add_own_options(tasks)
    add_output_options(tasks)
    help_text = "animate or library, its input, and its options, as that command takes them"
    tasks.add_argument("words", nargs=argparse.REMAINDER, metavar="COMMAND ...", help=help_text)
    tasks.set_defaults(run=run)


def add_own_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options that may stand before the command or among its words."""
    add = parser.add_argument
    add("--chunk", type=int, metavar="N",
        help=f"frames per task (default: {FRAMES_A_TASK}), or assets per task, about (default: one)")  # fmt: skip
    add("--program", metavar="WORDS", help="first words of the commands (default: paradesc)")
    add("--list", metavar="FILE", type=Path, help="write the list to this file (default: the standard output)")
    add("--bundle", metavar="FOLDER", type=Path,
        help="write a job bundle of Open Job Description there instead of the list")  # fmt: skip
    add("--flamenco", metavar="FOLDER", type=Path, help="copy the job types of Flamenco to its folder of scripts")


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Lists the tasks, or writes job descriptions; returns the report."""
    words = own_options(arguments)
    check(arguments, words)
    written: list[Path] = []
    if arguments.flamenco is not None:
        written += bundles.write_job_types(arguments.flamenco)
    listed = Listed([], {})
    if words:
        parsed = parsed_words(words)
        listed = tasks_of(words, parsed, arguments)
        if arguments.bundle is not None:
            values = bundles.values_of(words[2:], listed.parameters, program_of(arguments))
            kind = "animation" if words[0] == "animate" else "library"
            written += bundles.write_bundle(arguments.bundle, kind, values)
        else:
            write_list(arguments, listed.tasks)
    for sentence in listed.notes:
        print(f"note: {sentence}", file=sys.stderr)  # the standard output may be the list
    for path in written:
        print(f"wrote {path}")
    return {
        "tasks": len(listed.tasks),
        "outputs": [str(path) for path in written],
        "notes": listed.notes,
        "warnings": [],
    }


def own_options(arguments: argparse.Namespace) -> list[str]:
    """Parses the options of this command that stand among the other command's words; returns the remaining words."""
    own = Parser(prog="paradesc tasks", add_help=False, allow_abbrev=False)
    add_own_options(own)
    found, words = own.parse_known_args(arguments.words)
    for name, value in vars(found).items():
        if value is not None:
            setattr(arguments, name, value)
    return words


def check(arguments: argparse.Namespace, words: list[str]) -> None:
    """Refuses words that cannot be divided into tasks, before any file is opened."""
    if not words and arguments.flamenco is None:
        raise UsageError(f"There is no command to divide; give {' or '.join(DIVIDED)}, its input and its options.")
    if words and words[0] not in DIVIDED:
        raise UsageError(f'"{words[0]}" is not divided into tasks; give {" or ".join(DIVIDED)}.')
    if words and "--help" not in words and (len(words) < 2 or words[1].startswith("-")):
        raise UsageError(f"Give the input directly after {words[0]}.")
    for word in words:
        if word.partition("=")[0] in REFUSED[words[0]]:
            raise UsageError(f"Every task would have the same {word.partition('=')[0]}; leave it out.")
    if arguments.chunk is not None and arguments.chunk < 1:
        raise UsageError(f"--chunk is {arguments.chunk}; it must be at least 1.")
    check_outputs([path for path in (arguments.json, arguments.list) if path])
    for folder in filter(None, (arguments.bundle, arguments.flamenco)):
        if folder_fault(folder):
            raise UsageError(folder_fault(folder))


def parsed_words(words: list[str]) -> argparse.Namespace:
    """Parses the words of the other command, which raises the same errors as that command."""
    from .main import make_parser

    parsed, unknown = make_parser().parse_known_args(words)
    if unknown:
        raise UsageError(f'There is no option "{unknown[0]}"; see paradesc {words[0]} --help.')
    settings_of(parsed)
    return parsed


def tasks_of(words: list[str], parsed: argparse.Namespace, arguments: argparse.Namespace) -> Listed:
    """The tasks of either command."""
    rest, _ = bundles.without_options(words, OURS[words[0]])
    start = [*program_of(arguments), *rest]
    if words[0] == "animate":
        return frames_of(start, parsed, arguments)
    return assets_of(start, parsed, arguments)


def program_of(arguments: argparse.Namespace) -> list[str]:
    """The words with which each task's command begins."""
    return shlex.split(arguments.program or "paradesc")


def write_list(arguments: argparse.Namespace, tasks: list[dict]) -> None:
    """Writes a line for each task."""
    printed = arguments.list is None or str(arguments.list) == "-"
    text = "".join(json.dumps(results.finite_only(task), ensure_ascii=printed) + "\n" for task in tasks)
    if printed:
        print(text, end="")
    else:
        write_whole(arguments.list, text, results.write_text)


# ---- Frames


@dataclass
class Scene:
    """The facts about a scene or a sequence of files that the tasks depend on."""

    frames: Sequence[int]
    root: Path  # of all frames
    folders: list[Path]  # of the frames of each object
    note: str = ""


def frames_of(start: list[str], parsed: argparse.Namespace, arguments: argparse.Namespace) -> Listed:
    """Chunks of frames."""
    chunk = arguments.chunk or FRAMES_A_TASK
    scene = sequence_of(parsed) if animate_files.is_asked(parsed) else scene_of(parsed)
    tasks = []
    for frames in chunks(scene.frames, chunk):
        text = written_frames(frames)
        outputs = [str(cache.frame_path(folder, frame)) for folder in scene.folders for frame in frames]
        tasks.append(
            {
                "name": f"frames {text}",
                "stage": 1,
                "command": [*start, f"--frames={text}"],  # the first frame may be negative
                "input": str(parsed.input),
                "outputs": outputs or [str(scene.root)],
            }
        )
    parameters = {"Scene": absolute(parsed.input), "Cache": absolute(scene.root), "FramesPerTask": chunk}
    if arguments.bundle is not None:
        if not isinstance(scene.frames, range):
            raise UsageError(
                "The bundle for frames takes a scene; list the tasks of a sequence of files without --bundle."
            )
        parameters["Frames"] = written_frames(scene.frames).replace(":", "-", 1)
    return Listed(tasks, parameters, [scene.note] if scene.note else [])


def chunks(frames: Sequence[int], longest: int) -> Iterator[range]:
    """Divides frames, which may have gaps, into ranges of at most this length."""
    if isinstance(frames, range):
        for first in range(0, len(frames), longest):
            yield frames[first : first + longest]
        return
    first = 0
    for index in range(1, len(frames) + 1):
        ends = index == len(frames) or index - first == longest or frames[index] != frames[index - 1] + 1
        if ends:
            yield range(frames[first], frames[index - 1] + 1)
            first = index


def written_frames(frames: range) -> str:
    """Frames in the notation of --frames."""
    text = f"{frames[0]}:{frames[-1]}" if len(frames) > 1 else f"{frames[0]}"
    return text if frames.step == 1 or len(frames) == 1 else f"{text}:{frames.step}"


def absolute(path: Path) -> str:
    """The absolute path, since other machines have other working directories."""
    return str(path.absolute())


def scene_of(parsed: argparse.Namespace) -> Scene:
    """Opens the scene for its frames and objects. Without Blender, the options have to supply them."""
    frames = animate.parse_frames(parsed.frames)
    try:
        source = source_of(parsed)
        source.open()
        objects = source.picked().objects
    except (ParadescError, InputError):
        if has_blender() or frames is None or parsed.cache is None:
            raise
        note = "Without Blender's module bpy nobody knows the objects: outputs are the folder of all."
        return Scene(frames, parsed.cache, [], note)
    opened_settings(parsed)  # which are refused here if they make no sense
    root = source.cache_folder()
    folders = [cache.object_folder(root, target.name) for target in objects]
    return Scene(frames or source.frame_range(), root, folders)


def sequence_of(parsed: argparse.Namespace) -> Scene:
    """Opens the first file of a sequence."""
    meshes = animate_files.opened(parsed)
    frames = animate_files.wanted(meshes, animate.parse_frames(parsed.frames))
    root = animate_files.cache_folder(parsed)
    folders = [cache.object_folder(root, mesh.name) for mesh in meshes]
    opened_settings(parsed)
    return Scene(list(frames), root, folders)


# ---- Assets


def assets_of(start: list[str], parsed: argparse.Namespace, arguments: argparse.Namespace) -> Listed:
    """A task for each asset, or for each of equal parts; then a task that lists their results."""
    library.check(parsed)
    settings = opened_settings(parsed)
    names = [name for name, _ in library.found(parsed.input)]
    work = library.work_of(parsed, settings, 2)
    chunk = arguments.chunk or 1
    parts = max(1, math.ceil(len(names) / chunk))
    shares = [(f"--asset={name}", [name]) for name in names]
    if arguments.chunk or arguments.bundle:
        parts = parts if arguments.chunk else min(parts, PARTS)
        shares = [(f"--part={k}/{parts}", assets.of_part(names, (k, parts))) for k in range(1, parts + 1)]
    tasks = [asset_task([*start, word, "--allow-failures"], parsed, work, share) for word, share in shares if share]
    tasks.append(
        {
            "name": "listing",
            "stage": 2,
            "command": start,
            "input": str(parsed.input),
            "outputs": [str(parsed.output / library.LISTING)],
        }
    )
    parameters = {"Library": absolute(parsed.input), "Output": absolute(parsed.output), "Parts": parts}
    return Listed(tasks, parameters)


def asset_task(
    command: list[str], parsed: argparse.Namespace, work: assets.Work, names: list[str]
) -> dict[str, object]:
    """The task that computes these assets."""
    where = [path(work, name) for name in names for path in (assets.results_path, assets.row_path)]
    return {
        "name": names[0] if len(names) == 1 else f"{command[-2].removeprefix('--part=')}: {len(names)} assets",
        "stage": 1,
        "command": command,
        "input": str(parsed.input / names[0] if len(names) == 1 else parsed.input),
        "outputs": [str(parsed.output / path.relative_to(work.output)) for path in where],
    }
