"""Reads a Wavefront .obj into polygons that keep the file's own vertices, one mesh for each object of the file.

Libraries for this format divide vertices where texture coordinates part, and results belong to the file's vertices.
"""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..core.polygons import PolygonMesh

REFERENCES = ("vertex", "texture vertex", "normal")


@dataclass
class Lines:
    """The lines of a file by what they say, and where its objects begin."""

    vertices: list[bytes] = field(default_factory=list)
    uvs: list[bytes] = field(default_factory=list)
    normals: list[bytes] = field(default_factory=list)
    faces: list[bytes] = field(default_factory=list)
    objects: list[tuple[str, int, int]] = field(default_factory=lambda: [("", 0, 0)])  # name, vertices, faces before

    @property
    def counts(self) -> tuple[int, int, int]:
        """How many vertices, texture vertices and normals there are so far."""
        return len(self.vertices), len(self.uvs), len(self.normals)


def read(path: Path) -> list[tuple[str, PolygonMesh]]:
    """The objects with faces, each with its name, "" where it has none; raises ValueError if the file is damaged."""
    content = (
        path.read_bytes().replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b" ").replace(b"\t", b" ")
    )
    found = lines_of(content)
    del content
    if not found.faces:
        return []
    positions = table(found.vertices, 3)
    uvs = table(found.uvs, 2) if found.uvs else None
    normals = table(found.normals, 3) if found.normals else None
    corners, sizes = corners_of(found.faces, found.counts)
    return [(name, polygons(part, uvs, normals)) for name, part in parts(found, positions, corners, sizes)]


def lines_of(content: bytes) -> Lines:
    """Sorts the lines; what draws nothing is left out, and faces that count backwards are made to count from 1."""
    found = Lines()
    by_word = {b"v": found.vertices, b"vt": found.uvs, b"vn": found.normals, b"f": found.faces}
    for line in content.split(b"\n"):
        if b"#" in line:
            line = line.partition(b"#")[0]
        word, _, rest = line.partition(b" ")
        if not word:
            word, _, rest = line.strip().partition(b" ")
        rows = by_word.get(word)
        if rows is not None:
            rows.append(counted_from_one(rest, found.counts) if word == b"f" and b"-" in rest else rest)
        elif word == b"o":
            name = rest.strip().decode("utf-8", "replace")
            found.objects.append((name, len(found.vertices), len(found.faces)))
    return found


def counted_from_one(face: bytes, counts: tuple[int, int, int]) -> bytes:
    """The same face with positive numbers; -1 is the last one so far."""
    return b" ".join(
        b"/".join(
            b"%d" % (int(part) + count + 1) if part.startswith(b"-") else part
            for part, count in zip(corner.split(b"/"), counts, strict=False)
        )
        for corner in face.split()
    )


def table(lines: list[bytes], width: int) -> np.ndarray:
    """(n, width) float32 of lines of numbers; what follows these (weights, colors) is left out."""
    widths = np.fromiter((len(line.split()) for line in lines), np.int64, len(lines))
    if (widths < width).any():
        raise ValueError(f'"{text_of(lines[int(np.argmax(widths < width))])}" has fewer than {width} numbers')
    if (widths != widths[0]).any():
        lines = [b" ".join(line.split()[:width]) for line in lines]
        widths[0] = width
    return rows_of(lines, np.float64, len(lines), int(widths[0]))[:, :width].astype(np.float32)


def rows_of(lines: list[bytes], kind: type, count: int, width: int) -> np.ndarray:
    """(count, width) numbers of this type; a line may have several rows."""
    found = numbers_in(b" ".join(lines), kind)
    if found is None or len(found) != count * width:
        bad = next((line for line in lines if not is_numeric(line, kind)), lines[0])
        raise ValueError(f'"{text_of(bad)}" is no row of numbers')
    return found.reshape(count, width)


def numbers_in(text: bytes, kind: type) -> np.ndarray | None:
    """(n,) numbers between blanks, or None if anything else stands there."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # by which numpy says that it stopped at such a place
        try:
            return np.fromstring(text, kind, sep=" ")
        except (ValueError, DeprecationWarning):
            return None


def is_numeric(line: bytes, kind: type) -> bool:
    """Whether a line holds numbers only."""
    found = numbers_in(line, kind)
    return found is not None and len(found) == len(line.split())


def text_of(line: bytes) -> str:
    """A line for a sentence."""
    return line.decode("utf-8", "replace")[:60]


def corners_of(faces: list[bytes], counts: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(corner_count, 3) int64 vertex, texture vertex and normal, -1 for none, and (face_count,) sizes."""
    text = b"\n".join(faces).replace(b"//", b"/0/")
    if b"/ " in text or b"/\n" in text or text.endswith(b"/"):
        text = (text + b"\n").replace(b"/ ", b"/0 ").replace(b"/\n", b"/0\n")[:-1]
    rows = text.split(b"\n")
    sizes = np.fromiter((len(row.split()) for row in rows), np.int64, len(rows))
    slashes = np.fromiter((row.count(b"/") for row in rows), np.int64, len(rows))
    form = slashes // np.maximum(sizes, 1)
    wrong = (slashes != form * sizes) | (form > 2)
    if wrong.any():
        raise ValueError(f'"f {text_of(faces[int(np.argmax(wrong))])}" is no face')
    corners = np.zeros((int(sizes.sum()), 3), np.int64)
    for kind in np.unique(form):
        own = [rows[k].replace(b"/", b" ") for k in np.flatnonzero(form == kind)]
        where = np.flatnonzero(np.repeat(form == kind, sizes))
        corners[where, : kind + 1] = rows_of(own, np.int64, len(where), int(kind) + 1)
    check_references(corners, counts)
    return corners - 1, sizes


def check_references(corners: np.ndarray, counts: tuple[int, int, int]) -> None:
    """Refuses corners (n, 3), counted from 1, of what is not there."""
    for column, (what, count) in enumerate(zip(REFERENCES, counts, strict=True)):
        lowest = 1 if column == 0 else 0
        wrong = (corners[:, column] < lowest) | (corners[:, column] > count)
        if wrong.any():
            number = int(corners[np.argmax(wrong), column])
            raise ValueError(f"a face has {what} {number}, and there are {count}")


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
    part: tuple[np.ndarray, np.ndarray, np.ndarray], uvs: np.ndarray | None, normals: np.ndarray | None
) -> PolygonMesh:
    """The polygons of an object; corners without a texture vertex lie at 0. Normals count if all corners have one."""
    positions, corners, sizes = part
    mesh = PolygonMesh(positions, corners[:, 0].astype(np.int32), sizes)
    if uvs is not None and (corners[:, 1] >= 0).any():
        mesh.corner_uvs = np.where(corners[:, 1:2] >= 0, uvs[corners[:, 1]], np.float32(0))
    if normals is not None and len(corners) and (corners[:, 2] >= 0).all():
        mesh.corner_normals = normals[corners[:, 2]]
    return mesh
