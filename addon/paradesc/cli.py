"""The command line's entry: runs as `python -m paradesc …` and as `blender -b FILE -P cli.py -- …`."""

import sys
from pathlib import Path

if __name__ == "__main__":  # run by Blender as a script: find the package that this file lies in
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    from paradesc.commands.main import main
else:
    from .commands.main import main

__all__ = ["main"]

if __name__ == "__main__":
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []))
