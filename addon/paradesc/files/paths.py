"""Checks paths. A name that is too long, or has forbidden characters, counts as missing and raises no error."""

# ruff: noqa: PTH112, PTH113 (what pathlib asks in their place raises for such names)

import os
from pathlib import Path


def is_file(path: Path) -> bool:
    """Returns whether there is a file."""
    return os.path.isfile(path)


def is_folder(path: Path) -> bool:
    """Returns whether there is a folder."""
    return os.path.isdir(path)
