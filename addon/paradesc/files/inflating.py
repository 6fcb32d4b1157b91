"""Unpacks what zlib packed in image files, no further than their headers promise."""

import zlib

MOST = 1100  # bytes that a packed one can become; zlib packs no tighter


def inflated(packed: bytes, size: int) -> bytes:
    """The first bytes of zlib's output, at most size; raises ValueError if the input is damaged."""
    try:
        return zlib.decompressobj().decompress(packed, size)
    except zlib.error as error:
        raise ValueError("it is damaged") from error
