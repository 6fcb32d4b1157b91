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

import numpy as np

from ..bridge import InputError
from ..core.members import Member
from . import file_names
from .paths import is_file, is_folder
from .results import write_whole

SUFFIX = ".json"
# The key that distinguishes a preset from other JSON, and the newest version of the format.
MARK, VERSION = "paradesc_preset", 1
SECTIONS = ("settings", "colors", "image")
LARGEST_FILE = 1_000_000  # bytes
LONGEST_NAME, LONGEST_PURPOSE, LONGEST_TEXT = 60, 500, 1000
LARGEST_NUMBER = 3.4e38  # 32-bit floats end just above
# A file name must leave room for its suffix and for the additions of a temporary file.
LONGEST_STEM = 100  # bytes


class PresetError(InputError):
    """The file cannot be used as a preset. The sentence names the file and the fault, and says what to do."""


Rules = dict[str, dict[str, Member]]  # by section, then by property


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


# ---- Reading


def read(path: Path) -> Content:
    """Reads a file and checks all that needs no rules; raises PresetError."""
    content = parsed(path, text_in(path))
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


def text_in(path: Path) -> str:
    """The text of a file, without a byte order mark; raises if it is larger than any preset."""
    try:
        if is_folder(path):
            refuse(path, "is a folder; choose a file in it")
        if not is_file(path):
            refuse(path, "is not there; choose another file")
        with path.open("rb") as file:
            found = file.read(LARGEST_FILE + 1)
    except PresetError:
        raise
    except (OSError, ValueError) as error:
        refuse(path, f"cannot be read: {getattr(error, 'strerror', None) or error}")
    if len(found) > LARGEST_FILE:
        refuse(path, f"is larger than {LARGEST_FILE // 1_000_000} MB, which no preset is; choose another file")
    try:
        return found.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        refuse(path, f"is no JSON in UTF-8 (byte {error.start + 1}); save it in that encoding")


def parsed(path: Path, text: str) -> object:
    """The JSON of a text. Numbers that are not finite, which Python reads as well, fit no rule."""
    try:
        return json.loads(text, object_pairs_hook=single)
    except json.JSONDecodeError as error:
        refuse(path, f"is not JSON in line {error.lineno}, column {error.colno} ({error.msg}); correct it")
    except RecursionError:
        refuse(path, "is nested too deeply; choose another file")
    except ValueError as error:
        refuse(path, f"has {error}; correct it")


def single(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """An object of JSON, in which no key comes twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"{quoted(twice)} twice")
    return found


def checked_line(path: Path, content: dict[str, object], key: str, longest: int) -> str:
    """A text of one line that can be shown."""
    text = content.get(key, "")
    if not isinstance(text, str) or not text.isprintable() or len(text) > longest:
        refuse(path, f'has a "{key}" that is not a line of at most {longest} characters; correct it')
    return text


def check(path: Path, content: Content, rules: Rules) -> None:
    """Raises PresetError about the first property that is unknown or has a value against its rule."""
    for section, members in content.sections().items():
        for name, value in members.items():
            rule = rules[section].get(name)
            if rule is None:
                refuse(path, f"has {quoted(name)} in {section}, which is not a setting; remove it or update the add-on")
            wanted = wanted_instead(rule, value)
            if wanted:
                refuse(path, f"has {quoted(value)} as {quoted(name)} in {section}; give {wanted}")


def wanted_instead(rule: Member, value: object) -> str:
    """The values that a property accepts, in words, if this value is not one of them; else ""."""
    if rule.kind == "bool":
        return "" if isinstance(value, bool) else "true or false"
    if rule.kind in ("int", "float"):
        return wanted_number(rule, value)
    if rule.kind == "text":
        sound = isinstance(value, str) and value.isprintable() and len(value) <= LONGEST_TEXT
        return "" if sound else f"a line of at most {LONGEST_TEXT} characters"
    several, names = rule.kind == "choices", [item[0] for item in rule.words["items"]]
    given = value if isinstance(value, list) else [value]
    sound = isinstance(value, list if several else str) and given and all(item in names for item in given)
    return "" if sound else f"{'a list of some' if several else 'one'} of {', '.join(names)}"


def wanted_number(rule: Member, value: object) -> str:
    """The numbers that a property accepts, in words, or "" for this value. Floats are compared as Blender's 32 bits."""
    is_whole = rule.kind == "int"
    low, high = (-(2**31), 2**31 - 1) if is_whole else (None, None)
    low, high = rule.words.get("min", low), rule.words.get("max", high)
    sound = isinstance(value, int if is_whole else (int, float)) and not isinstance(value, bool)
    if sound and abs(value) <= LARGEST_NUMBER:
        same = int if is_whole else np.float32
        if (low is None or same(low) <= same(value)) and (high is None or same(value) <= same(high)):
            return ""
    bounds = [f"{word} {end:.10g}" for word, end in (("from", low), ("to", high)) if end is not None]
    return " ".join(["a whole number" if is_whole else "a number", *bounds])


def completed(members: dict[str, object], rules: dict[str, Member]) -> dict[str, object]:
    """Every property of a section; those that the preset does not name have their defaults."""
    return {name: members.get(name, rule.default) for name, rule in rules.items()}


def as_kept(members: dict[str, object], rules: dict[str, Member]) -> dict[str, object]:
    """The values in Blender's form: floats in 32 bits, choices as sets."""
    kinds = {"float": lambda value: float(np.float32(value)), "choices": set}
    return {name: kinds.get(rules[name].kind, lambda value: value)(value) for name, value in members.items()}


def plain(value: object) -> object:
    """A value of Blender in JSON's form: floats with the fewest digits that give the same float, choices sorted."""
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    if isinstance(value, float) and abs(value) <= LARGEST_NUMBER:
        return float(str(np.float32(value)))
    return value


# ---- Writing


def write(path: Path, content: Content) -> None:
    """Writes a preset whole or not at all."""
    write_whole(path, content, lambda place, given: place.write_text(text_of(given), encoding="utf-8", newline="\n"))


def text_of(content: Content) -> str:
    """A preset as the text of its file."""
    about = {MARK: VERSION, "name": content.name, "purpose": content.purpose}
    return json.dumps({**about, **content.sections()}, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def file_stem(name: str) -> str:
    """The file name for a preset of this name that every system allows, without suffix."""
    words = re.sub(r"[^\w+-]+", "_", name).strip("_")
    stem = words.encode()[:LONGEST_STEM].decode(errors="ignore") or "preset"
    return f"{stem}_" if file_names.RESERVED.fullmatch(stem) else stem


def place_of(folder: Path, name: str) -> Path:
    """The path of a preset of this name in a folder: its existing file, else a new one."""
    stem = file_stem(name)
    taken = {file_names.folded(path.name) for path in folder.iterdir()}
    there = (folder / f"{one}{SUFFIX}" for one in file_names.numbered(stem))
    fits = (path for path in there if file_names.folded(path.name) not in taken or name_in(path) == name)
    return next(fits)


def name_in(path: Path) -> str | None:
    """The name of the preset in a file, or None if it cannot be read."""
    try:
        return read(path).name
    except PresetError:
        return None
