"""The command line's entry: runs as `python -m paradesc …` and as `blender -b FILE -P cli.py -- …`."""

import sys
from pathlib import Path

if __name__ == "__main__":  # run by Blender as a script: find the package that this file lies in
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from paradesc import commands
from paradesc.bridge import ParadescError
from paradesc.commands.common import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_USAGE, Parser, UsageError


def make_parser() -> Parser:
    """All commands and their options."""
    parser = Parser(
        prog="paradesc", description="Geometric descriptors of UV-mapped meshes, computed in their texture space."
    )
    found = parser.add_subparsers(
        dest="command", required=True, metavar=" | ".join(commands.COMMANDS), parser_class=Parser
    )
    for module in commands.modules():
        module.add_command(found)
    return parser


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
