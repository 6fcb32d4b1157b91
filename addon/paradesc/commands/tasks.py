"""paradesc tasks: lists the tasks into which another command divides, for engines that share them out over machines.

Each task is a line of JSON: name, stage (tasks of a stage run in any order, after the stage before), command (with its
arguments), input and outputs.
"""

import argparse
import json
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..bridge import ParadescError
from ..files import cache, results
from ..files.results import folder_fault, write_whole
from . import animate_files, assets, bundles, library
from .common import Parser, UsageError, check_apart, check_outputs, has_blender, named_files, split_words
from .options import opened_settings, settings_of

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


HELP = "list the tasks of animate or library, for render farms"


def add_options(parser: Parser) -> None:
    """The command's options."""
    add_own_options(parser)
    help_text = "animate or library, its input, and its options, as that command takes them"
    parser.add_argument("words", nargs=argparse.REMAINDER, metavar="COMMAND ...", help=help_text)
    parser.set_defaults(parsed=None)


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


def files_beside(arguments: argparse.Namespace) -> list[Path]:
    """The files that the command writes, or that the words of the other command name."""
    words = own_options(arguments)
    files = [arguments.list] if arguments.list is not None else []
    files += bundles.files_of(arguments.bundle) if arguments.bundle is not None else []
    return files + words_files(arguments, words)


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Lists the tasks, or writes job descriptions; returns the report."""
    words = own_options(arguments)
    check(arguments, words)
    written: list[Path] = []
    if arguments.flamenco is not None:
        written += bundles.copied(sorted((bundles.FARMS / "flamenco").glob("*.js")), arguments.flamenco)
    listed = Listed([], {})
    if words:
        parsed, program = parsed_words(arguments, words), split_words(arguments.program or "paradesc", "--program")
        settings_of(parsed)  # which are refused here if they make no sense
        start = [*program, *bundles.without_options(words, OURS[words[0]])[0]]
        listed = (frames_of if words[0] == "animate" else assets_of)(start, parsed, arguments)
        if arguments.bundle is not None:
            values = bundles.values_of(words[2:], listed.parameters, program)
            kind = "animation" if words[0] == "animate" else "library"
            written += bundles.write_bundle(arguments.bundle, kind, values)
        else:
            written += write_list(arguments, listed.tasks)
    lines = [*(f"note: {sentence}" for sentence in listed.notes), *(f"wrote {path}" for path in written)]
    for line in lines if not arguments.quiet else []:
        print(line, file=sys.stderr)  # the standard output may be the list
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


def words_files(arguments: argparse.Namespace, words: list[str]) -> list[Path]:
    """The files that the words of the other command name, or none if they are not words of such a command."""
    return named_files(parsed_words(arguments, words)) if words and words[0] in DIVIDED else []


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
    check_destinations(arguments, words)


def check_destinations(arguments: argparse.Namespace, words: list[str]) -> None:
    """Refuses to write where the list or a job description cannot be written, or would take another file's place."""
    check_outputs([arguments.list])
    if arguments.list is not None:
        check_apart(arguments.list, words_files(arguments, words), "the list")
    if words and arguments.bundle is None and is_printed(arguments.list) and str(arguments.json) == "-":
        raise UsageError("--json - and the list both write to the standard output; give --list a file.")
    for folder in filter(None, (arguments.bundle, arguments.flamenco)):
        if folder_fault(folder):
            raise UsageError(folder_fault(folder))


def parsed_words(arguments: argparse.Namespace, words: list[str]) -> argparse.Namespace:
    """Parses the words of the other command once, which raises the same errors as that command."""
    from .main import make_parser

    if arguments.parsed is None:
        arguments.parsed, unknown = make_parser().parse_known_args(words)
        if unknown:
            raise UsageError(f'There is no option "{unknown[0]}"; see paradesc {words[0]} --help.')
    return arguments.parsed


def is_printed(path: Path | None) -> bool:
    """Returns whether a list goes to the standard output."""
    return path is None or str(path) == "-"


