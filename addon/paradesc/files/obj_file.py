"""Reads a Wavefront .obj into polygons that keep the file's own vertices, one mesh for each object of the file.

Other libraries split vertices that have several texture coordinates, but results belong to the file's vertices.
Values at vertices need no texture coordinates and no normals: damaged ones are left out, and a note says so.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..bridge import origin
from ..core.polygons import PolygonMesh
from .text_rows import first_fault, is_numeric, no_numbers, plain, rows_of, shown

SIGNS = b"0123456789+-"
# A backslash continues a line, but no comment, which may end with the path of a folder.
COMMENT_WITH_BACKSLASH = re.compile(rb"#[^\n]*\\(?=\n)")


@dataclass
class Lines:
    """The lines of a file, grouped by their first word, and the places where its objects begin."""

    vertices: list[bytes] = field(default_factory=list)
    uvs: list[bytes] = field(default_factory=list)
    normals: list[bytes] = field(default_factory=list)
    faces: list[bytes] = field(default_factory=list)
    objects: list[tuple[str, int, int]] = field(default_factory=lambda: [("", 0, 0)])  # name, vertices, faces before

    @property
    def counts(self) -> tuple[int, int, int]:
        """The numbers of vertices, texture vertices and normals so far."""
        return len(self.vertices), len(self.uvs), len(self.normals)


class LineError(Exception):
    """The fault of a line, which is given by its first word and its index among lines with that word."""

    def __init__(self, word: bytes, place: int, why: str) -> None:
        self.word, self.place, self.why = word, int(place), why


def read(path: Path) -> list[PolygonMesh]:
    """The objects with faces, each with its name, "" where it has none; raises ValueError if the file is damaged."""
    found = lines_of(text_of(path).replace(b"\\\n", b" ").replace(b"\t", b" "))
    if not found.faces:
        return []
    try:
        points = positions(found.vertices)
        corners, sizes = corners_of(found.faces)
        check_vertices(corners[:, 0], sizes, len(points))
    except LineError as error:
        number, line = line_at(text_of(path), error.word, error.place)
        raise ValueError(f'line {number}, "{shown(line)}", {error.why}') from None
    notes: list[str] = []
    uvs = texture_vertices(found.uvs, corners[:, 1], notes)
    normals = normals_of(found.normals, corners[:, 2], notes)
    return [polygons(name, part, uvs, normals, notes) for name, part in parts(found, points, corners - 1, sizes)]


def text_of(path: Path) -> bytes:
    """The text of a file, in which every backslash at the end of a line continues it."""
    return COMMENT_WITH_BACKSLASH.sub(b"", plain(path.read_bytes()))


def lines_of(content: bytes) -> Lines:
    """Sorts the lines. Lines that draw nothing are dropped; faces with negative numbers get positive ones."""
    found = Lines()
    by_word = {b"v": found.vertices, b"vt": found.uvs, b"vn": found.normals, b"f": found.faces}
    for line in content.split(b"\n"):
        word, _, rest = line.partition(b" ")
        if not word:
            word, _, rest = line.strip().partition(b" ")
        rows = by_word.get(word)
        if rows is not None:
            if b"#" in rest:
                rest = rest.partition(b"#")[0]
            rows.append(counted_from_one(rest, found.counts) if word == b"f" and b"-" in rest else rest)
        elif word == b"o":
            name = rest.strip().decode("utf-8", "replace")
            found.objects.append((name, len(found.vertices), len(found.faces)))
    return found


def counted_from_one(face: bytes, counts: tuple[int, int, int]) -> bytes:
    """The face with positive numbers, where -1 was the last one so far. Numbers before the first stay negative."""

    def counted(part: bytes, count: int) -> bytes:
        if not part.startswith(b"-") or not part[1:].isdigit() or not 0 < int(part[1:]) <= count:
            return part
        return b"%d" % (count + 1 - int(part[1:]))

    corners = (zip(corner.split(b"/"), (*counts, 0), strict=False) for corner in face.split())
    return b" ".join(b"/".join(counted(part, count) for part, count in corner) for corner in corners)


def line_at(content: bytes, word: bytes, place: int) -> tuple[int, bytes]:
    """The number, from 1, and the text of a line, given by its index among the lines with this first word."""
    number = 1
    for line in content.replace(b"\\\n", b"\\").split(b"\n"):  # a backslash ends no line
        if line.replace(b"\\", b" ").split(None, 1)[:1] == [word]:
            if place == 0:
                break
            place -= 1
        number += 1 + line.count(b"\\")
    return number, line.replace(b"\\", b" ")


def positions(lines: list[bytes]) -> np.ndarray:
    """(n, 3) positions of lines of numbers; further numbers (weights, colors) are ignored."""
    try:
        rows = rows_of(lines)
    except ValueError:
        place = first_fault(lines)
        raise LineError(b"v", place, no_numbers(lines[place])) from None
    if len(lines) and rows.sizes.min() < 3:
        raise LineError(b"v", rows.sizes.argmin(), "has fewer than 3 numbers")
    return origin.stored(rows.first(3))


def corners_of(faces: list[bytes]) -> tuple[np.ndarray, np.ndarray]:
    """(corner_count, 3) int64 vertex, texture vertex and normal, from 1, 0 for none, and (face_count,) sizes."""
    text = b"\n".join(faces).replace(b"//", b"/0/")
    if b"/ " in text or b"/\n" in text or text.endswith(b"/"):
        text = (text + b"\n").replace(b"/ ", b"/0 ").replace(b"/\n", b"/0\n")[:-1]
    rows = text.split(b"\n")
    sizes = np.fromiter((len(row.split()) for row in rows), np.int64, len(rows))
    marks = text.translate(None, SIGNS).split(b"\n")  # the slashes at each corner: few kinds of rows
    kinds = {mark: mark.split() for mark in set(marks)}
    form = np.fromiter((len(kinds[mark][0]) if kinds[mark] else 0 for mark in marks), np.int64, len(marks))
    marked = np.fromiter((len(kinds[mark]) for mark in marks), np.int64, len(marks))
    alike = np.fromiter((len(set(kinds[mark])) < 2 for mark in marks), bool, len(marks))
    for place in np.flatnonzero(~alike | (form > 2) | ((marked != sizes) & (marked > 0))):
        rows[place], form[place] = of_three(rows[place]), 2
    corners = np.zeros((int(sizes.sum()), 3), np.int64)
    for kind in np.unique(form):
        places = np.flatnonzero(form == kind)
        own = [rows[place].replace(b"/", b" ") for place in places]
        where = np.flatnonzero(np.repeat(form == kind, sizes))
        try:
            numbers = rows_of(own, np.int64)
            corners[where, : kind + 1] = numbers.values.reshape(len(where), kind + 1)
        except ValueError:
            raise LineError(b"f", places[first_fault(own, np.int64)], "is not a face") from None
    return corners, sizes


def of_three(face: bytes) -> bytes:
    """A face whose corners have different forms, with three numbers for each corner; 0 means none."""
    parts = [[*corner.split(b"/"), b"0", b"0"][:3] if corner.count(b"/") < 3 else [b"?"] for corner in face.split()]
    return b" ".join(b"/".join(part or b"0" for part in corner) for corner in parts)


def check_vertices(vertices: np.ndarray, sizes: np.ndarray, count: int) -> None:
    """Refuses corners (n,), counted from 1, of vertices that are not there."""
    wrong = (vertices < 1) | (vertices > count)
    if wrong.any():
        corner = int(wrong.argmax())
        face = np.searchsorted(np.cumsum(sizes), corner, side="right")
        raise LineError(b"f", face, f"names vertex {vertices[corner]}, and there are {count}, counted from 1")


def texture_vertices(lines: list[bytes], corners: np.ndarray, notes: list[str]) -> np.ndarray | None:
    """(n + 1, 2) float32 texture coordinates, of which the last are no numbers and stand for those that are not there.

    corners (n,) are given those numbers. A map with coordinates that are no numbers counts as none.
    """
    missing = (corners < 0) | (corners > len(lines))
    if not lines:
        corners[missing] = 0
        if missing.any():
            notes.append("The file has no texture coordinates, which its faces name; they were left out.")
        return None
    try:
        rows = rows_of(lines)
    except ValueError:
        rows = rows_of([line if is_numeric(line) else b"nan nan" for line in lines])
    values = np.append(rows.values, [np.nan, np.nan])
    second = np.where(rows.sizes > 1, values[rows.starts[:-1] + 1], 0.0)  # vt u alone is on the line v = 0
    first = np.where(rows.sizes > 0, values[rows.starts[:-1]], np.nan)
    corners[missing] = len(lines) + 1
    return np.append(np.column_stack([first, second]), [[np.nan, np.nan]], axis=0).astype(np.float32)


def normals_of(lines: list[bytes], corners: np.ndarray, notes: list[str]) -> np.ndarray | None:
    """(n, 3) float32 normals; None, with a note, if they are damaged or if corners (n,) name missing ones."""
    missing = (corners < 0) | (corners > len(lines))
    try:
        rows = rows_of(lines)
        sound = len(lines) == 0 or rows.sizes.min() >= 3
    except ValueError:
        sound = False
    if missing.any() or not sound:
        why = "its faces name normals that it lacks" if missing.any() else "some are no three numbers"
        notes.append(f"The file's normals were left out: {why}.")
        return None
    return rows.first(3).astype(np.float32) if lines else None


def parts(
    found: Lines, positions: np.ndarray, corners: np.ndarray, sizes: np.ndarray
) -> Iterator[tuple[str, tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """Each object's name with its positions, its corners (n, 3) in these, and the sizes of its faces.

    An object has the vertices that its faces use and those in its part of the file that no other object uses, in the
    file's order. The only object with faces has all.
    """
    ends = [*found.objects[1:], ("", len(positions), len(sizes))]
    spans = [
        (name, begin, end, first, last)
        for (name, begin, first), (_, end, last) in zip(found.objects, ends, strict=True)
        if last > first
    ]
    if len(spans) == 1:
        yield spans[0][0], (positions, corners, sizes)
        return
    used = np.zeros(len(positions), bool)
    used[corners[:, 0]] = True
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    for name, begin, end, first, last in spans:
        own = corners[offsets[first] : offsets[last]].copy()
        mine = np.zeros(len(positions), bool)
        mine[begin:end] = ~used[begin:end]
        mine[own[:, 0]] = True
        own[:, 0] = (np.cumsum(mine) - 1)[own[:, 0]]
        yield name, (positions[mine], own, sizes[first:last])


def polygons(
    name: str,
    part: tuple[np.ndarray, np.ndarray, np.ndarray],
    uvs: np.ndarray | None,
    normals: np.ndarray | None,
    notes: list[str],
) -> PolygonMesh:
    """The polygons of an object; corners without a texture vertex lie at 0. Normals count if all corners have one."""
    positions, corners, sizes = part
    mesh = PolygonMesh(positions, corners[:, 0].astype(np.int32), sizes, notes=list(notes), name=name)
    if uvs is not None and (corners[:, 1] >= 0).any():
        mesh.corner_uvs = np.where(corners[:, 1:2] >= 0, uvs[corners[:, 1]], np.float32(0))
    if normals is not None and len(corners) and (corners[:, 2] >= 0).all():
        mesh.corner_normals = normals[corners[:, 2]]
    return mesh
