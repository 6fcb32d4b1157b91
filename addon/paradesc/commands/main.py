"""Runs one command of the command line: turns its arguments into an exit code, a JSON report and sentences."""

import argparse
import contextlib
import io
import os
import sys
from pathlib import Path

from .. import __version__
from ..bridge import ParadescError
from ..core import contexts
from ..files import results
from . import COMMANDS, common, modules
from .common import UsageError
from .signals import Signals, Terminated

# The schema of the JSON reports. It grows if a key changes its meaning or goes, but not if a key is new.
SCHEMA = 1


def make_parser() -> common.Parser:
    """All commands and their options. A command that lacks options of others has the defaults of bake and animate."""
    parser = common.Parser(
        prog="paradesc", description="Curvature and other geometric descriptors of meshes, at a radius you choose."
    )
    parser.add_argument("--version", action="version", version=f"paradesc {__version__}")
    found = parser.add_subparsers(dest="command", required=True, metavar=" | ".join(COMMANDS))
    for module in modules():
        command = found.add_parser(module.__name__.rpartition(".")[2], help=module.HELP)
        module.add_options(command)
        common.add_output_options(command)
        command.set_defaults(run=module.run, files_beside=getattr(module, "files_beside", None))
    for name in ("animate", "bake"):
        parser.set_defaults(**vars(found.choices[name].parse_args([])))
    return parser


def main(words: list[str]) -> int:
    """Runs one command; returns the exit code. Any failure is one sentence on the standard error stream."""
    take_any_alphabet()
    try:
        arguments, unknown = make_parser().parse_known_args(common.with_also(words))
        if unknown:
            kind = "is no option" if unknown[0].startswith("-") else "is no place for"
            raise UsageError(f'There {kind} "{unknown[0]}"; see paradesc {arguments.command} --help.')
        check_report(arguments)
    except UsageError as error:
        return say(str(error), common.EXIT_USAGE)
    except SystemExit as error:  # --help and --version, which were shown
        return int(error.code or 0)
    is_muted = prints_json(arguments) or (arguments.quiet and arguments.command != "tasks")  # a list is no remark
    try:
        with Signals(raises=True):
            with contextlib.redirect_stdout(io.StringIO()) if is_muted else contextlib.nullcontext():
                common.check_outputs([arguments.json])
                content = arguments.run(arguments) or {}
            sentence = " ".join(content.get("failed_checks", []))
            code = common.EXIT_CHECK if sentence else common.EXIT_OK
            write_report(arguments, content, code, sentence)
        return say(sentence, code, arguments) if sentence else code
    except (UsageError, ParadescError, OSError, KeyboardInterrupt, Terminated) as error:
        sentence, code = sentence_of(error), common.exit_code(error)
    except Exception as error:  # a defect of ours; --verbose shows where
        if arguments.verbose:
            raise
        sentence, code = f"Unexpected {type(error).__name__}: {error} (--verbose says where).", common.EXIT_FAILED
    finally:
        contexts.close_idle()
    with contextlib.suppress(ParadescError, OSError):  # an error while the report is written is not reported as well
        write_report(arguments, {}, code, " ".join(sentence.split()))
    return say(sentence, code, arguments)


def take_any_alphabet() -> None:
    """Makes the standard streams escape characters that their encoding lacks, where Python would fail.

    Streams that the process lacks, as services and programs with a window may, take everything and keep nothing.
    """
    sys.stdout = sys.stdout or Path(os.devnull).open("w")  # noqa: SIM115 (open as long as the process is)
    sys.stderr = sys.stderr or Path(os.devnull).open("w")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def sentence_of(error: BaseException) -> str:
    """The error as one sentence for people."""
    if isinstance(error, (KeyboardInterrupt, Terminated)):
        return "Terminated." if isinstance(error, Terminated) else "Interrupted."
    if isinstance(error, OSError):
        named = f'"{error.filename}" cannot be used' if error.filename else "The system refused"
        return f"{named}: {error.strerror or error}."
    return error.sentence if isinstance(error, ParadescError) else str(error)


def prints_json(arguments: argparse.Namespace) -> bool:
    """Returns whether the report goes to the standard output."""
    return str(arguments.json) == "-"


def check_report(arguments: argparse.Namespace) -> None:
    """Refuses a report that would not be alone on the standard output, or that would take the place of another file.

    A failure has a report too, so this comes before any other check, whose failure would write it.
    """
    path = arguments.json
    if prints_json(arguments):
        if arguments.progress == "openjd":
            raise UsageError("--json - and --progress openjd both write to the standard output; name a file.")
    elif path is not None:
        common.check_apart(path, common.named_files(arguments, "json"), "the report")


def write_report(arguments: argparse.Namespace, content: dict[str, object], code: int, sentence: str) -> None:
    """Writes the report of a command, if it was asked for."""
    path, given = arguments.json, arguments.input
    if path is None:
        return
    report = {
        "schema": SCHEMA,
        "version": __version__,
        "command": arguments.command,
        "status": {common.EXIT_OK: "ok", common.EXIT_CHECK: "check failed"}.get(code, "failed"),
        "exit_code": code,
        "error": sentence or None,
        "input": str(given) if given else None,
        **content,
    }
    if prints_json(arguments):
        print(results.json_text(report, ascii_only=True), end="")
        return
    results.write_whole(path, report, results.write_json)
    if code in (common.EXIT_OK, common.EXIT_CHECK) and not arguments.quiet:
        print(f"wrote {path}")


def say(sentence: str, code: int, arguments: argparse.Namespace | None = None) -> int:
    """Prints the failure on one line, and tells it a session of Open Job Description, with --progress openjd."""
    if arguments is not None and arguments.progress == "openjd":
        common.tell_openjd("fail", sentence)
    with contextlib.suppress(OSError):  # where nobody can read it, the code still tells
        print("paradesc: " + " ".join(sentence.split()), file=sys.stderr, flush=True)
    return code
