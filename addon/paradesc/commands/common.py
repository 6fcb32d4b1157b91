"""The shared parts of commands: errors and exit codes, checks of outputs, progress, notes."""

import argparse
import importlib.util
import os
import shlex
import sys
import time
from itertools import chain
from pathlib import Path
from typing import NoReturn

from ..bridge import InputError, ParadescError, abi
from ..files import mesh_files
from ..files.results import file_fault
from .signals import Signals, Terminated

EXIT_OK = 0
EXIT_FAILED = 1  # could not be computed or written
EXIT_USAGE = 2  # the arguments make no sense
EXIT_INPUT = 3  # the input cannot be read or used
EXIT_DEVICE = 4  # no such device, or it cannot do this; or a part of the installation is missing
EXIT_CHECK = 5  # everything is written, but a check that was asked for failed
EXIT_INTERRUPTED = 130  # Ctrl-C
EXIT_TERMINATED = 143  # SIGTERM
PROGRESS = ("auto", "lines", "openjd", "off")
# Lines of --progress lines and openjd are at least this share of the work apart.
LINE_STEP = 0.05
# The class that reads Blender's scene: an enabled add-on adds its SceneSource; else BLENDER_PART has one, if installed.
BLENDER: list[type] = []
BLENDER_PART = "paradesc_blender"
ADDON_REMEDY = f"put the folder that holds {BLENDER_PART} on PYTHONPATH"


class UsageError(Exception):
    """The arguments contradict each other; the text is one sentence."""


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        """Raises instead of printing the usage and exiting."""
        sentence = message[:1].upper() + message[1:].rstrip(".")
        raise UsageError(f"{sentence}; see {self.prog} --help.")


def exit_code(error: BaseException) -> int:
    """The exit code of the process after this error."""
    if isinstance(error, UsageError):
        return EXIT_USAGE
    if isinstance(error, InputError):
        return EXIT_INPUT
    if isinstance(error, ParadescError):
        by_status = {abi.STATUS_INVALID_ARGUMENT: EXIT_USAGE, abi.STATUS_UNSUPPORTED: EXIT_DEVICE}
        return by_status.get(error.status, EXIT_FAILED)
    if isinstance(error, Terminated):
        return EXIT_TERMINATED
    return EXIT_INTERRUPTED if isinstance(error, KeyboardInterrupt) else EXIT_FAILED


def add_output_options(parser: Parser) -> None:
    """Adds the options that control what a command prints, and where."""
    add = parser.add_argument
    add("--json", metavar="FILE", type=Path, help="write a report as JSON, also when it fails; - prints it")
    add("--quiet", "-q", action="store_true", help="print errors only")
    add("--verbose", action="store_true", help="show what Blender itself prints")
    add("--also", metavar="WORDS", action="append", default=[],
        help="more of these options in one word, as job descriptions pass them; may be empty")  # fmt: skip


def with_also(words: list[str]) -> list[str]:
    """Replaces each --also by the options that its text contains."""
    found: list[str] = []
    left = iter(words)
    for word in left:
        text = next(left, None) if word == "--also" else word.removeprefix("--also=")
        if not word.startswith("--also") or text is None:
            found.append(word)
            continue
        found += split_words(text, "--also")
    return found


def split_words(text: str, option: str, escapes: bool = os.name != "nt") -> list[str]:
    """The words of an option's text as a shell tells them apart; on Windows a backslash belongs to a path."""
    words = shlex.shlex(text, posix=True, punctuation_chars=False)
    words.whitespace_split, words.commenters = True, ""
    words.escape = words.escape if escapes else ""
    try:
        return list(words)
    except ValueError as error:
        raise UsageError(f"The words of {option}, {text}, cannot be told apart: {error}.") from error


def refuse(fault: str) -> None:
    """Raises a fault of the arguments, unless the sentence is empty."""
    if fault:
        raise UsageError(fault)


def check_outputs(paths: list[Path | None]) -> None:
    """Refuses outputs that cannot be written, before anything is computed; "-" is the standard output."""
    for path in paths:
        refuse(file_fault(path) if path and str(path) != "-" else "")


def check_overwriting(paths: list[Path], given: Path | None, force: bool) -> None:
    """Refuses to write over the input; every other file may be replaced."""
    for path in paths:
        if given is not None and not force and path.resolve() == given.resolve():
            raise UsageError(f'"{path}" is the input; add --force to write over it, or choose another name.')


