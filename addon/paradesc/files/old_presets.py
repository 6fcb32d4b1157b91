"""Presets of earlier versions, which Blender wrote as Python: read line by line, never executed. Never imports bpy."""

import ast
import itertools
import re
from collections.abc import Callable
from pathlib import Path

from .preset_file import (
    LONGEST_NAME,
    Content,
    PresetError,
    candidates,
    file_stem,
    plain,
    quoted,
    read,
    refuse,
    text_in,
    write,
)
from .preset_file import SUFFIX as JSON_SUFFIX

SUFFIX = ".py"
# The suffixes of all files that may be presets.
SUFFIXES = (JSON_SUFFIX, SUFFIX)
# The suffix added to the name of an old file once its settings are in a JSON file.
ASIDE = ".converted"
# The lines that every such file begins with.
BEGINNING = ("import bpy", "paradesc = bpy.context.scene.paradesc")
ASSIGNMENT = re.compile(r"paradesc\.([a-z_]+)\s*=\s*(.+)")
# The length limit of a line: more than Blender ever wrote, and short enough for the parser of every Python version.
LONGEST_LINE = 2000


def read_old(path: Path) -> Content:
    """The settings in such a file; raises PresetError if a line is anything but the assignment of a literal."""
    members: dict[str, object] = {}
    for number, raw in enumerate(text_in(path, "Python").splitlines(), 1):
        line = raw.strip()
        if not line or line.startswith("#") or line in BEGINNING:
            continue
        found = ASSIGNMENT.fullmatch(line) if len(line) <= LONGEST_LINE else None
        if found is None:
            refuse(path, f"does more in line {number} than set a setting, and is not executed; save the preset again")
        members[found[1]] = plain(literal(path, number, found[2]))
    if not members:
        refuse(path, "sets nothing; save the preset again")
    name = path.stem.replace("_", " ").strip()[:LONGEST_NAME]
    return Content(name if name.isprintable() and name else "Preset", settings=members)


def literal(path: Path, number: int, words: str) -> object:
    """A truth value, number, text or set of texts."""
    try:
        value = ast.literal_eval(words)
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        value = None
    if isinstance(value, set) and all(isinstance(item, str) for item in value):
        return value
    if not isinstance(value, (bool, int, float, str)):
        refuse(path, f"has {quoted(words)} in line {number}, which is no plain value; save the preset again")
    return value


def read_any(path: Path) -> Content:
    """Reads a preset of the present or an earlier format, depending on the file's suffix."""
    return read_old(path) if path.suffix.lower() == SUFFIX else read(path)


def convert(path: Path, check: Callable[[Path, Content], None]) -> Path:
    """Writes an old preset as JSON beside it, and puts the old file aside; raises if it cannot be used or written.

    Of several programs that do so at once, the others find what the first one wrote.
    """
    content = read_old(path)
    check(path, content)
    for place in candidates(path.parent, file_stem(path.stem)):
        if not place.exists():
            write(place, content)
            break
        if same(place, content):
            break
    try:
        path.replace(aside(path))
    except OSError as error:
        if path.exists():
            refuse(path, f"cannot be put aside ({error.strerror or error}); make its folder writable")
    return place


def aside(path: Path) -> Path:
    """A free name beside a file, under which it no longer appears in lists of presets."""
    names = (f"{path.name}{ASIDE}{number or ''}" for number in itertools.count())
    return next(place for place in map(path.with_name, names) if not place.exists())


def same(path: Path, content: Content) -> bool:
    """Whether a file contains exactly these settings."""
    try:
        return read(path) == content
    except PresetError:
        return False