def write_list(arguments: argparse.Namespace, tasks: list[dict]) -> list[Path]:
    """Writes a line for each task; returns the file, or nothing if they are printed."""
    printed = is_printed(arguments.list)
    text = "".join(json.dumps(results.finite_only(task), ensure_ascii=printed) + "\n" for task in tasks)
    if printed:
        print(text, end="")
        return []
    write_whole(arguments.list, text, results.write_text)
    return [arguments.list]


# ---- Frames


def task(name: str, stage: int, command: list[str], given: Path, outputs: list[Path]) -> dict[str, object]:
    """One task as it is listed."""
    return {
        "name": name,
        "stage": stage,
        "command": command,
        "input": str(given),
        "outputs": [str(path) for path in outputs],
    }


def frames_of(start: list[str], parsed: argparse.Namespace, arguments: argparse.Namespace) -> Listed:
    """Chunks of frames."""
    chunk = arguments.chunk or FRAMES_A_TASK
    frames, root, folders, notes = scene_of(parsed)
    tasks = []
    for part in chunks(frames, chunk):
        text = written_frames(part)
        outputs = [cache.frame_path(folder, frame) for folder in folders for frame in part]
        command = [*start, f"--frames={text}"]  # the first frame may be negative
        tasks.append(task(f"frames {text}", 1, command, parsed.input, outputs or [root]))
    parameters = {"Scene": absolute(parsed.input), "Cache": absolute(root), "FramesPerTask": chunk}
    if arguments.bundle is not None:
        if not isinstance(frames, range):
            raise UsageError(
                "The bundle for frames takes a scene; list the tasks of a sequence of files without --bundle."
            )
        parameters["Frames"] = written_frames(frames).replace(":", "-", 1)
    return Listed(tasks, parameters, notes)


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


def scene_of(parsed: argparse.Namespace) -> tuple[Sequence[int], Path, list[Path], list[str]]:
    """The frames, the folder of them all, that of each object's, and notes; without Blender, options supply them."""
    frames, source = animate_files.parse_frames(parsed.frames), None
    try:
        source = animate_files.source_of_frames(parsed)
        source.open()
        objects = source.picked().objects
    except ParadescError:
        if source is not None or has_blender() or frames is None or parsed.cache is None:
            raise
        note = "Without Blender's module bpy nobody knows the objects: outputs are the folder of all."
        return frames, parsed.cache, [], [note]
    opened_settings(parsed)  # which are refused here if they make no sense
    root = source.cache_folder()
    folders = [cache.object_folder(root, target.name) for target in objects]
    frames = frames or source.frame_range()
    is_scene = not isinstance(source, animate_files.SequenceSource)
    return frames if is_scene else list(frames), root, folders, []


# ---- Assets


def assets_of(start: list[str], parsed: argparse.Namespace, arguments: argparse.Namespace) -> Listed:
    """A task for each asset, or for each of equal parts; then a task that lists their results."""
    library.check(parsed)
    opened_settings(parsed)  # which are refused here if they make no sense
    names = [name for name, _ in library.found(parsed.input)]
    chunk = arguments.chunk or 1
    parts = max(1, math.ceil(len(names) / chunk))
    shares = [(f"--asset={name}", [name]) for name in names]
    if arguments.chunk or arguments.bundle:
        parts = parts if arguments.chunk else min(parts, PARTS)
        shares = [(f"--part={k}/{parts}", assets.of_part(names, (k, parts))) for k in range(1, parts + 1)]
    tasks = []
    for word, share in shares:
        outputs = [path for name in share for path in assets.paths_of(parsed.output, name)]
        name = share[0] if len(share) == 1 else f"{word.removeprefix('--part=')}: {len(share)} assets"
        given = parsed.input / share[0] if len(share) == 1 else parsed.input
        tasks += [task(name, 1, [*start, word, "--allow-failures"], given, outputs)] if share else []
    tasks.append(task("listing", 2, start, parsed.input, [parsed.output / library.LISTING]))
    parameters = {"Library": absolute(parsed.input), "Output": absolute(parsed.output), "Parts": parts}
    return Listed(tasks, parameters)
