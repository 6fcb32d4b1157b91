"""File names made from object names: short enough, and distinct on every file system. No bpy."""

import hashlib
import itertools
import re
import unicodedata
from collections.abc import Iterator

# Windows keeps these names for devices, whatever suffix follows.
RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)", re.IGNORECASE)
# File systems allow 255 bytes; suffixes, numbers of tiles and what stands around a name while it is written need room.
LONGEST = 120
# Characters that names keep, as a set of a regular expression: - and _, and letters and digits of every alphabet with
# their marks. All others up to Latin-1 are replaced, among them those that some file system refuses.
KEPT = r"\w\u0100-\U0010ffff-"


def folded(name: str) -> str:
    """A key that is equal for names that some file system takes for one: case and letters' composition are folded."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", name).casefold())


def plain(name: str) -> str:
    """The name with _ in place of each character that it does not keep."""
    return re.sub(f"[^{KEPT}]", "_", name)


def cut(name: str) -> str:
    """The name; a long name is cut, and its digest appended."""
    if len(name.encode()) <= LONGEST:
        return name
    return with_digest(name.encode()[: LONGEST - 9].decode(errors="ignore"), name)


def with_digest(beginning: str, name: str) -> str:
    """A beginning that several names may share, with the digest of this name."""
    return f"{beginning}_{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def folder_name(name: str, there: set[str]) -> str:
    """The name for an object's folder; with a digest where a file system would change it or take it for another's."""
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", name)[:80]
    alike = {one for one in there if folded(one) == folded(plain)}
    if plain == name and not RESERVED.fullmatch(name) and (name in alike or not alike):
        return plain
    return with_digest(plain, name)


def numbered(name: str) -> Iterator[str]:
    """The name, then the name with numbers appended."""
    return (name if number == 1 else f"{name}_{number}" for number in itertools.count(1))


def distinct(names: list[str]) -> list[str]:
    """The names, with numbers appended where some file system would take two for one."""
    taken: set[str] = set()
    found = []
    for name in names:
        found.append(next(one for one in numbered(cut(name)) if folded(one) not in taken))
        taken.add(folded(found[-1]))
    return found
