"""Turns the lines of text files into rows of numbers, all at once if every line is valid. Never imports bpy."""

import re
import warnings
from dataclasses import dataclass

import numpy as np

MARK = b"\xef\xbb\xbf"  # by which some programs begin text in UTF-8
# C libraries of Windows write these words where there is no number.
NO_NUMBER = re.compile(rb"[+-]?(?:\d\.#(?:IND|QNAN|SNAN)\w*|nan\(\w*\))", re.IGNORECASE)
INFINITE = re.compile(rb"\d\.#INF\w*", re.IGNORECASE)


@dataclass
class Rows:
    """Rows of numbers, of any lengths."""

    values: np.ndarray  # (n,) all of them, one row after the other
    starts: np.ndarray  # (row_count + 1,) int64 where each begins

    @property
    def sizes(self) -> np.ndarray:
        """(row_count,) int64 how many numbers each has."""
        return np.diff(self.starts)

    def first(self, width: int) -> np.ndarray:
        """(row_count, width) the numbers that each row begins with, which has to have as many."""
        return self.values[self.starts[:-1, None] + np.arange(width)]


def plain(content: bytes) -> bytes:
    """The text without its byte order mark, with Unix line ends, and with nan and inf for the words of Windows."""
    content = content.removeprefix(MARK)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b".#" in content or b"(" in content:
        content = INFINITE.sub(b"inf", NO_NUMBER.sub(b"nan", content))
    return content


def rows_of(lines: list[bytes], kind: type = np.float64) -> Rows:
    """The numbers of lines; raises ValueError with the first line that has anything else."""
    sizes = np.fromiter((len(line.split()) for line in lines), np.int64, len(lines))
    values = numbers_in(b"\n".join(lines), kind)
    if values is None or len(values) != sizes.sum():
        wrong = lines[first_fault(lines, kind)]
        raise ValueError(f'"{shown(wrong)}" {no_numbers(wrong)}')
    return Rows(values, np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64))


def numbers_in(text: bytes, kind: type = np.float64) -> np.ndarray | None:
    """(n,) numbers between blanks, or None if anything else stands there."""
    if not text.strip():
        return np.empty(0, kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # by which numpy says that it stopped at such a place
        try:
            return np.fromstring(text, kind, sep=" ")
        except (ValueError, DeprecationWarning, OverflowError):
            return None


def is_numeric(line: bytes, kind: type = np.float64) -> bool:
    """Returns whether a line holds numbers only."""
    found = numbers_in(line, kind)
    return found is not None and len(found) == len(line.split())


def first_fault(lines: list[bytes], kind: type = np.float64) -> int:
    """The index of the first line with anything but numbers; 0 if none is found."""
    return next((place for place, line in enumerate(lines) if not is_numeric(line, kind)), 0)


def no_numbers(line: bytes) -> str:
    """A sentence's end about a line that contains anything but numbers."""
    return "is not a row of numbers" + ("; decimals take a point" if b"," in line else "")


def shown(line: bytes) -> str:
    """The line in a form that fits into a sentence."""
    return " ".join(line.decode("utf-8", "replace").split())[:60]
