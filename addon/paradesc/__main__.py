"""python -m paradesc"""

import sys

from .cli import command

if __name__ == "__main__":
    sys.exit(command())
