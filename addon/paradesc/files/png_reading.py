"""Reads every kind of PNG file exactly, with the standard library and numpy (PNG specification, ISO/IEC 15948).

Values stay what the file has: no gamma, no color space, no alpha is applied, because maps are no pictures.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .inflating import MOST, inflated
from .png import SIGNATURE

GREY, RGB, PALETTE, GREY_ALPHA, RGB_ALPHA = 0, 2, 3, 4, 6
CHANNELS = {GREY: 1, RGB: 3, PALETTE: 1, GREY_ALPHA: 2, RGB_ALPHA: 4}
DEPTHS = {GREY: (1, 2, 4, 8, 16), PALETTE: (1, 2, 4, 8), RGB: (8, 16), GREY_ALPHA: (8, 16), RGB_ALPHA: (8, 16)}
# The filters of rows.
LEFT, UP, AVERAGE, PAETH = 1, 2, 3, 4
# First column, first row, step of columns, step of rows of the seven images that an interlaced one is made of (Adam7).
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))


@dataclass
class Header:
    """The content of the first chunk, IHDR."""

    width: int
    height: int
    depth: int  # bits of a channel
    kind: int
    interlaced: bool

    @property
    def channels(self) -> int:
        """The number of channels of a pixel in the file."""
        return CHANNELS[self.kind]

    def row_bytes(self, width: int) -> int:
        """The bytes in a row of this many pixels, without its filter."""
        return -(-width * self.channels * self.depth // 8)

    def parts(self) -> list[tuple[slice, slice, int, int]]:
        """Rows and columns of each part of the image that is stored by itself, and its height and width."""
        if not self.interlaced:
            return [(slice(None), slice(None), self.height, self.width)]
        found = []
        for x, y, across, down in PASSES:
            height, width = -(-(self.height - y) // down), -(-(self.width - x) // across)
            if height > 0 and width > 0:
                found.append((slice(y, None, down), slice(x, None, across), height, width))
        return found


def read_png(path: Path) -> np.ndarray:
    """(height, width, 1 to 4) uint8, or uint16 of 16 bits, top row first; raises ValueError about what is wrong."""
    header, palette, packed = None, None, []
    for kind, content in chunks(path.read_bytes()):
        if kind == b"IHDR":
            header = header_of(content)
        elif kind == b"PLTE":
            palette = np.frombuffer(content[: len(content) // 3 * 3], np.uint8).reshape(-1, 3)
        elif kind == b"IDAT":
            packed.append(content)
        elif kind == b"IEND":
            break
    if header is None or not packed:
        raise ValueError("it has no image")
    return pixels_of(header, palette, unpacked(header, b"".join(packed)))


def chunks(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kind and content of each chunk."""
    if not content.startswith(SIGNATURE):
        raise ValueError("it is no PNG file")
    place = len(SIGNATURE)
    while place + 12 <= len(content):
        length, kind = struct.unpack_from(">I4s", content, place)
        end = place + 8 + length
        if end + 4 > len(content):
            break
        body = content[place + 8 : end]
        if zlib.crc32(content[place + 4 : end]) != struct.unpack_from(">I", content, end)[0]:
            raise ValueError("it is damaged: a checksum does not fit")
        yield kind, body
        place = end + 4
    else:
        return
    raise ValueError("it ends too early")


def header_of(content: bytes) -> Header:
    """The header, if it is one that the specification has."""
    if len(content) != 13:
        raise ValueError("its header is damaged")
    width, height, depth, kind, packing, filtering, interlacing = struct.unpack(">IIBBBBB", content)
    sound = depth in DEPTHS.get(kind, ()) and (packing, filtering) == (0, 0) and interlacing in (0, 1)
    if not sound or not 0 < width < 2**31 or not 0 < height < 2**31:
        raise ValueError("its header is damaged")
    return Header(width, height, depth, kind, interlacing == 1)


def unpacked(header: Header, packed: bytes) -> np.ndarray:
    """(n,) uint8 filtered rows of all parts. A small file cannot make more of itself than its header says."""
    size = sum(height * (1 + header.row_bytes(width)) for _, _, height, width in header.parts())
    if size > MOST * len(packed) + 1000:
        raise ValueError("it ends too early")
    found = inflated(packed, size)
    if len(found) < size:
        raise ValueError("it ends too early")
    return np.frombuffer(found, np.uint8)


