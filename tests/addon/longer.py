"""A translation into words that are longer, as those of other languages are, for whatever the add-on shows."""

import ast
import re

import bpy

from paradesc import bridge
from shapes import PACKAGES

# German and French texts are longer by this factor, as a rule of thumb.
FACTOR = 1.4


def constants() -> set[str]:
    """Every text in the code of the add-on, docstrings too."""
    found = set()
    for path in (path for package in PACKAGES for path in package.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found |= {
            node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
    return found


def shown() -> set[str]:
    """Every text that Blender looks up for the add-on: those of the code, of the native library and of its classes."""
    found = constants()
    for row in bridge.descriptors():
        found |= {row.label, row.description}
    for name in ("Operator", "Panel", "Menu"):
        found |= {getattr(cls, "bl_label", "") for cls in getattr(bpy.types, name).__subclasses__()}
    return {text for text in found if re.search(r"[A-Za-z]{2}", text)}


def lengthened(text: str) -> str:
    """The text with longer words; what stands in braces stays."""

    def longer(word: re.Match) -> str:
        found = word[0]
        return found if found.startswith("{") else found + found[: round((FACTOR - 1) * len(found))].lower()

    return re.sub(r"\{[^}]*\}|[^\W\d_]{2,}", longer, text)
