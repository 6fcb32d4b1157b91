"""Reads a .off, the text format of Geomview, into polygons of the file's own vertices. Never imports bpy.

A row is a line, except in files that have several vertices in a line or a face over several lines. The colors of faces,
and the normals, colors and texture coordinates of vertices, are left out.
"""

import re
from pathlib import Path

import numpy as np

from ..bridge import origin
from ..core.polygons import PolygonMesh, listed, vertices_at
from .text_rows import Rows, plain, rows_of

# The keyword, which may be missing, and may be followed by the numbers at once.
KEYWORD = re.compile(rb"\s*((?i:(?:ST)?C?)N?(4?)(n?)(?i:OFF))?(\s+BINARY\b)?")
COMMENT = re.compile(rb"#[^\n]*")


def read(path: Path) -> PolygonMesh:
    """The polygons; raises ValueError if the file is damaged or of a kind that has no surface in space."""
    content = COMMENT.sub(b"", plain(path.read_bytes()))
    keyword = KEYWORD.match(content)
    if keyword[2] or keyword[3]:
        raise ValueError(f"{keyword[1].decode()} has vertices in another space than three dimensions")
    if keyword[4]:
        raise ValueError("it is a binary OFF, which this reader does not know; save it as text")
    lines = [line for line in content[keyword.end() :].split(b"\n") if line.strip()]
    rows = rows_of(lines)
    counts = rows.values[:2]
    if len(counts) < 2 or not ((counts >= 0) & (counts < 2**31) & (counts == np.rint(counts))).all():
        raise ValueError("it does not begin with the numbers of its vertices and faces")
    after = 2 if rows.sizes[0] == 2 else 3  # the number of edges says nothing, and may be missing
    rest = Rows(rows.values, np.concatenate([[after], rows.starts[rows.starts > after]]))
    points, corners, sizes = tables(rest, int(counts[0]), int(counts[1]), (keyword[1] or b"").upper())
    return PolygonMesh(origin.stored(points), vertices_at(corners, len(points)).astype(np.int32), sizes)


def tables(rows: Rows, vertices: int, faces: int, keyword: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n, 3) points, (c,) corners and (m,) sizes, by the first way to read the rows that leaves nothing over."""
    width = 3 + 3 * (b"N" in keyword) + 4 * (b"C" in keyword) + 2 * keyword.startswith(b"ST")
    begin = int(rows.starts[0])
    if len(rows.values) - begin < 3 * vertices + faces:
        raise ValueError(f"it promises {vertices} vertices and {faces} faces, and holds too few numbers for them")
    ways = []
    if (rows.sizes[:vertices] >= 3).all() and len(rows.sizes) >= vertices:
        ways.append((Rows(rows.values, rows.starts[: vertices + 1]).first(3), int(rows.starts[vertices]), True))
    if len(rows.values) - begin >= width * vertices:
        of_words = rows.values[begin : begin + width * vertices].reshape(-1, width)[:, :3]
        ways += [(of_words, begin + width * vertices, colored) for colored in (True, False)]
    faults = []
    for points, at, colored in ways:
        try:
            return points, *faces_of(rows, at, faces, colored)
        except ValueError as error:
            faults.append(error)
    raise faults[0] if faults else ValueError(f"it ends before its {vertices} vertices")


def faces_of(rows: Rows, at: int, count: int, colored: bool) -> tuple[np.ndarray, np.ndarray]:
    """(c,) corners and (count,) sizes of the faces from this number on, to the end; colored: colors end their lines."""
    begins = rows.starts[np.searchsorted(rows.starts, at) : -1]
    sizes = rows.values[begins].astype(np.int64)
    ends = rows.starts[np.searchsorted(rows.starts, begins, side="right")]  # of the rows
    if not (colored and len(begins) == count and (sizes >= 0).all() and (begins + sizes < ends).all()):
        begins, sizes = walked(rows, at, count, colored)
    return rows.values[listed(begins + 1, sizes)], sizes


def walked(rows: Rows, at: int, count: int, colored: bool) -> tuple[np.ndarray, np.ndarray]:
    """Finds the start and size of each face, one after the other; raises unless there are exactly count faces."""
    begins, sizes, length = [], [], len(rows.values)
    for _ in range(count):
        size = int(rows.values[at]) if at < length and 0 <= rows.values[at] < length else -1
        if size < 0 or at + size >= length:
            raise ValueError(f"it promises {count} faces, and ends after {len(sizes)}")
        begins.append(at)
        sizes.append(size)
        at += 1 + size
        if colored:
            at = int(rows.starts[np.searchsorted(rows.starts, at)])
    if at < length:
        raise ValueError(f"more follows the {count} faces that it promises")
    return np.array(begins, np.int64), np.array(sizes, np.int64)
