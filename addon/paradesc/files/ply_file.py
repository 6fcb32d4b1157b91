"""Reads a .ply, text or binary, into polygons of the file's own vertices; faces may have any number of corners."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..bridge import origin
from ..core.polygons import PolygonMesh, listed, triangles_of, vertices_at
from .text_rows import MARK, plain, rows_of, shown

KINDS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
INDICES = ("vertex_indices", "vertex_index", "vertex_indexes")
FIRST_LINE = re.compile(rb"ply[ \t]*(\r\n|\n|\r)")
COMMENTS = (b"comment", b"obj_info")
# The names that exporters give texture coordinates at vertices.
UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
NORMAL_NAMES = ("nx", "ny", "nz")


@dataclass
class Property:
    """A number of each row, or a list of numbers where there is a type of its length."""

    name: str
    kind: np.dtype
    length: np.dtype | None = None


@dataclass
class Element:
    """A table of the file."""

    name: str
    rows: int
    properties: list[Property] = field(default_factory=list)


@dataclass
class Lists:
    """Lists of numbers, one a row."""

    sizes: np.ndarray  # (rows,) int64
    values: np.ndarray  # all of them, one list after the other


Columns = dict[str, "np.ndarray | Lists"]


def read(path: Path) -> PolygonMesh | None:
    """The polygons, or None without faces; raises ValueError if the file is damaged."""
    elements, order, body = opened(path.read_bytes())
    found: dict[str, Columns] = {}
    lines: list[bytes] = []
    if order == "ascii":
        body = plain(body)
        lines = [line for line in body.split(b"\n") if line.strip() and not line.lstrip().startswith(COMMENTS)]
        if len(lines) < sum(element.rows for element in elements):  # of several rows each, or cut off
            body, lines = as_binary(body, elements), []
    at = 0
    for element in elements:
        if "vertex" in found and found.get("face"):
            break
        if lines:
            found[element.name] = read_lines(lines[: element.rows], element)
            lines = lines[element.rows :]
        else:
            found[element.name], at = read_element(body, at, element)
    return polygons(found.get("vertex", {}), found.get("face", {}) or strips(found.get("tristrips", {})))


def opened(content: bytes) -> tuple[list[Element], str, bytes]:
    """The tables that a header describes, the byte order, and the bytes after the header."""
    content = content.removeprefix(MARK)
    begin = FIRST_LINE.match(content)
    if begin is None:
        raise ValueError("it does not begin as one")
    line_end = rb"\r" if begin[1] == b"\r" else rb"\r?\n"  # after a lone CR the bytes begin at once
    end = re.compile(line_end + rb"[ \t]*end_header[ \t]*(" + line_end + rb"|$)").search(content)
    if end is None:
        raise ValueError("its header does not end")
    elements, order = tables_of(content[: end.start()].decode("ascii", "replace").splitlines()[1:])
    return elements, order, content[end.end() :]


def tables_of(lines: list[str]) -> tuple[list[Element], str]:
    """The tables that the lines of a header describe, and the order of their bytes."""
    elements: list[Element] = []
    order = ""
    for words in filter(None, map(str.split, lines)):
        try:
            if words[0] == "format":
                order = words[1]
            elif words[0] == "element":
                elements.append(Element(words[1], int(words[2])))
            elif words[0] == "property":
                elements[-1].properties.append(property_of(words, ORDERS.get(order, "<")))
        except (IndexError, KeyError, ValueError):
            raise ValueError(f'its header has the line "{" ".join(words)[:60]}"') from None
    if order not in ORDERS:
        raise ValueError("its header does not say its format")
    if any(element.rows < 0 for element in elements):
        raise ValueError("its header has a negative number of rows")
    return elements, order


def property_of(words: list[str], order: str) -> Property:
    """A property by its line of the header."""
    if words[1] == "list":
        return Property(words[4], np.dtype(order + KINDS[words[3]]), np.dtype(order + KINDS[words[2]]))
    return Property(words[2], np.dtype(order + KINDS[words[1]]))


def read_lines(lines: list[bytes], element: Element) -> Columns:
    """The columns of a table in text. A row is a line; anything after its last property is ignored."""
    rows = rows_of(lines)
    at, ends = rows.starts[:-1].copy(), rows.starts[1:]
    values = np.append(rows.values, 0.0)
    columns: Columns = {}
    for one in element.properties:
        sizes = np.ones(len(lines), np.int64)
        if one.length is not None:
            sizes = values[np.minimum(at, ends)].astype(np.int64)
            at += 1
        wrong = (at + sizes > ends) | (sizes < 0)
        if wrong.any():
            raise ValueError(f'the row "{shown(lines[int(wrong.argmax())])}" has too few numbers')
        found = values[listed(at, sizes)]
        columns[one.name] = found if one.length is None else Lists(sizes, found)
        at += sizes
    return columns


def as_binary(text: bytes, elements: list[Element]) -> bytes:
    """The numbers of a text as doubles, after the types of all properties have been changed to double."""
    for one in (one for element in elements for one in element.properties):
        one.kind = np.dtype("<f8")
        one.length = None if one.length is None else one.kind
    return rows_of(text.split(b"\n")).values.astype("<f8").tobytes()


def read_element(body: bytes, at: int, element: Element) -> tuple[Columns, int]:
    """The columns of a table that begins at a byte, and where it ends."""
    if element.rows == 0 or not element.properties:
        return {}, at
    least = sum((one.length or one.kind).itemsize for one in element.properties)
    if at + element.rows * least > len(body):
        raise ValueError("it ends too early")
    found = read_even(body, at, element)
    return read_uneven(body, at, element) if found is None else found


def read_even(body: bytes, at: int, element: Element) -> tuple[Columns, int] | None:
    """Reads a table whose lists are all as long as those of its first row; None if they are not."""
    fields, offset = [], at
    for index, one in enumerate(element.properties):
        if one.length is None:
            fields.append((f"v{index}", one.kind))
            offset += one.kind.itemsize
            continue
        size = length_at(body, offset, one.length)
        fields += [(f"n{index}", one.length), (f"v{index}", one.kind, (size,))]
        offset += one.length.itemsize + size * one.kind.itemsize
    row = np.dtype(fields)
    if at + element.rows * row.itemsize > len(body):
        return None
    rows = np.frombuffer(body, row, element.rows, at)
    columns: Columns = {}
    for index, one in enumerate(element.properties):
        values = rows[f"v{index}"]
        if one.length is not None:
            sizes = rows[f"n{index}"]
            if (sizes != sizes[0]).any():
                return None
            values = Lists(sizes.astype(np.int64), values.reshape(-1))
        columns[one.name] = values
    return columns, at + element.rows * row.itemsize


def length_at(body: bytes, at: int, kind: np.dtype) -> int:
    """The length of the list that begins at a byte."""
    if at + kind.itemsize > len(body):
        raise ValueError("it ends too early")
    length = np.frombuffer(body, kind, 1, at)[0]
    if not 0 <= length <= len(body):
        raise ValueError("a list in it is longer than the file")
    return int(length)


def read_uneven(body: bytes, at: int, element: Element) -> tuple[Columns, int]:
    """Reads a table whose lists differ in length: finds where each begins, row after row."""
    places = np.empty((element.rows, len(element.properties)), np.int64)
    sizes = np.ones((element.rows, len(element.properties)), np.int64)
    steps = [(one.kind.itemsize, one.length, one.length and one.length.itemsize) for one in element.properties]
    single = [length is not None and length.itemsize == 1 and length.kind == "u" for _, length, _ in steps]
    for row in range(element.rows):
        for index, (width, length, ahead) in enumerate(steps):
            size = 1
            if length is not None:
                size = body[at] if single[index] and at < len(body) else length_at(body, at, length)
                at += ahead
                sizes[row, index] = size
            places[row, index] = at
            at += size * width
        if at > len(body):
            raise ValueError("it ends too early")
    columns: Columns = {}
    for index, one in enumerate(element.properties):
        values = gathered(body, places[:, index], sizes[:, index], one.kind)
        columns[one.name] = values if one.length is None else Lists(sizes[:, index], values)
    return columns, at


def gathered(body: bytes, places: np.ndarray, sizes: np.ndarray, kind: np.dtype) -> np.ndarray:
    """The numbers at places (n,) in bytes, as many as the list at each has (n,), one list after the other."""
    raw = np.frombuffer(body, np.uint8)
    values = np.empty(int(sizes.sum()), kind)
    begin = np.cumsum(sizes) - sizes
    for size in np.unique(sizes[sizes > 0]):
        rows = np.flatnonzero(sizes == size)
        content = raw[places[rows, None] + np.arange(size * kind.itemsize)]
        values[begin[rows, None] + np.arange(size)] = content.view(kind)
    return values


def polygons(vertex: Columns, face: Columns) -> PolygonMesh | None:
    """The polygons that the tables of vertices and faces hold; None without faces."""
    lists = next((face[name] for name in INDICES if name in face), None)
    if lists is None or not isinstance(lists, Lists):
        if face:
            raise ValueError(f"its faces have no list of vertices, which is called {INDICES[0]}")
        return None
    lacking = [name for name in "xyz" if not isinstance(vertex.get(name), np.ndarray)]
    if lacking:
        raise ValueError(f"its vertices have no property {lacking[0]}")
    corners = vertices_at(lists.values, len(vertex["x"]))
    points = np.stack([vertex[name].astype(np.float64) for name in "xyz"], axis=1)
    mesh = PolygonMesh(origin.stored(points), corners.astype(np.int32), lists.sizes)
    mesh.corner_uvs = uvs_of(vertex, face, mesh)
    if all(isinstance(vertex.get(name), np.ndarray) for name in NORMAL_NAMES):
        mesh.corner_normals = stacked(vertex, NORMAL_NAMES)[mesh.corner_vertices]
    return mesh


def strips(element: Columns) -> Columns:
    """The faces of strips of triangles, between which -1 stands, as some scanners' programs write them."""
    lists = next((element[name] for name in INDICES if isinstance(element.get(name), Lists)), None)
    if lists is None:
        return {}
    found = triangles_of(lists.values.astype(np.int64), lists.sizes, -1)
    return {INDICES[0]: Lists(found.sizes, found.corner_vertices)}


def uvs_of(vertex: Columns, face: Columns, mesh: PolygonMesh) -> np.ndarray | None:
    """(corner_count, 2) float32 texture coordinates of corners or of vertices, or None."""
    own = face.get("texcoord")
    if isinstance(own, Lists) and (own.sizes == 2 * mesh.sizes).all():
        return own.values.reshape(-1, 2).astype(np.float32)
    names = next((names for names in UV_NAMES if all(isinstance(vertex.get(name), np.ndarray) for name in names)), None)
    return None if names is None else stacked(vertex, names)[mesh.corner_vertices]


def stacked(columns: Columns, names: tuple[str, ...]) -> np.ndarray:
    """(rows, len(names)) float32 of these columns."""
    return np.stack([np.asarray(columns[name]).astype(np.float32) for name in names], axis=1)
