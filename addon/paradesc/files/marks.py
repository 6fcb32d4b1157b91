"""Marks PNG files with the bake they come from and with a digest that shows if they were changed since. No bpy."""

import hashlib
import json
import struct
from collections.abc import Iterator
from pathlib import Path

from .png import SIGNATURE, chunk

KIND, KEYWORD = b"tEXt", b"Paradesc\0"
Owner = dict[str, str]  # for example the .blend and the object


def marked(content: bytes, owner: Owner) -> bytes:
    """The PNG file with a text chunk for its owner before the pixels; an earlier mark is replaced."""
    found = mark_in(content)
    if found is not None:
        content = content[: found[0]] + content[found[1] :]
    place = next(start for kind, start, _ in beginning(content) if kind == b"IDAT")
    text = json.dumps({**owner, "digest": digest(content)}).encode("ascii")
    return content[:place] + chunk(KIND, KEYWORD + text) + content[place:]


def owner_of(content: bytes) -> Owner | None:
    """The owner in a PNG file's mark; None if there is no mark, or if anything else in the file changed since."""
    found = mark_in(content)
    if found is None:
        return None
    start, end = found
    try:
        owner = json.loads(content[start + 8 + len(KEYWORD) : end - 4])
        same = owner.pop("digest") == digest(content[:start] + content[end:])
    except (ValueError, KeyError, AttributeError, TypeError):
        return None
    return owner if same else None


def owner_of_file(path: Path) -> Owner | None:
    """The owner in the mark of the file at a path; None also if the file cannot be read."""
    try:
        return owner_of(path.read_bytes())
    except OSError:
        return None


def mark_in(content: bytes) -> tuple[int, int] | None:
    """The start and the end of the chunk with the mark; None without one."""
    for kind, start, end in beginning(content):
        if kind == KIND and content.startswith(KEYWORD, start + 8):
            return start, end
    return None


def beginning(content: bytes) -> Iterator[tuple[bytes, int, int]]:
    """The kind, start and end of each chunk up to the first one with pixels; none if the file is not a PNG."""
    start, kind = len(SIGNATURE), b""
    while content.startswith(SIGNATURE) and kind != b"IDAT" and start + 12 <= len(content):
        length, kind = struct.unpack_from(">I4s", content, start)
        yield kind, start, start + 12 + length
        start += 12 + length


def digest(content: bytes) -> str:
    """The beginning of the digest of a file."""
    return hashlib.sha256(content).hexdigest()[:32]
