"""Compares two folders of compute.py: prints a table of values whose bits differ, and ends with 1 if there are any.

Usage: compare.py OLD NEW [--rows N] [--json FILE]
"""

import argparse
import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np


@dataclass
class Difference:
    """An array that differs."""

    mesh: str
    case: str
    what: str
    values: int  # that differ
    of: int
    largest: float  # difference, of values that are finite in both
    span: float  # of the old ones
    nan: int  # of those that differ, NaN in one of them alone


@dataclass
class Count:
    """The result for one mesh."""

    mesh: str
    cases: int = 0
    arrays: int = 0
    values: int = 0
    differing: int = 0
    sentences: int = 0


def unequal(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """The flat indices at which bits differ; all of them if shape or type differ."""
    if old.shape != new.shape or old.dtype != new.dtype:
        return np.ones(max(old.size, 1), bool)
    if not old.size:
        return np.zeros(0, bool)
    bits = [np.ascontiguousarray(array).reshape(-1).view(np.uint8) for array in (old, new)]
    return (bits[0] != bits[1]).reshape(old.size, -1).any(axis=1)


def difference(mesh: str, key: str, old: np.ndarray, new: np.ndarray, apart: np.ndarray) -> Difference:
    """How far the differing values are apart."""
    case, what = key.split(" | ")
    found = Difference(mesh, case, what, int(apart.sum()), int(apart.size), np.nan, np.nan, 0)
    if old.shape != new.shape or old.dtype.kind not in "fiub" or not old.size:
        return found
    before, after = old.reshape(-1).astype(np.float64), new.reshape(-1).astype(np.float64)
    found.nan = int((np.isnan(before) != np.isnan(after)).sum())
    both = np.isfinite(before) & np.isfinite(after)
    if both.any():
        found.largest = float(np.abs(before - after)[both].max())
        found.span = float(np.ptp(before[np.isfinite(before)]))
    return found


def compare(mesh: str, old: Path, new: Path) -> tuple[Count, list[Difference], list[str]]:
    """Compares one mesh: counts, arrays and sentences that differ. Entries that only the new tree has do not count."""
    count, differences, sentences = Count(mesh), [], []
    with np.load(old) as before, np.load(new) as after:
        names = set(after.files)
        count.cases = len({key.split(" | ")[0] for key in before.files})
        for key in before.files:
            one = before[key]
            other = after[key] if key in names else np.zeros(0, np.void)
            apart = unequal(one, other)
            if "| sentence" in key:
                if apart.any():
                    count.sentences += 1
                    sentences.append(f"{mesh}, {key}:\n    {bytes(one).decode()}\n    {bytes(other).decode()}")
                continue
            count.arrays += 1
            count.values += one.size
            if apart.any():
                found = difference(mesh, key, one, other, apart)
                count.differing += found.values
                differences.append(found)
    return count, differences, sentences


def line(item: Difference) -> str:
    """The line of the table for an array that differs."""
    share = f"{100 * item.largest / item.span:.3g} % of the span" if item.span > 0 else f"{item.largest:.3g}"
    nan = f", {item.nan} NaN in one alone" if item.nan else ""
    return f"  {item.mesh}, {item.case}: {item.what}: {item.values:,d} of {item.of:,d}, by up to {share}{nan}\n"


def main() -> int:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--rows", type=int, default=40, help="arrays that differ to name")
    parser.add_argument("--json", type=Path, help="all that differ")
    parser.add_argument("--only", default="")
    asked = parser.parse_args()
    out = sys.stdout.write
    only = set(filter(None, asked.only.split(",")))
    counts, differences, sentences = [], [], []
    out(f"{'mesh':28s} {'cases':>6s} {'arrays':>8s} {'values':>14s} {'differ':>12s} {'sentences':>10s}\n")
    for path in sorted(asked.old.glob("*.npz")):
        if only and path.stem not in only:
            continue
        count, found, words = compare(path.stem, path, asked.new / path.name)
        counts.append(count)
        differences += found
        sentences += words
        out(f"{count.mesh:28s} {count.cases:6d} {count.arrays:8,d} {count.values:14,d}")
        out(f" {count.differing:12,d} {count.sentences:10d}\n")
    values, differing = sum(count.values for count in counts), sum(count.differing for count in counts)
    worst = sorted(differences, key=lambda item: -item.values)
    out("".join(map(line, worst[: asked.rows])))
    out(f"  and {len(worst) - asked.rows} arrays more\n" if len(worst) > asked.rows else "")
    out("".join(f"  other words: {sentence}\n" for sentence in sentences[:10]))
    out(f"{values:,d} values of {len(counts)} meshes compared, {differing:,d} differ\n")
    if asked.json:
        asked.json.write_text(json.dumps([asdict(item) for item in worst], indent=1))
    return int(differing > 0 or values == 0)


if __name__ == "__main__":
    sys.exit(main())
