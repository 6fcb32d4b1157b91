"""The command line's entry: runs as `paradesc …`, `python -m paradesc …` and `blender -b FILE -P cli.py -- …`."""

import sys
from pathlib import Path

if __name__ == "__main__":  # Blender runs this as a script, and has to find the package of this file
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    from paradesc.commands.main import main
else:
    from .commands.main import main

__all__ = ["command", "main"]


def command() -> int:
    """The program `paradesc` that pip installs: this process's words → the exit code."""
    return main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []))
