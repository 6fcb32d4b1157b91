"""Runs one command of the command line: turns its arguments into an exit code, a JSON report and sentences."""

import argparse
import contextlib
import io
import sys
from collections.abc import Iterator
from pathlib import Path

from .. import __version__
from ..bridge import ParadescError
from ..core import contexts
from ..files import results
from . import COMMANDS, common, modules
from .signals import Signals, Terminated

# The schema of the JSON reports. It grows if a key changes its meaning or goes, but not if a key is new.
SCHEMA = 1


def make_parser() -> common.Parser:
    """All commands and their options."""
    parser = common.Parser(
        prog="paradesc", description="Curvature and other geometric descriptors of meshes, at a radius you choose."
    )
    parser.add_argument("--version", action="version", version=f"paradesc {__version__}")
    found = parser.add_subparsers(dest="command", required=True, metavar=" | ".join(COMMANDS))
    for module in modules():
        command = found.add_parser(module.__name__.rpartition(".")[2], help=module.HELP)
        module.add_options(command)
        common.add_output_options(command)
        command.set_defaults(run=module.run)
    return parser


def main(words: list[str]) -> int:
    """Runs one command; returns the exit code. Any failure is one sentence on the standard error stream."""
    take_any_alphabet()
    try:
        arguments, unknown = make_parser().parse_known_args(common.with_also(words))
        if unknown:
            kind = "is no option" if unknown[0].startswith("-") else "is no place for"
            raise common.UsageError(f'There {kind} "{unknown[0]}"; see paradesc {arguments.command} --help.')
    except common.UsageError as error:
        return say(str(error), common.exit_code(error))
    except SystemExit as error:  # --help and --version, which were shown
        return int(error.code or 0)
    if prints_json(arguments) and getattr(arguments, "progress", None) == "openjd":
        return say("--json - and --progress openjd both write to the standard output; name a file.", common.EXIT_USAGE)
    if reports_over_input(arguments):
        return say(f'"{arguments.json}" is the input; choose another file for the report.', common.EXIT_USAGE)
    try:
        with Signals(raises=True):
            with muted(arguments):
                common.check_outputs([arguments.json])
                content = arguments.run(arguments) or {}
            sentence = " ".join(content.get("failed_checks", []))
            code = common.EXIT_CHECK if sentence else common.EXIT_OK
            write_report(arguments, content, code, sentence)
    except (common.UsageError, ParadescError, OSError, KeyboardInterrupt, Terminated) as error:
        return fail(arguments, sentence_of(error), common.exit_code(error))
    except Exception as error:  # a defect of ours; --verbose shows where
        if getattr(arguments, "verbose", False):
            raise
        sentence = f"Unexpected {type(error).__name__}: {error} (--verbose says where)."
        return fail(arguments, sentence, common.EXIT_FAILED)
    finally:
        contexts.close_idle()
    return say(sentence, code, arguments) if sentence else code


def take_any_alphabet() -> None:
    """Makes the standard streams escape characters that their encoding lacks, where Python would fail."""
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


@contextlib.contextmanager
def muted(arguments: argparse.Namespace) -> Iterator[None]:
    """Mutes prints with --quiet, or if the standard output belongs to the JSON report."""
    if not getattr(arguments, "quiet", False) and not prints_json(arguments):
        yield
        return
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def prints_json(arguments: argparse.Namespace) -> bool:
    """Whether the report goes to the standard output."""
    return str(getattr(arguments, "json", None)) == "-"


def reports_over_input(arguments: argparse.Namespace) -> bool:
    """Whether writing the report, even one about a failure, would overwrite the input or the open .blend."""
    path: Path | None = getattr(arguments, "json", None)
    if path is None or prints_json(arguments):
        return False
    inputs = (getattr(arguments, "input", None), common.open_file())
    return any(given is not None and path.resolve() == given.resolve() for given in inputs)


def write_report(arguments: argparse.Namespace, content: dict[str, object], code: int, sentence: str) -> None:
    """Writes the report of a command, if it was asked for."""
    path: Path | None = getattr(arguments, "json", None)
    if path is None:
        return
    status = {common.EXIT_OK: "ok", common.EXIT_CHECK: "check failed"}.get(code, "failed")
    given = getattr(arguments, "input", None)
    report = {
        "schema": SCHEMA,
        "version": __version__,
        "command": arguments.command,
        "status": status,
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


def fail(arguments: argparse.Namespace, sentence: str, code: int) -> int:
    """Reports the failure in all places. An error while the report is written is not reported as well."""
    with contextlib.suppress(ParadescError):
        write_report(arguments, {}, code, " ".join(sentence.split()))
    return say(sentence, code, arguments)


def say(sentence: str, code: int, arguments: argparse.Namespace | None = None) -> int:
    """Prints the failure on one line, and tells it a session of Open Job Description, with --progress openjd."""
    if getattr(arguments, "progress", None) == "openjd":
        common.tell_openjd("fail", sentence)
    print("paradesc: " + " ".join(sentence.split()), file=sys.stderr)
    return code
