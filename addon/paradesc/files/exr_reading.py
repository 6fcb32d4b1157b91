"""Reads OpenEXR files as arrays with the standard library and numpy: scan lines, by ZIP, RLE or as they are."""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .exr import MAGIC
from .inflating import MOST, inflated

NO, RUNS, ZIP_LINES, ZIP = 0, 1, 2, 3
LINES = {NO: 1, RUNS: 1, ZIP_LINES: 1, ZIP: 16}  # that are compressed together
# The names of compressions that cannot be read.
NAMES = {4: "PIZ", 5: "PXR24", 6: "B44", 7: "B44A", 8: "DWAA", 9: "DWAB"}
KINDS = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
TILED, DEEP, SEVERAL_PARTS = 0x200, 0x800, 0x1000


@dataclass
class Header:
    """The attributes of a file that say how its lines are stored."""

    channels: list[tuple[str, np.dtype]]  # in the order of the file
    compression: int
    first_line: int
    width: int
    height: int
    end: int  # where it ends in the file

    @property
    def line_bytes(self) -> int:
        """Bytes of a line of all channels."""
        return self.width * sum(kind.itemsize for _, kind in self.channels)


def read_exr(path: Path) -> dict[str, np.ndarray]:
    """Channels by name, each (height, width) float32 with the top row first; raises ValueError about what is wrong."""
    content = path.read_bytes()
    try:
        header = header_of(content)
        lines = lines_of(content, header)
    except (struct.error, IndexError, OverflowError) as error:
        raise ValueError("it ends too early, or is damaged") from error
    found, place = {}, 0
    for name, kind in header.channels:
        end = place + header.width * kind.itemsize
        found[name] = np.ascontiguousarray(lines[:, place:end]).view(kind).astype(np.float32)
        place = end
    return found


def header_of(content: bytes) -> Header:
    """Reads the attributes; raises if the file is stored in a way that is not supported."""
    magic, version = struct.unpack_from("<2i", content)
    if magic != MAGIC:
        raise ValueError("it is no OpenEXR file")
    if version & (TILED | DEEP | SEVERAL_PARTS):
        raise ValueError("it has tiles, several parts or deep pixels; save it as plain scan lines")
    attributes, place = {}, 8
    while content[place]:
        name, place = text_at(content, place)
        _, place = text_at(content, place)
        (size,) = struct.unpack_from("<i", content, place)
        if size < 0:
            raise ValueError("it is damaged")
        attributes[name] = content[place + 4 : place + 4 + size]
        place += 4 + size
    if not {"channels", "compression", "dataWindow"} <= attributes.keys():
        raise ValueError("it is damaged: its header lacks an attribute")
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    compression = attributes["compression"][0]
    if compression not in LINES:
        name = NAMES.get(compression, "an unknown")
        raise ValueError(f"it has {name} compression; save it with ZIP, RLE or none")
    if right < left or bottom < top:
        raise ValueError("it has no pixels")
    return Header(channels_of(attributes["channels"]), compression, top, right - left + 1, bottom - top + 1, place + 1)


def text_at(content: bytes, place: int) -> tuple[str, int]:
    """The text that begins at a place, and the place after its end."""
    end = content.find(b"\0", place)
    if end < 0:
        raise ValueError("it ends too early")
    return content[place:end].decode("utf-8", "replace"), end + 1


def channels_of(listed: bytes) -> list[tuple[str, np.dtype]]:
    """The channels with their types, in the order of the file."""
    found, place = [], 0
    while listed[place]:
        name, place = text_at(listed, place)
        kind, _, across, down = struct.unpack_from("<iB3xii", listed, place)
        if kind not in KINDS or (across, down) != (1, 1):
            raise ValueError(f'its channel "{name}" has fewer pixels than others, or an unknown type')
        found.append((name, KINDS[kind]))
        place += 16
    if not found:
        raise ValueError("it has no channels")
    return found


def lines_of(content: bytes, header: Header) -> np.ndarray:
    """(height, bytes) uint8 of all lines. Their blocks lie wherever the table behind the header says."""
    step = LINES[header.compression]
    count = -(-header.height // step)
    if header.height * header.line_bytes > MOST * len(content):
        raise ValueError("it ends too early, or is damaged")
    places = struct.unpack_from(f"<{count}Q", content, header.end)
    lines = np.zeros((header.height, header.line_bytes), np.uint8)
    missing = np.ones(header.height, bool)
    for place in places:
        line, size = struct.unpack_from("<2i", content, place)
        first = line - header.first_line
        rows = lines[first : first + step] if 0 <= first < header.height else lines[:0]
        packed = content[place + 8 : place + 8 + size]
        if not len(rows) or size < 0 or len(packed) < size:
            raise ValueError("it ends too early, or is damaged")
        rows[:] = block(packed, rows.size, header.compression).reshape(rows.shape)
        missing[first : first + step] = False
    if missing.any():
        raise ValueError("it is damaged: lines are missing")
    return lines


def block(packed: bytes, size: int, compression: int) -> np.ndarray:
    """(size,) uint8 of a block; one that compression would not shorten is stored as it is."""
    if compression == NO or len(packed) == size:
        found = np.frombuffer(packed, np.uint8)
    else:
        parted = np.frombuffer(runs(packed) if compression == RUNS else inflated(packed, size), np.uint8).copy()
        if len(parted) != size:
            raise ValueError("it is damaged")
        parted[1:] -= np.uint8(128)
        np.add.accumulate(parted, out=parted)  # of differences, modulo 256
        found = np.empty(size, np.uint8)
        half = -(-size // 2)
        found[0::2], found[1::2] = parted[:half], parted[half:]
    if len(found) != size:
        raise ValueError("it is damaged")
    return found


def runs(packed: bytes) -> bytes:
    """The bytes of OpenEXR's run lengths: -n stands before n bytes as they are, n before a byte n + 1 times."""
    found, place = [], 0
    while place < len(packed):
        count = packed[place] - 256 if packed[place] > 127 else packed[place]
        if count < 0:
            found.append(packed[place + 1 : place + 1 - count])
            place += 1 - count
        else:
            found.append(packed[place + 1 : place + 2] * (count + 1))
            place += 2
    return b"".join(found)
