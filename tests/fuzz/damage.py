"""Damages values and bytes for the fuzzer of readers, and says what a reader must not do."""

import random
import struct
from pathlib import Path

import numpy as np

from paradesc.bridge import ParadescError

ODD = (None, True, False, 0, -1, 1, 2**31, -(2**63), 10**400, 0.0, -0.0, 1e308, 5e-324, float("nan"), float("inf"), "",
       "radius")  # fmt: skip
ODD_TEXTS = ("", "__class__", "../../etc/passwd", "mean_curvature:quantiles", "x" * 200, "\u0000", "cos\nsystem", "é",
             "{0.__init__}")  # fmt: skip


class BrokenWordError(Exception):
    """A reader did what it must not do."""


def claim(holds: bool, what: str) -> None:
    """Raises if a reader broke its word."""
    if not holds:
        raise BrokenWordError(what)


def claim_one_sentence(error: ParadescError, path: Path) -> None:
    """Checks that a refusal of a file is one sentence with its name."""
    named = str(path) in error.sentence and "\n" not in error.sentence
    claim(named, "a refusal is not one sentence that names the file")


def odd(source: random.Random, depth: int = 0) -> object:
    """Any value that JSON or a custom property holds, the awkward ones first."""
    kind = source.randrange(8)
    if kind < 4 or depth > 3:
        return source.choice(ODD)
    if kind == 4:
        return source.choice(ODD_TEXTS)
    if kind == 5:
        return source.randint(-(2**33), 2**33)
    if kind == 6:
        return [odd(source, depth + 1) for _ in range(source.randrange(4))]
    return {source.choice(ODD_TEXTS) or "a": odd(source, depth + 1) for _ in range(source.randrange(4))}


def damaged(source: random.Random, value: object) -> object:
    """The value with one place in it changed, left out, doubled or given to another name."""
    if isinstance(value, dict) and value and source.random() < 0.9:
        name = source.choice(sorted(value))
        found = dict(value)
        action = source.randrange(8)
        if action == 0:
            del found[name]
        elif action == 1:
            found[source.choice(ODD_TEXTS)] = found.pop(name)
        elif action == 2:
            found[name] = found[source.choice(sorted(found))]
        else:
            found[name] = damaged(source, found[name])
        return found
    if isinstance(value, list) and value and source.random() < 0.9:
        at, found = source.randrange(len(value)), list(value)
        action = source.randrange(8)
        if action == 0:
            del found[at]
        elif action == 1:
            found.insert(at, found[source.randrange(len(found))])
        else:
            found[at] = damaged(source, found[at])
        return found
    if isinstance(value, int) and source.random() < 0.5:
        return value + source.choice((-1, 1, 2, 1 << 20, 1 << 31, 1 << 62))
    return odd(source)


def damaged_bytes(source: random.Random, content: bytes) -> bytes:
    """The bytes with some of them changed, left out or inserted, or with the end cut off."""
    found = bytearray(content)
    for _ in range(source.randrange(1, 4)):
        at = source.randrange(len(found) + 1)
        action = source.randrange(5)
        if action == 0:
            del found[at:]
        elif action == 1:
            del found[at : at + source.randrange(1, 9)]
        elif action == 2:
            found[at:at] = source.randbytes(source.randrange(1, 9))
        elif action == 3:
            found[at : at + 4] = struct.pack("<f", source.choice((np.nan, np.inf, -np.inf, 3e38, 1e-45, 0)))
        else:
            found[at : at + 1] = bytes([source.randrange(256)])
    return bytes(found)
