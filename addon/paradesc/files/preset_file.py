"""Presets as JSON files: read, checked as a whole and written, but never executed. Never imports bpy.

A file is one object: paradesc_preset (the version of the format), name, purpose, and up to three sections, settings,
colors and image, each an object from the names of properties to their values. The caller of the reader supplies rules
that define the properties and their values.
"""

import json
import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import NoReturn

from ..bridge import InputError
from . import file_names
from .paths import is_file, is_folder
from .results import write_whole

SUFFIX = ".json"
# The key that distinguishes a preset from other JSON, and the newest version of the format.
MARK, VERSION = "paradesc_preset", 1
SECTIONS = ("settings", "colors", "image")
LARGEST_FILE = 1_000_000  # bytes
LONGEST_NAME, LONGEST_PURPOSE, LONGEST_TEXT = 60, 500, 1000
# A file name must leave room for its suffix and for the additions of a temporary file.
LONGEST_STEM = 100  # bytes


class PresetError(InputError):
    """The file cannot be used as a preset. The sentence names the file and the fault, and says what to do."""


@dataclass(frozen=True)
class Content:
    """The content of a preset. A section that is None is missing; its settings then stay as they are."""

    name: str
    purpose: str = ""
    settings: dict[str, object] | None = None
    colors: dict[str, object] | None = None
    image: dict[str, object] | None = None

    def sections(self) -> dict[str, dict[str, object]]:
        """The sections that are not missing."""
        found = {section: getattr(self, section) for section in SECTIONS}
        return {section: members for section, members in found.items() if members is not None}


def refuse(path: Path, what: str) -> NoReturn:
    """Raises an error about a file: what is wrong with it, and what to do."""
    raise PresetError(f"The preset file {quoted(str(path))} {what}.")


def quoted(value: object) -> str:
    """A text, or the beginning of another value's JSON, in a form that can be shown anywhere."""
    if isinstance(value, str):
        text = value if value.isprintable() else ascii(value)[1:-1]
        return f'"{text}"' if len(text) <= LONGEST_TEXT else f'"{text[:LONGEST_NAME]}…"'
    try:
        text = json.dumps(value)
    except RecursionError:
        return "a nested value"
    return text if len(text) <= LONGEST_NAME else text[: LONGEST_NAME - 1] + "…"


def read(path: Path) -> Content:
    """Reads a file and checks all that needs no rules; raises PresetError."""
    content = parsed(path)
    if not isinstance(content, dict) or MARK not in content:
        refuse(path, f'is not a preset of Paradesc, because "{MARK}" is missing; choose another file')
    version = content[MARK]
    if type(version) is not int or version < 1:
        refuse(path, f'has {quoted(version)} as "{MARK}", where the version {VERSION} belongs; correct it')
    if version > VERSION:
        refuse(path, f"is of version {version}, newer than the {VERSION} that this Paradesc reads; update the add-on")
    known = (MARK, *(field.name for field in fields(Content)))
    for key in content:
        if key not in known:
            refuse(path, f"has {quoted(key)}, which is unknown; remove it, or update the add-on")
    name = checked_line(path, content, "name", LONGEST_NAME)
    if not name.strip():
        refuse(path, 'has no "name"; give it one')
    purpose = checked_line(path, content, "purpose", LONGEST_PURPOSE)
    sections = {section: content[section] for section in SECTIONS if section in content}
    if not sections:
        refuse(path, f'sets nothing; add a section "{SECTIONS[0]}", or save the preset again')
    for section, members in sections.items():
        if not isinstance(members, dict):
            refuse(path, f'has a section "{section}" that is not an object; correct it')
    return Content(name.strip(), purpose, **sections)


def checked_line(path: Path, content: dict[str, object], key: str, longest: int) -> str:
    """A text of one line that can be shown."""
    text = content.get(key, "")
    if not isinstance(text, str) or not text.isprintable() or len(text) > longest:
        refuse(path, f'has a "{key}" that is not a line of at most {longest} characters; correct it')
    return text


def parsed(path: Path) -> object:
    """The JSON of a file. Numbers that are not finite, which Python reads as well, fit no rule."""
    if not is_file(path):
        refuse(path, f"is {'a folder; choose a file in it' if is_folder(path) else 'not there; choose another file'}")
    try:
        with path.open("rb") as file:
            found = file.read(LARGEST_FILE + 1)
        if len(found) > LARGEST_FILE:  # larger than any preset
            refuse(path, f"is larger than {LARGEST_FILE // 1_000_000} MB, which no preset is; choose another file")
        return json.loads(found.decode("utf-8-sig"), object_pairs_hook=single)
    except PresetError:
        raise
    except OSError as error:
        refuse(path, f"cannot be read: {error.strerror or error}")
    except UnicodeDecodeError as error:
        refuse(path, f"is no JSON in UTF-8 (byte {error.start + 1}); save it in that encoding")
    except json.JSONDecodeError as error:
        refuse(path, f"is not JSON in line {error.lineno}, column {error.colno} ({error.msg}); correct it")
    except RecursionError:
        refuse(path, "is nested too deeply; choose another file")
    except ValueError as error:
        refuse(path, f"has {error}; correct it")


def single(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """An object of JSON, in which no key comes twice."""
    found: dict[str, object] = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"{quoted(key)} twice")
        found[key] = value
    return found


def write(path: Path, content: Content) -> None:
    """Writes a preset whole or not at all."""
    about = {MARK: VERSION, "name": content.name, "purpose": content.purpose, **content.sections()}
    text = json.dumps(about, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_whole(path, text.encode(), Path.write_bytes)


def file_stem(name: str) -> str:
    """The file name for a preset of this name that every system allows, without suffix."""
    words = re.sub(r"[^\w+-]+", "_", name).strip("_")
    stem = words.encode()[:LONGEST_STEM].decode(errors="ignore") or "preset"
    return f"{stem}_" if file_names.RESERVED.fullmatch(stem) else stem


def place_of(folder: Path, name: str) -> Path:
    """The path of a preset of this name in a folder: its existing file, else a new one."""
    taken = {file_names.folded(path.name) for path in folder.iterdir()}
    there = (folder / f"{one}{SUFFIX}" for one in file_names.numbered(file_stem(name)))
    return next(path for path in there if file_names.folded(path.name) not in taken or name_in(path) == name)


def name_in(path: Path) -> str | None:
    """The name of the preset in a file, or None if it cannot be read."""
    try:
        return read(path).name
    except PresetError:
        return None
