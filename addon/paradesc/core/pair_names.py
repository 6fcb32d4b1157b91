"""Tells by their names which meshes belong together: "crate_low" has the detail of "crate_high" and "crate_high_bolts"."""

import re
from collections.abc import Sequence

# What Blender adds to a second name is no part of it.
LOW = re.compile(r"(.+)[_ .-]low(?:\.\d{3,})?", re.IGNORECASE)


def stem_of(low: str) -> str:
    """What stands before "_low" at the end of a name; "" if it does not end so."""
    found = LOW.fullmatch(low)
    return found[1] if found else ""


def highs_of(low: str, names: Sequence[str]) -> list[str]:
    """Those of the names that give the coarse mesh of this name its detail: they go on with "_high" after the stem."""
    stem = stem_of(low)
    if not stem:
        return []
    high = re.compile(re.escape(stem) + r"[_ .-]high(?![a-z]).*", re.IGNORECASE)
    return [name for name in names if high.fullmatch(name)]


def pairs_of(names: Sequence[str]) -> dict[str, list[str]]:
    """Every coarse mesh among the names with those that give it detail, none without any."""
    found = {name: highs_of(name, names) for name in names}
    return {low: highs for low, highs in found.items() if highs}
