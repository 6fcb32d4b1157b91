"""Marks PNG files with whose bake they are and a digest, which tells whether they are as we left them. No bpy."""

import hashlib
import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from .png import SIGNATURE, chunk
from .png_reading import chunks

KIND, KEYWORD = b"tEXt", b"Paradesc\0"
Owner = dict[str, str]  # for example the .blend and the object


def marked(content: bytes, owner: Owner) -> bytes:
    """A PNG file with a text that says whose it is, before its pixels; an earlier mark goes."""
    found = mark_in(content)
    if found is not None:
        content = content[: found[0]] + content[found[1] :]
    place = next(start for kind, start, _ in beginning(content) if kind == b"IDAT")
    text = json.dumps({**owner, "digest": digest(content)}).encode("ascii")
    return content[:place] + chunk(KIND, KEYWORD + text) + content[place:]


def owner_of(content: bytes) -> Owner | None:
    """Whose bake a PNG file is; None where it has no mark, or anything else in it has changed since it got that."""
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
    """The same of a file; None where it cannot be read, too."""
    try:
        return owner_of(path.read_bytes())
    except OSError:
        return None


def mark_in(content: bytes) -> tuple[int, int] | None:
    """Where the chunk with the mark begins and ends."""
    for kind, start, end in beginning(content):
        if kind == KIND and content.startswith(KEYWORD, start + 8):
            return start, end
    return None


def beginning(content: bytes) -> Iterator[tuple[bytes, int, int]]:
    """The kind, the start and the end of the chunks up to the first one with pixels; none of what is no PNG."""
    start = len(SIGNATURE)
    with suppress(ValueError):
        for kind, body in chunks(content):
            end = start + 12 + len(body)
            yield kind, start, end
            if kind == b"IDAT":
                return
            start = end


def digest(content: bytes) -> str:
    """The beginning of the digest of a file."""
    return hashlib.sha256(content).hexdigest()[:32]
