"""What the commands share: their errors and exit codes, opening the input, checks of outputs, progress, notes."""

import argparse
import os
import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from ..bridge import ParadescError, abi
from ..streams import quiet

if TYPE_CHECKING:
    import bpy

EXIT_FAILED, EXIT_USAGE, EXIT_INTERRUPTED = 1, 2, 130


class UsageError(Exception):
    """The arguments make no sense; the text is one sentence."""


class Parser(argparse.ArgumentParser):
    """argparse whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        """Raises instead of printing the usage and exiting."""
        sentence = message[:1].upper() + message[1:].rstrip(".")
        raise UsageError(f"{sentence}; see {self.prog} --help.")


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


def print_notes(sentences: list[str]) -> None:
    """What limits the results, a line each."""
    for sentence in filter(None, sentences):
        print(f"note: {sentence}")


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
