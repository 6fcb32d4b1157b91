"""Writes an image as a PNG file with the standard library alone (PNG specification, ISO/IEC 15948)."""

import struct
import zlib
from pathlib import Path

import numpy as np

from ..core import threads

SIGNATURE = b"\x89PNG\r\n\x1a\n"
BITS = {np.dtype(np.uint8): 8, np.dtype(np.uint16): 16}
# The color type of images by the number of their channels: grey, grey and alpha, RGB, RGBA.
COLOR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}
# Rows are stored as differences from the row above, which halves the size of shaded pictures.
UP_FILTER = 2
# Rows of large textures that one thread packs, and how hard: half as large again is written three times as fast.
BAND, BANDS_AT_ONCE, QUICK = 256, 16, 1


def chunk(kind: bytes, content: bytes) -> bytes:
    """One PNG chunk: length, type, content, checksum over type and content."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def encode_png(image: np.ndarray, texts: dict[str, str] | None = None, quick: bool = False) -> bytes:
    """(height, width, 1 to 4) uint8 or uint16, top row first, as a PNG file; quick: packed less tightly, on threads."""
    if image.dtype not in BITS or image.ndim != 3 or image.shape[2] not in COLOR_TYPES:
        raise ValueError(f"an image is (height, width, 1 to 4) uint8 or uint16, not {image.shape} {image.dtype}")
    height, width, channels = image.shape
    parts = [chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, BITS[image.dtype], COLOR_TYPES[channels], 0, 0, 0))]
    if image.dtype == np.uint16:
        # A texture is data, so it gets a gamma of 1: otherwise programs that apply gamma would change the values.
        parts.append(chunk(b"gAMA", struct.pack(">I", 100000)))
    parts += [chunk(b"tEXt", f"{key}\0{text}".encode("latin-1")) for key, text in (texts or {}).items()]
    parts.append(chunk(b"IDAT", packed_quickly(image) if quick else zlib.compress(filtered_rows(image).tobytes(), 6)))
    return b"".join([SIGNATURE, *parts, chunk(b"IEND", b"")])


def filtered_rows(image: np.ndarray, above: np.ndarray | None = None) -> np.ndarray:
    """(height, bytes) of an image: in each row its filter, then its difference from the one above, modulo 256."""
    flat = bytes_of(image)
    rows = np.full((len(image), 1 + flat.shape[1]), UP_FILTER, np.uint8)
    rows[:, 1:] = flat
    rows[1:, 1:] -= flat[:-1]
    if above is not None:
        rows[0, 1:] -= bytes_of(above[None])[0]
    return rows


def bytes_of(image: np.ndarray) -> np.ndarray:
    """(height, bytes) of the rows of an image, as PNG orders them."""
    return image.astype(image.dtype.newbyteorder(">")).reshape(len(image), -1).view(np.uint8)


def packed_quickly(image: np.ndarray) -> bytes:
    """A zlib stream of the image's rows, made of parts that end on whole bytes and know nothing of each other."""
    starts = range(0, len(image), BAND)

    def pack(start: int) -> tuple[bytes, bytes]:
        rows = filtered_rows(image[start : start + BAND], image[start - 1] if start else None).tobytes()
        packer = zlib.compressobj(QUICK, zlib.DEFLATED, -zlib.MAX_WBITS)
        end = zlib.Z_FINISH if start == starts[-1] else zlib.Z_SYNC_FLUSH
        return rows, packer.compress(rows) + packer.flush(end)

    parts, checksum = [b"\x78\x01"], 1  # of a stream with the usual window, packed quickly (RFC 1950)
    for first in range(0, len(starts), BANDS_AT_ONCE):
        for rows, part in threads.side_by_side(pack, starts[first : first + BANDS_AT_ONCE]):
            checksum = zlib.adler32(rows, checksum)
            parts.append(part)
    return b"".join([*parts, struct.pack(">I", checksum)])


def write_png(path: Path, image: np.ndarray, texts: dict[str, str] | None = None) -> None:
    """Writes an image with its texts."""
    path.write_bytes(encode_png(image, texts))
