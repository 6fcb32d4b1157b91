"""Writes an image as a PNG file with the standard library alone (PNG specification, ISO/IEC 15948)."""

import struct
import zlib
from pathlib import Path

import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"
EIGHT_BITS, SIXTEEN_BITS, GREY, RGB = 8, 16, 0, 2
# Rows are stored as differences from the row above, which halves the size of shaded pictures.
UP_FILTER = 2


def chunk(kind: bytes, content: bytes) -> bytes:
    """One PNG chunk: length, type, content, checksum over type and content."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def encode_png(image: np.ndarray) -> bytes:
    """(height, width, 3) uint8 display colors, top row first, as the bytes of a PNG file."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"an image is (height, width, 3) uint8, not {image.shape} {image.dtype}")
    height, width, _ = image.shape
    rows = np.full((height, 1 + 3 * width), UP_FILTER, np.uint8)  # each row starts with its filter type
    flat = image.reshape(height, -1)
    rows[:, 1:] = flat
    rows[1:, 1:] -= flat[:-1]  # modulo 256, as the specification has it
    header = struct.pack(">IIBBBBB", width, height, EIGHT_BITS, RGB, 0, 0, 0)
    content = zlib.compress(rows.tobytes(), 6)
    return SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", content) + chunk(b"IEND", b"")


def encode_png16(image: np.ndarray, texts: dict[str, str]) -> bytes:
    """(height, width, 1 or 3) uint16, top row first, as the bytes of a PNG file; texts: ASCII, by keyword."""
    if image.dtype != np.uint16 or image.ndim != 3 or image.shape[2] not in (1, 3):
        raise ValueError(f"an image is (height, width, 1 or 3) uint16, not {image.shape} {image.dtype}")
    height, width, channels = image.shape
    flat = image.astype(">u2").reshape(height, -1).view(np.uint8)
    rows = np.full((height, 1 + flat.shape[1]), UP_FILTER, np.uint8)
    rows[:, 1:] = flat
    rows[1:, 1:] -= flat[:-1]
    header = struct.pack(">IIBBBBB", width, height, SIXTEEN_BITS, GREY if channels == 1 else RGB, 0, 0, 0)
    # A texture is data, so it gets a gamma of 1: otherwise programs that apply gamma would change the values.
    notes = b"".join(chunk(b"tEXt", f"{key}\0{text}".encode("latin-1")) for key, text in texts.items())
    content = chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
    start = SIGNATURE + chunk(b"IHDR", header) + chunk(b"gAMA", struct.pack(">I", 100000))
    return start + notes + content + chunk(b"IEND", b"")


def write_png16(path: Path, image: np.ndarray, texts: dict[str, str]) -> None:
    """Writes a (height, width, 1 or 3) uint16 image with its texts."""
    path.write_bytes(encode_png16(image, texts))


def write_png(path: Path, image: np.ndarray) -> None:
    """Writes a (height, width, 3) uint8 image."""
    path.write_bytes(encode_png(image))
