"""Reads VTK's legacy format, .vtk, text or binary, into polygons of the file's own points. Never imports bpy.

Strips become triangles. Loose points, lines, and the values of points and of cells are left out.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..bridge import origin
from ..core.polygons import PolygonMesh, Polygons, listed_polygons, triangles_of, vertices_at
from .text_rows import numbers_in, plain, shown

BEGIN = re.compile(
    rb"#\s*vtk\s+DataFile\s+Version\s+\d+(?:\.\d+)?[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)[ \t]*\r?\n", re.IGNORECASE
)
KINDS = {
    b"bit": "u1", b"unsigned_char": "u1", b"char": "i1", b"unsigned_short": "u2", b"short": "i2", b"unsigned_int": "u4",
    b"int": "i4", b"unsigned_long": "u8", b"long": "i8", b"vtktypeint64": "i8", b"vtkidtype": "i4", b"float": "f4",
    b"double": "f8",
}  # fmt: skip
FACES, STRIPS = b"POLYGONS", b"TRIANGLE_STRIPS"
CELLS = (FACES, STRIPS, b"VERTICES", b"LINES")
VALUES = (b"POINT_DATA", b"CELL_DATA")
# In text, an array ends at a line that begins with a word, other than the words for missing numbers.
WORD = re.compile(rb"^[ \t]*(?!nan\b|inf\b|infinity\b)[A-Za-z_]", re.MULTILINE | re.IGNORECASE)


@dataclass
class Content:
    """A reading position in a file."""

    body: bytes
    at: int
    is_text: bool

    def words(self) -> list[bytes]:
        """The words of the next line that is not empty; none at the end."""
        while self.at < len(self.body):
            end = self.body.find(b"\n", self.at)
            end = len(self.body) if end < 0 else end
            line, self.at = self.body[self.at : end], end + 1
            if line.strip():
                return line.split()
        return []

    def numbers(self, kind: bytes, count: int) -> np.ndarray:
        """(count,) numbers of one of VTK's types, which follow."""
        if kind.lower() not in KINDS:
            raise ValueError(f'it has numbers of the type "{shown(kind)}", which this reader does not know')
        number = np.dtype(">" + KINDS[kind.lower()])
        if self.is_text:
            found = WORD.search(self.body, self.at)
            text = self.body[self.at : found.start() if found else len(self.body)]
            self.at += len(text)
            values = numbers_in(text, np.float64 if number.kind == "f" else np.int64)
            if values is None or len(values) != count:
                raise ValueError(f"it promises {count:,} numbers where it has others; it was cut off, or damaged")
            return values
        size = -(-count // 8) if kind.lower() == b"bit" else count * number.itemsize
        if self.at + size > len(self.body):
            raise ValueError(f"it promises {count:,} numbers and ends before them; it was cut off")
        self.at += size
        return np.frombuffer(self.body, number, size // number.itemsize, self.at - size)


def read(path: Path) -> PolygonMesh | None:
    """The polygons, None without any; raises ValueError if the file is damaged or holds something else."""
    content = path.read_bytes()
    begin = BEGIN.match(content)
    if begin is None:
        raise ValueError("it does not begin as a file of VTK's legacy format")
    is_text = begin[1].upper() == b"ASCII"
    file = Content(plain(content), 0, True) if is_text else Content(content, begin.end(), False)
    if is_text:
        file.at = BEGIN.match(file.body).end()
    points, cells = parts(file)
    faces = [cells[FACES]] if FACES in cells else []
    faces += [triangles_of(cells[STRIPS].corner_vertices, cells[STRIPS].sizes)] if STRIPS in cells else []
    if points is None or not faces:
        return None
    corners = vertices_at(np.concatenate([one.corner_vertices for one in faces]), len(points))
    sizes = np.concatenate([one.sizes for one in faces])
    return PolygonMesh(origin.stored(points), corners.astype(np.int32), sizes)


def parts(file: Content) -> tuple[np.ndarray | None, dict[bytes, Polygons]]:
    """(n, 3) float64 points, and the cells by their keyword, as far as the values of either."""
    points, cells = None, {}
    while words := file.words():
        keyword = words[0].upper()
        if keyword in VALUES:
            break
        try:
            if keyword == b"DATASET":
                kind = words[1]
                if kind.upper() != b"POLYDATA":  # of a grid only VTK itself knows the surface
                    said = f"it holds a {shown(kind).upper()}, and no surface (POLYDATA)"
                    raise ValueError(f"{said}; extract its surface and save that")
            elif keyword == b"METADATA":
                pass_metadata(file)
            elif keyword == b"FIELD":
                pass_field(file, count_of(words[2]))
            elif keyword == b"POINTS":
                points = file.numbers(words[2], 3 * count_of(words[1])).astype(np.float64).reshape(-1, 3)
            elif keyword in CELLS:
                cells[keyword] = cells_of(file, count_of(words[1]), count_of(words[2]))
            else:
                raise ValueError(f'it has "{shown(b" ".join(words))}" where points or polygons should begin')
        except IndexError:
            raise ValueError(f'its line "{shown(b" ".join(words))}" is not complete') from None
    return points, cells


def count_of(word: bytes) -> int:
    """A number of points, cells or numbers."""
    if not word.isdigit() or len(word) > 12:
        raise ValueError(f'it has "{shown(word)}" where a number of points or polygons should be')
    return int(word)


def pass_metadata(file: Content) -> None:
    """Skips VTK's metadata about an array, which ends at an empty line."""
    ends = [end + 2 for mark in (b"\n\n", b"\n\r") if (end := file.body.find(mark, file.at - 1)) >= 0]
    file.at = min(ends, default=len(file.body))


def pass_field(file: Content, arrays: int) -> None:
    """Skips arrays that belong to the file as a whole."""
    for _ in range(arrays):
        words = file.words()
        if words and words[0].upper() == b"METADATA":
            pass_metadata(file)
            words = file.words()
        if not words:
            raise ValueError("it ends within a field")
        file.numbers(words[3], count_of(words[1]) * count_of(words[2]))


def cells_of(file: Content, one: int, other: int) -> Polygons:
    """The cells in either way of VTK: the size before each, or, since version 5, a table of where each begins."""
    before = file.at
    words = file.words()
    if words and words[0].upper() == b"OFFSETS":
        starts = file.numbers(words[1], one).astype(np.int64)
        words = file.words()
        if not words or words[0].upper() != b"CONNECTIVITY":
            raise ValueError("its polygons have no CONNECTIVITY")
        return Polygons(file.numbers(words[1], other), sizes_between(starts, other))
    file.at = before
    found = listed_polygons(file.numbers(b"int", other).astype(np.int64))
    if found is None or len(found.sizes) != one:
        raise ValueError(f"it promises {one:,} polygons and has another number; it was cut off, or damaged")
    return found


def sizes_between(starts: np.ndarray, total: int) -> np.ndarray:
    """(m,) sizes of the cells that begin at (m + 1,) places, the last of which is the end of all."""
    sizes = np.diff(starts)
    if len(starts) and (starts[0] != 0 or starts[-1] != total or (sizes < 0).any()):
        raise ValueError("its polygons do not follow each other; it is damaged")
    return sizes
