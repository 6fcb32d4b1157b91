"""Finds preset files: in Blender's preset folders, and in the folder that the add-on's preferences name."""

import os
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import bpy

from paradesc.bridge import ParadescError
from paradesc.files import preset_file, preset_rules

from . import preferences

SUBFOLDER = "paradesc"
# A folder with more files than this is not meant for presets only, and takes long to read.
MOST_FILES = 200


@dataclass(frozen=True)
class Row:
    """A preset file as the menu lists it."""

    path: Path
    name: str
    purpose: str = ""
    fault: str = ""  # the reason why it cannot be used, or ""


def own_folder(create: bool = False) -> Path | None:
    """The folder of the user's own presets; None if it does not exist."""
    found = bpy.utils.user_resource("SCRIPTS", path=f"presets/{SUBFOLDER}", create=create)
    return Path(found) if found else None


def shared_folders() -> list[Path]:
    """The folders of shared presets: those on Blender's other script paths, and the one that the preferences name."""
    found = [Path(path) for path in bpy.utils.preset_paths(SUBFOLDER)]
    chosen = preferences.presets_folder()
    found += [chosen] if chosen else []
    own = own_folder()
    return [path for path in dict.fromkeys(found) if own is None or not same_place(path, own)]


def same_place(first: Path, second: Path) -> bool:
    """Returns whether two paths are one folder."""
    return os.path.normcase(os.path.abspath(first)) == os.path.normcase(os.path.abspath(second))  # noqa: PTH100


def rows_in(folder: Path | None) -> list[Row]:
    """The presets in a folder by name, none if it cannot be read. A file is read again only if it has changed."""
    found = []
    with suppress(OSError), os.scandir(folder or "") as entries:
        for entry in entries:
            name = entry.name
            # Blender's properties cannot hold paths that are not valid text. Hidden files are not meant for people.
            if Path(name).suffix.lower() == preset_file.SUFFIX and name.isprintable() and not name.startswith("."):
                with suppress(OSError):
                    about = entry.stat()
                    found.append((folder / name, about.st_mtime_ns, about.st_size))
    return sorted((row_of(*one) for one in sorted(found)[:MOST_FILES]), key=lambda row: row.name.casefold())


@lru_cache(maxsize=16 * MOST_FILES)
def row_of(path: Path, _time: int, _size: int) -> Row:
    """A preset file as the menu lists it; a file that cannot be used has its file name."""
    try:
        content = preset_rules.sound(path)
    except ParadescError as error:
        return Row(path, path.name, fault=error.sentence)
    return Row(path, content.name, content.purpose)


def every_row() -> list[Row]:
    """The presets of all folders, the user's own first."""
    return [row for folder in (own_folder(), *shared_folders()) for row in rows_in(folder)]
