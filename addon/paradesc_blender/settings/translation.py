"""The language of the interface: the texts in translations/, which Blender looks up in a context of our own.

In its default context Blender's own dictionary would win, and it contains single words of ours: in French it would
translate one button of four. Blender looks up every label and tooltip by itself, as it stands in the code.
"""

import json
import re
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path

import bpy

ADDON = __package__.rpartition(".")[0]
FOLDER = Path(__file__).resolve().parents[1] / "translations"
CONTEXT = "Paradesc"
# Blender looks up tooltips and reports in the default context, whatever the class says.
CONTEXTS = (CONTEXT, bpy.app.translations.contexts.default)
# The locales of each file: "de" stands for "de_DE" too, and Blender 4 has renamed zh_CN.
LANGUAGES = {"de": ("de",), "ja": ("ja",), "zh": ("zh_CN", "zh_HANS")}
# In Blender 3.4 properties have no context, so a single word in a menu may come from Blender's dictionary.
HAS_CONTEXT = "translation_context" in bpy.props.BoolProperty.__doc__
HOLE = re.compile(r"\{\d+\}")

look_up = bpy.app.translations.pgettext_iface
look_up_tooltip = bpy.app.translations.pgettext_tip
# Blender before 4.1 treats reports as tooltips.
look_up_report = getattr(bpy.app.translations, "pgettext_rpt", look_up_tooltip)


def label(text: str) -> str:
    """A label or a sentence in the language of the interface; format() fills its braces afterwards."""
    return translated(text, look_up)


def said(sentence: str) -> str:
    """A sentence of an operator's report, in the language of reports; format() fills its braces afterwards."""
    return translated(sentence, look_up_report)


def tooltip(text: str) -> str:
    """A tooltip, or a reason why a button is grey, in the language of tooltips."""
    return translated(text, look_up_tooltip)


def can_run(operator: type, obstacle: str) -> bool:
    """Tells whether an operator has no obstacle. The sentence about one becomes the tooltip of its grey button."""
    if obstacle:
        operator.poll_message_set(tooltip(obstacle))
    return not obstacle


def translated(text: str, look: Callable[[str, str], str]) -> str:
    """The translation of a text by one of Blender's dictionaries; names and numbers may be filled in already.

    A filled-in part may be a sentence or label, which is translated too; a part in quotes is a name and stays.
    """
    found = matched(text)
    if found is None:
        return look(text, CONTEXT)
    template, parts = found
    shown = [
        part if f'"{{{number}}}"' in template or not any(map(str.isalpha, part)) else translated(part, look)
        for number, part in enumerate(parts)
    ]
    return look(template, CONTEXT).format(*shown)


@lru_cache(maxsize=4096)
def matched(sentence: str) -> tuple[str, tuple[str, ...]] | None:
    """The catalogs' text that a sentence was made from, and the parts in its places {0}, {1} …; None without one."""
    for template, pattern in templates():
        found = pattern.fullmatch(sentence)
        if found is not None and sentence != template:
            return template, found.groups()
    return None


@cache
def templates() -> list[tuple[str, re.Pattern[str]]]:
    """The catalogs' texts with numbered places, the most specific first, with patterns for sentences made from them."""
    known = {text for name in LANGUAGES for text in catalog(name) if HOLE.search(text)}
    patterns = {text: re.compile("(.*)".join(map(re.escape, HOLE.split(text))), re.DOTALL) for text in known}
    return sorted(patterns.items(), key=lambda row: (-len(HOLE.sub("", row[0])), row[0]))


def catalog(name: str) -> dict[str, str]:
    """The texts of one language, by the texts in the code; empty if the file is missing or broken."""
    try:
        return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def in_our_context(cls: type) -> type:
    """Makes Blender look up a class's label, its properties and their choices in our context."""
    if issubclass(cls, (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu)):
        cls.bl_translation_context = CONTEXT
    for base in cls.__mro__ if HAS_CONTEXT else ():
        for made in base.__dict__.get("__annotations__", {}).values():
            if hasattr(made, "keywords"):
                made.keywords["translation_context"] = CONTEXT
    return cls


classes = ()


def register() -> None:
    """Registers the catalogs with Blender."""
    texts = {
        language: {(context, text): translated for context in CONTEXTS for text, translated in catalog(name).items()}
        for name, languages in LANGUAGES.items()
        for language in languages
    }
    unregister()  # a failed start may have left catalogs registered
    bpy.app.translations.register(ADDON, texts)


def unregister() -> None:
    """Removes the catalogs."""
    bpy.app.translations.unregister(ADDON)
