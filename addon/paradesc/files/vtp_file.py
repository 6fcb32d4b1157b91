"""Reads VTK's PolyData as XML, .vtp, into polygons of the file's own points. Never imports bpy.

Arrays may be text, base64 or raw bytes behind the XML, whole or packed by zlib in blocks, which VTK's writer does.
"""

import base64
import binascii
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..bridge import origin
from ..core.polygons import PolygonMesh, Polygons, triangles_of, vertices_at
from .text_rows import numbers_in
from .vtk_legacy_file import sizes_between

KINDS = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
    "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
APPENDED = re.compile(rb"<AppendedData[^>]*>")
ZLIB = "vtkZLibDataCompressor"
MOST = 1100  # bytes that a packed one can become; zlib packs no tighter


@dataclass
class Document:
    """The XML of a file, and the bytes behind it."""

    root: ElementTree.Element
    appended: bytes = b""  # from the underscore on, which is not part of it
    is_raw: bool = False  # and not base64

    @property
    def order(self) -> str:
        """The byte order, as numpy writes it."""
        return ">" if self.root.get("byte_order") == "BigEndian" else "<"

    def array(self, element: ElementTree.Element) -> np.ndarray:
        """(n,) numbers of a DataArray."""
        if element.get("type") not in KINDS:
            raise ValueError(f'it has an array of the type "{element.get("type")}"')
        kind = np.dtype(self.order + KINDS[element.get("type")])
        way = element.get("format", "ascii")
        if way == "ascii":
            values = numbers_in((element.text or "").encode(), np.float64 if kind.kind == "f" else np.int64)
            if values is None:
                raise ValueError("an array of it holds other things than numbers")
            return values
        if way == "binary":
            content = self.decoded("".join((element.text or "").split()).encode(), 0)
        elif way == "appended":
            offset = element.get("offset") or ""
            if not offset.isdecimal():
                raise ValueError(f'it has "{element.get("offset")}" where a number of bytes should be')
            content = self.behind(int(offset))
        else:
            raise ValueError(f'it has an array of the format "{way}"')
        return np.frombuffer(content, kind, len(content) // kind.itemsize)

    def behind(self, offset: int) -> bytes:
        """The bytes of an array at this offset in the appended data."""
        if offset >= len(self.appended):
            raise ValueError("an array of it lies behind its end; it was cut off")
        return self.unpacked(self.appended, offset) if self.is_raw else self.decoded(self.appended, offset)

    def decoded(self, text: bytes, offset: int) -> bytes:
        """The bytes of an array in base64. Its header is encoded apart if it is padded, or the array compressed."""
        width = self.head.itemsize
        if not self.compressor:
            size = int(np.frombuffer(from_base64(text, offset, width), self.head)[0])
            if text[offset : offset + of_base64(width)].endswith(b"="):
                return from_base64(text, offset + of_base64(width), size)
            return from_base64(text, offset, width + size)[width:]
        blocks = int(np.frombuffer(from_base64(text, offset, width), self.head)[0])
        length = (3 + blocks) * width
        head = from_base64(text, offset, length)
        packed = np.frombuffer(head, self.head)[3:]
        return self.unpacked(head + from_base64(text, offset + of_base64(length), int(packed.sum())), 0)

    @property
    def head(self) -> np.dtype:
        """The type of the header's numbers before each array."""
        return np.dtype(self.order + KINDS.get(self.root.get("header_type", "UInt32"), "u4"))

    @property
    def compressor(self) -> str:
        """The compressor of the arrays; "" if they are not compressed."""
        found = self.root.get("compressor", "")
        if found not in ("", ZLIB):
            raise ValueError(f"its arrays are packed by {found}, which is unknown here; save it with zlib or none")
        return found

    def unpacked(self, body: bytes, at: int) -> bytes:
        """The bytes of an array that begins with its header at a byte."""
        width = self.head.itemsize
        if not self.compressor:
            size = int(np.frombuffer(taken(body, at, width), self.head)[0])
            return taken(body, at + width, size)
        blocks = int(np.frombuffer(taken(body, at, width), self.head)[0])
        _, size, last, *lengths = np.frombuffer(taken(body, at, (3 + blocks) * width), self.head).tolist()
        at += (3 + blocks) * width
        found = []
        for number, length in enumerate(lengths):
            wanted = last if last and number == blocks - 1 else size
            if wanted > MOST * length + MOST:
                raise ValueError("it promises more than what is packed in it can be")
            try:
                found.append(zlib.decompressobj().decompress(taken(body, at, length), max(wanted, 1)))
            except zlib.error as error:
                raise ValueError("it is damaged") from error
            if len(found[-1]) != wanted:
                raise ValueError("what is packed in it is not as long as it promises; it was cut off, or damaged")
            at += length
        return b"".join(found)


def read(path: Path) -> PolygonMesh | None:
    """The polygons of all pieces, None without any; raises ValueError if the file is damaged or no surface."""
    document = opened(path.read_bytes())
    if document.root.tag != "VTKFile" or document.root.get("type") != "PolyData":
        found = document.root.get("type") or document.root.tag
        sentence = f"it holds {found}, and no surface (PolyData)"
        raise ValueError(f"{sentence}; extract its surface and save that")
    points, corners, sizes = [np.empty((0, 3))], [], []
    vertices = 0
    for piece in document.root.iterfind("PolyData/Piece"):
        own = piece.find("Points/DataArray")
        if own is None:
            continue
        values = document.array(own)
        if len(values) % 3:
            raise ValueError("its points are no rows of three numbers")
        points.append(values.astype(np.float64).reshape(-1, 3))
        for found in faces_of(document, piece):
            corners.append(vertices_at(found.corner_vertices, len(points[-1])) + vertices)
            sizes.append(found.sizes)
        vertices += len(points[-1])
    if not sizes:
        return None
    return PolygonMesh(
        origin.stored(np.concatenate(points)), np.concatenate(corners).astype(np.int32), np.concatenate(sizes)
    )


def opened(content: bytes) -> Document:
    """The XML, which ends where the appended bytes begin, and these."""
    mark = APPENDED.search(content)
    text = content if mark is None else content[: mark.start()] + b"</VTKFile>"
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"its XML is damaged or cut off ({error})") from error
    if mark is None:
        return Document(root)
    is_raw = b'"raw"' in mark[0]
    begin = content.find(b"_", mark.end()) + 1
    if not begin:
        raise ValueError("its appended arrays do not begin")
    body = content[begin:]
    return Document(root, body if is_raw else b"".join(body.partition(b"<")[0].split()), is_raw)