def named_files(arguments: argparse.Namespace, besides: str = "") -> list[Path]:
    """The files that a command reads and writes, as far as its options tell, besides that of one option."""
    options = [value for option, value in vars(arguments).items() if option != besides]
    files = list(chain.from_iterable(value if isinstance(value, list) else [value] for value in options))
    files += [open_file(), arguments.preset and Path(arguments.preset)]  # which may also be a name
    files += arguments.files_beside(arguments) if arguments.files_beside else []
    return [path for path in files if isinstance(path, Path)]


def check_apart(path: Path, taken: list[Path], purpose: str) -> None:
    """Refuses a file for this purpose if it would take the place of another file of its command, or of a mesh."""
    if path.resolve() in [other.resolve() for other in taken]:
        raise UsageError(f'"{path}" is the input or an output; choose another file for {purpose}.')
    if path.suffix.lower() in mesh_files.SUFFIXES and path.is_file():  # perhaps one of a folder that is the input
        raise UsageError(f'"{path}" is a mesh; choose another file for {purpose}.')


def has_blender() -> bool:
    """Returns whether Blender's Python module and the add-on can be imported; this does not import them."""
    return lacking() is None


def lacking() -> tuple[str, str] | None:
    """Why Blender cannot be used here, and what to do; None if it can."""
    remedy = "" if BLENDER or importlib.util.find_spec(BLENDER_PART) else ADDON_REMEDY
    if "bpy" not in sys.modules and importlib.util.find_spec("bpy") is None:
        remedies = filter(None, ["pip install bpy", remedy])
        return "Blender's Python module bpy is not installed here", " and ".join(remedies)
    return ("Paradesc's add-on for Blender is not on Python's path", remedy) if remedy else None


def open_file() -> Path | None:
    """The .blend that the open scene comes from, if there is one."""
    blender = sys.modules.get("bpy")
    return Path(blender.data.filepath) if blender is not None and blender.data.filepath else None


def saves_scene(arguments: argparse.Namespace) -> bool:
    """Returns whether a .blend is among the outputs, so that results have to be written to the scene's objects."""
    return any(path.suffix.lower() == ".blend" for path in arguments.output)


def print_notes(sentences: list[str]) -> None:
    """Prints one line for each limit of the results."""
    for sentence in filter(None, sentences):
        print(f"note: {sentence}")


def tell_openjd(kind: str, text: str) -> None:
    """Writes one message of Open Job Description, even with --quiet, as its sessions read the standard output."""
    if sys.__stdout__ is not None:
        sys.__stdout__.write(f"openjd_{kind}: {' '.join(text.split())}\n")
        sys.__stdout__.flush()


class Progress(Signals):
    """Shows how far the work is on the standard error stream, and lets Ctrl-C and SIGTERM cancel it at the next tile.

    auto: one line that is written over and over, on a terminal only; lines: a line every few percent, for a farm's log;
    openjd: the lines on the standard output by which Open Job Description's sessions know the progress.
    """

    def __init__(self, mode: str = "auto") -> None:
        super().__init__()
        self.mode = mode
        self.shown = mode == "auto" and sys.stderr.isatty()
        self.time = 0.0
        self.last = -1.0

    def __call__(self, stage: str, fraction: float) -> bool:
        """Shows the stage and the percentage; False once the work has to stop."""
        now = time.monotonic()
        if self.shown and now - self.time > 0.1:
            self.time = now
            sys.stderr.write(f"\r\x1b[K{fraction:6.1%} {stage}")
            sys.stderr.flush()
        is_due = fraction >= self.last + LINE_STEP or fraction >= 1.0 > self.last
        if is_due and self.mode == "lines":
            sys.stderr.write(f"Progress: {100 * fraction:.0f}% {stage}\n")
            sys.stderr.flush()
        if is_due and self.mode == "openjd":
            tell_openjd("progress", f"{100 * fraction:.1f}")
            tell_openjd("status", stage)
        self.last = fraction if is_due else self.last
        return self.stopped is None

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        if self.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
        self.check()

    def check(self) -> None:
        """Raises the exception of Ctrl-C or SIGTERM once one has come."""
        if self.stopped is not None:
            raise self.stopped
