"""Writes float images as OpenEXR files with numpy and the standard library: scan lines, 32-bit floats, ZIP."""

import struct
import zlib
from pathlib import Path

import numpy as np

MAGIC, VERSION = 20000630, 2
FLOAT, ZIP, INCREASING_Y = 2, b"\x03", b"\x00"
BLOCK_LINES = 16  # lines that are compressed together


def attribute(name: str, kind: str, value: bytes) -> bytes:
    """One header attribute: name, type, size, value."""
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def header(names: list[str], width: int, height: int) -> bytes:
    """The magic number and all attributes that a file must have, with channels in alphabetical order."""
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", FLOAT, 0, 1, 1) for name in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [
        attribute("channels", "chlist", channels),
        attribute("compression", "compression", ZIP),
        attribute("dataWindow", "box2i", window),
        attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", INCREASING_Y),
        attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    return struct.pack("<2i", MAGIC, VERSION) + b"".join(attributes) + b"\0"


def compress(raw: bytes) -> bytes:
    """Compresses as OpenEXR's ZIP: even bytes before odd ones, differences, zlib; not at all if that is no shorter."""
    content = np.frombuffer(raw, np.uint8)
    parted = np.concatenate([content[0::2], content[1::2]])
    parted[1:] = parted[1:] - parted[:-1] + np.uint8(128)  # numpy evaluates the right side first; modulo 256
    packed = zlib.compress(parted.tobytes(), 6)
    return packed if len(packed) < len(raw) else raw


def encode_exr(channels: dict[str, np.ndarray]) -> bytes:
    """Channels by name, each (height, width) float32 with the top row first, as the bytes of an EXR file."""
    names = sorted(channels)
    if not names or any(channels[name].ndim != 2 or channels[name].shape != channels[names[0]].shape for name in names):
        raise ValueError("an image has channels, all (height, width)")
    height, width = channels[names[0]].shape
    lines = np.stack([channels[name].astype("<f4") for name in names], axis=1)  # (height, channel, width)
    blocks = []
    for first in range(0, height, BLOCK_LINES):
        packed = compress(lines[first : first + BLOCK_LINES].tobytes())
        blocks.append(struct.pack("<2i", first, len(packed)) + packed)
    start = header(names, width, height)
    sizes = np.array([len(start) + 8 * len(blocks), *map(len, blocks[:-1])], np.uint64)
    return start + np.cumsum(sizes).astype("<u8").tobytes() + b"".join(blocks)


def write_exr(path: Path, channels: dict[str, np.ndarray]) -> None:
    """Writes (height, width) float32 channels, top row first."""
    path.write_bytes(encode_exr(channels))
