"""Words of the interface: labels in title case, tooltips as sentences without a full stop, as in Blender itself."""

import re

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import texts  # noqa: E402

from paradesc import bridge  # noqa: E402
from paradesc_blender.ui import settings_panel  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")

# Words in lower case within a label, and names that are spelled so.
SMALL = {"a", "an", "and", "at", "by", "for", "from", "in", "of", "on", "or", "over", "the", "to", "with"}
SYMBOLS = {"k", "k1", "k2", "glTF"}


def fields():
    """Names and members of all settings and of all options of operators that people see."""
    return [(f"{cls.__name__}.{name}", field) for cls, name, field in texts.fields() if not field.is_hidden]


def items():
    """Names and items of all menus of choices."""
    return [(f"{name}.{item.identifier}", item) for name, field in fields() for item in texts.items(field)]


def is_title(label):
    """Returns whether every word begins with a capital, a digit or a sign, except small words within."""
    words = re.findall(r"[^\W\d_][\w']*", label)
    for index, word in enumerate(words):
        inside = 0 < index < len(words) - 1
        if not (word[0].isupper() or word in SYMBOLS or (inside and word in SMALL) or f"% {word}" in label):
            return False
    return bool(words)


def is_tooltip(text):
    """Returns whether it begins as a sentence and ends without a full stop."""
    return (text[:1].isupper() or not text[:1].isalpha()) and text[-1:] not in {"", ".", ",", ";", ":"}


def test_title_case_is_told_from_others():
    assert all(map(is_title, ["Mean Curvature", "Wait for Values", "% of Diagonal", "PNG, 16 Bits", "Copies for glTF"]))
    assert not any(map(is_title, ["Mean curvature", "Wait For values", "Map of", "over Seams", ""]))


def test_labels_of_settings_operators_and_panels_are_in_title_case():
    wrong = [f"{name}: {field.name}" for name, field in fields() if not is_title(field.name)]
    wrong += [f"{name}: {item.name}" for name, item in items() if not is_title(item.name)]
    labels = {cls.__name__: cls.bl_label for cls in texts.classes() if hasattr(cls, "bl_label")}
    assert wrong + [f"{name}: {label}" for name, label in labels.items() if not is_title(label)] == []


def test_tooltips_begin_as_sentences_and_end_without_a_full_stop():
    shown = [(name, field.description) for name, field in fields()]
    shown += [(name, item.description) for name, item in items()]
    operators = [cls for cls in texts.classes() if issubclass(cls, bpy.types.Operator)]
    shown += [(cls.__name__, (cls.__doc__ or "").strip()) for cls in operators]
    assert [f"{name}: {text}" for name, text in shown if not is_tooltip(text)] == []


def test_descriptors_and_their_groups_are_named_so_too():
    for row in bridge.descriptors():
        assert is_title(row.label), row.label
        assert is_tooltip(row.description), row.description
    assert all(is_title(title) for title, _ in settings_panel.descriptor_groups())
