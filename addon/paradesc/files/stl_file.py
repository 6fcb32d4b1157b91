"""Reads an .stl, binary or text, into a surface: its loose triangles, welded where they have a corner in common."""

import re
from pathlib import Path

import numpy as np

from ..bridge import origin
from ..core.polygons import PolygonMesh
from .text_rows import MARK, no_numbers, numbers_in, plain, shown

HEADER = 84  # bytes before the first triangle, the last four of which are their number
FIRST_BYTES = 1000  # in which a binary file has a zero
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
VERTEX = re.compile(rb"vertex\s+(\S+\s+\S+\s+\S+)")
FACET_END = re.compile(rb"end\s*facet")
ENDING = re.compile(rb"\bend\s*solid\b", re.IGNORECASE)


def read(path: Path) -> PolygonMesh:
    """The surface of all triangles; raises ValueError if the file is damaged."""
    content = path.read_bytes()
    notes: list[str] = []
    corners = text_corners(content, notes) if is_text(content) else binary_corners(content, notes)
    points, places = weld(corners)
    notes.append(
        f"An STL file holds loose triangles: the {len(corners):,} corners of {len(corners) // 3:,} were welded into "
        f"{len(points):,} vertices, where they are equal."
    )
    sizes = np.full(len(corners) // 3, 3, np.int64)
    return PolygonMesh(points, places.astype(np.int32), sizes, notes=notes if len(corners) else [])


def is_text(content: bytes) -> bool:
    """Returns whether a file is text: it begins with "solid", and contains nothing that only binary files do."""
    begins = content[:FIRST_BYTES].removeprefix(MARK).lstrip()[:5].lower() == b"solid"
    if not begins or b"\0" in content[:FIRST_BYTES]:
        return False
    return len(content) < HEADER or len(content) != HEADER + TRIANGLE.itemsize * count_of(content)


def count_of(content: bytes) -> int:
    """The number of triangles that a binary file says it has."""
    return int.from_bytes(content[HEADER - 4 : HEADER], "little")


def binary_corners(content: bytes, notes: list[str]) -> np.ndarray:
    """(3 n, 3) float32 corners of a binary file."""
    if len(content) < HEADER:
        raise ValueError("it is neither text nor long enough to be binary")
    promised, there = count_of(content), (len(content) - HEADER) // TRIANGLE.itemsize
    rest = content[HEADER + TRIANGLE.itemsize * promised :]
    if promised > there or (rest.strip(b"\0") and len(rest) % TRIANGLE.itemsize == 0):
        raise ValueError(f"it promises {promised:,} triangles and holds {there:,}; it was cut off, or damaged")
    if rest:
        notes.append(f"{len(rest):,} bytes after the {promised:,} triangles that the file promises were left out.")
    return np.frombuffer(content, TRIANGLE, promised, HEADER)["corners"].reshape(-1, 3)


def text_corners(content: bytes, notes: list[str]) -> np.ndarray:
    """(3 n, 3) corners of a text, whose words may stand on any lines."""
    text = plain(content.lower())
    if b"\n" in text.strip():  # a line that begins or ends a solid may hold any words in its name
        first, *others = text.split(b"solid")
        text = b"\n".join([first, *(other.partition(b"\n")[2] for other in others)])
    facets = text.count(b"facet") - len(FACET_END.findall(text))
    found = VERTEX.findall(text)
    if len(found) != 3 * facets:
        raise ValueError(
            f"its {facets:,} facets have {len(found):,} corners, and not three each; it was cut off, or damaged"
        )
    numbers = numbers_in(b" ".join(found))
    if numbers is None or len(numbers) != 3 * len(found):
        wrong = next((row for row in found if numbers_in(row) is None), b"")
        raise ValueError(f'the corner "{shown(wrong)}" {no_numbers(wrong)}')
    if facets and not ENDING.search(content[-1000:]):
        notes.append("The file does not say that it ends (endsolid); a part of it may be missing.")
    return origin.stored(numbers.reshape(-1, 3))


def weld(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The places of (n, 3) corners in order of first use, (k, 3), and which of them each corner is at, (n,)."""
    near = origin.near_origin(corners)
    _, first, group = np.unique(origin.place_keys(origin.columns_of(near)), return_index=True, return_inverse=True)
    if not np.array_equal(near[first][group], near):  # two places have one key, or are not finite
        _, first, group = np.unique(near, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(first), np.int64)
    rank[order] = np.arange(len(first))
    return corners[first[order]], rank[group.reshape(-1)]
