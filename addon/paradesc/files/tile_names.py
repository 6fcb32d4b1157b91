"""Turns the path of an image into the paths of its UDIM tiles, as Blender names them: x.png into x.1001.png. No bpy."""

import re
from pathlib import Path

from ..core import udim

TOKEN = "<UDIM>"
# The token with the mark that sets it apart from what comes before it.
SET_APART = re.compile(rf"[._-]?{TOKEN}")


def with_word(path: Path, word: str) -> Path:
    """The path with an underscore and a word appended to its name, before the tile's token and the suffix."""
    name, found = path.stem, SET_APART.search(path.stem)
    place = found.start() if found else len(name)
    return path.with_name(f"{name[:place]}_{word}{name[place:]}{path.suffix}")


def with_token(path: Path) -> Path:
    """The path with the token for a tile's number."""
    return path if TOKEN in path.name else path.with_name(f"{path.stem}.{TOKEN}{path.suffix}")


def of_tile(path: Path, tile: int | None) -> Path:
    """The path of a tile. With None, it is that of a single image, which may be asked for as the first tile."""
    if tile is None and TOKEN not in path.name:
        return path
    return path.with_name(with_token(path).name.replace(TOKEN, str(tile or udim.FIRST)))


def fault(path: Path) -> str:
    """One sentence about a path with a wrong token for tiles, or ""."""
    if TOKEN in str(path.parent):
        return f'{TOKEN} stands in a folder of "{path}"; it has to be in the name of the file.'
    if path.name.count(TOKEN) > 1:
        return f'{TOKEN} stands more than once in "{path.name}"; once is enough.'
    return ""
