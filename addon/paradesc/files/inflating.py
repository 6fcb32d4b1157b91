"""Unpacks what zlib packed in image files, no further than their headers promise."""

import zlib

MOST = 1100  # bytes that a packed one can become; zlib packs no tighter


def inflated(packed: bytes, size: int) -> bytes:
    """The first bytes of what zlib packed, at most size; raises ValueError about what is wrong."""
    try:
        return zlib.decompressobj().decompress(packed, size)
    except zlib.error as error:
        raise ValueError("it is damaged") from error
