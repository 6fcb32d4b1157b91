"""Finds the files of an animation that is a sequence of mesh files, and their frames by the numbers in their names."""

import fnmatch
import re
from pathlib import Path

from ..bridge import InputError
from . import mesh_files
from .paths import is_file, is_folder

NUMBER = re.compile(r"(\d+)\D*$")
HASHES = re.compile(r"#+")
HOW = "mesh_####.ply"
WILD = re.compile(r"[*?\[]")


def is_sequence(given: Path) -> bool:
    """Returns whether a path stands for several files: a folder, or a pattern with # or * that is not itself a file."""
    return is_folder(given) or (bool(HASHES.search(given.name) or WILD.search(given.name)) and not is_file(given))


def frames_of(given: Path) -> dict[int, Path]:
    """The files of a sequence by frame, which is the number in place of #### or the last one in the name."""
    folder = given if is_folder(given) else given.parent
    pattern, number = patterns(given)
    if not is_folder(folder):
        raise InputError(f'There is no folder "{folder}".')
    found: dict[int, Path] = {}
    for path in sorted(folder.iterdir()):
        where = number.search(path.stem) if pattern.fullmatch(path.name) else None
        if where is None or path.suffix.lower() not in mesh_files.SUFFIXES:
            continue
        frame = int(where[1])
        if frame in found:
            both = f'"{found[frame].name}" and "{path.name}"'
            raise InputError(f"{both} are both frame {frame}; say by #### where the number is, for example {HOW}.")
        found[frame] = path
    if not found:
        known = ", ".join(mesh_files.SUFFIXES)
        raise InputError(f'No file of "{given}" has a number in its name and is one of {known}.')
    return dict(sorted(found.items()))


def patterns(given: Path) -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Two patterns: for the names of a sequence's files, and for the frame number in their stems."""
    if is_folder(given):
        return re.compile(".*"), NUMBER
    hashes = HASHES.search(given.name)
    if hashes is None:
        return re.compile(fnmatch.translate(given.name)), NUMBER
    before, after = (re.escape(part) for part in (given.name[: hashes.start()], given.name[hashes.end() :]))
    digits = rf"\d{{{len(hashes[0])},}}"
    return re.compile(before + digits + after), re.compile(f"{before}({digits})")


def name_of(given: Path, first: Path) -> str:
    """The name of a sequence: the common name of its files without the number, or the name of its folder."""
    stem = NUMBER.sub("", first.stem).rstrip("_-. ")
    return stem or (given if is_folder(given) else given.parent).absolute().name or "mesh"