def pixels_of(header: Header, palette: np.ndarray | None, content: np.ndarray) -> np.ndarray:
    """The image of filtered rows (n,)."""
    image = np.empty((header.height, header.width, header.channels), np.uint16 if header.depth == 16 else np.uint8)
    place = 0
    for rows, columns, height, width in header.parts():
        size = height * (1 + header.row_bytes(width))
        stored = content[place : place + size].reshape(height, -1)
        image[rows, columns] = samples(header, unfiltered(stored, header), width)
        place += size
    if header.kind != PALETTE:
        return image
    if palette is None or image.max() >= len(palette):
        raise ValueError("it is damaged: a color is missing")
    return palette[image[:, :, 0]]


def samples(header: Header, rows: np.ndarray, width: int) -> np.ndarray:
    """(height, width, channels) of rows (height, bytes) uint8; grey of few bits goes from 0 to 255."""
    height, depth = len(rows), header.depth
    if depth == 16:
        return np.ascontiguousarray(rows).view(">u2").reshape(height, width, -1)
    if depth < 8:
        bits = np.unpackbits(rows, axis=1).reshape(height, -1, depth)[:, :width]
        rows = (bits << np.arange(depth - 1, -1, -1, dtype=np.uint8)).sum(axis=2, dtype=np.uint8)
        if header.kind == GREY:
            rows = rows * np.uint8(255 // (2**depth - 1))
    return rows.reshape(height, width, -1)


# ---- Filters


def unfiltered(stored: np.ndarray, header: Header) -> np.ndarray:
    """(height, bytes) uint8 of rows (height, 1 + bytes) that begin with their filter."""
    filters, rows = stored[:, 0], stored[:, 1:]
    if filters.max() > PAETH:
        raise ValueError("it is damaged: it has an unknown filter")
    step = max(1, header.channels * header.depth // 8)
    pixels = rows.reshape(len(rows), -1, step)
    if filters.max() <= UP:
        return by_rows(filters, pixels).reshape(len(rows), -1)
    return by_diagonals(filters, pixels).reshape(len(rows), -1)


def by_rows(filters: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Undoes the filters of pixels (height, width, bytes) of which each row needs its own bytes or those above."""
    found = pixels.copy()
    for y, kind in enumerate(filters):
        if kind == LEFT:
            np.add.accumulate(found[y], axis=0, out=found[y])  # modulo 256, as everything here
        elif kind == UP and y:
            found[y] += found[y - 1]
    return found


def by_diagonals(filters: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Undoes all filters. Pixels on a diagonal from lower left to upper right do not need each other, so go at once."""
    height, width, step = pixels.shape
    found = np.zeros((height + 1, width + 1, step), np.uint8)  # what lies outside is 0
    found[1:, 1:] = pixels
    flat, side = found.reshape(-1, step), width + 1
    kinds = filters[:, None]
    is_left, is_up, is_average, is_paeth = (kinds == kind for kind in (LEFT, UP, AVERAGE, PAETH))
    for diagonal in range(height + width - 1):
        first, last = max(0, diagonal - width + 1), min(height - 1, diagonal)
        start, count = (first + 1) * side + diagonal - first + 1, last - first + 1
        stop = start + (count - 1) * width + 1
        left, up, across = (flat[start - d : stop - d : width].astype(np.int16) for d in (1, side, side + 1))
        rows = slice(first, last + 1)
        added = is_left[rows] * left + is_up[rows] * up + is_average[rows] * ((left + up) >> 1)
        added += is_paeth[rows] * nearest(left, up, across)
        flat[start:stop:width] += added.astype(np.uint8)
    return found[1:, 1:]


def nearest(left: np.ndarray, up: np.ndarray, across: np.ndarray) -> np.ndarray:
    """The one of three pixels that is nearest to left + up - across, the first among equals (Paeth)."""
    to_left, to_up = np.abs(up - across), np.abs(left - across)
    to_across = np.abs(left + up - 2 * across)
    return np.where((to_left <= to_up) & (to_left <= to_across), left, np.where(to_up <= to_across, up, across))
