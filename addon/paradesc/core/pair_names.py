"""Finds meshes that belong together by name: "crate_low" takes detail from "crate_high" and "crate_high_bolts"."""

import re
from collections.abc import Iterable

# Numbers that Blender adds to duplicate names are ignored. Longer words such as "highlight" do not count as marks.
LOW = re.compile(r"(.+)[_ .-]low(?:\.\d{3,})?", re.IGNORECASE)
HIGH = re.compile(r"[_ .-]high(?![a-z])", re.IGNORECASE)


def is_one_of_a_pair(name: str) -> bool:
    """Returns whether a name contains one of the marks."""
    return bool(LOW.fullmatch(name) or HIGH.search(name))


def pairs_of(names: Iterable[str]) -> dict[str, list[str]]:
    """Every low-poly name with the names of its detailed meshes; low-poly names without any are left out."""
    highs: dict[str, list[str]] = {}
    lows: dict[str, str] = {}
    for name in names:
        if found := LOW.fullmatch(name):
            lows[name] = found[1].lower()
        for mark in HIGH.finditer(name):
            highs.setdefault(name[: mark.start()].lower(), []).append(name)
    return {low: highs[stem] for low, stem in lows.items() if stem in highs}