def faces_of(document: Document, piece: ElementTree.Element) -> list[Polygons]:
    """The polygons of a piece, and the triangles of its strips."""
    found = []
    for name in ("Polys", "Strips"):
        arrays = {one.get("Name"): one for one in piece.iterfind(f"{name}/DataArray")}
        if "connectivity" not in arrays or "offsets" not in arrays:
            continue
        ends = document.array(arrays["offsets"]).astype(np.int64)
        if not len(ends):
            continue
        corners = document.array(arrays["connectivity"])
        sizes = sizes_between(np.concatenate([[0], ends]), len(corners))
        found.append(triangles_of(corners, sizes) if name == "Strips" else Polygons(corners, sizes))
    return found


def taken(body: bytes, at: int, size: int) -> bytes:
    """So many bytes, beginning at this one; raises if the file ends before."""
    if at + size > len(body):
        raise ValueError("it ends within an array; it was cut off")
    return body[at : at + size]


def of_base64(size: int) -> int:
    """The number of base64 letters for so many bytes."""
    return -(-size // 3) * 4


def from_base64(text: bytes, at: int, size: int) -> bytes:
    """So many bytes, decoded from the letters that begin here."""
    letters = taken(text, at, of_base64(size)).rstrip(b"=")
    try:
        found = base64.b64decode(letters + b"=" * (-len(letters) % 4), validate=True)
    except binascii.Error as error:
        raise ValueError("an array of it is not base64") from error
    return found[:size]
