"""Tells by names which meshes belong together: "crate_low" has the detail of "crate_high" and "crate_high_bolts"."""

import re
from collections.abc import Iterable

# What Blender adds to a second name is no part of it. Words that only begin so, such as "highlight", do not count.
LOW = re.compile(r"(.+)[_ .-]low(?:\.\d{3,})?", re.IGNORECASE)
HIGH = re.compile(r"[_ .-]high(?![a-z])", re.IGNORECASE)


def is_one_of_a_pair(name: str) -> bool:
    """Whether a name has one of the marks, at all."""
    return bool(LOW.fullmatch(name) or HIGH.search(name))


def pairs_of(names: Iterable[str]) -> dict[str, list[str]]:
    """Every coarse mesh among the names with those that give it detail, none without any."""
    highs: dict[str, list[str]] = {}
    lows: dict[str, str] = {}
    for name in names:
        if found := LOW.fullmatch(name):
            lows[name] = found[1].lower()
        for mark in HIGH.finditer(name):
            highs.setdefault(name[: mark.start()].lower(), []).append(name)
    return {low: highs[stem] for low, stem in lows.items() if stem in highs}
