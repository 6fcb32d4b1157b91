"""Words of the interface: labels in title case, tooltips as sentences without a full stop, as in Blender itself."""

import re

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import paradesc  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.ui import settings_panel  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")

# Words in lower case within a label, and names that are spelled so.
SMALL = {"a", "an", "and", "at", "by", "for", "from", "in", "of", "on", "or", "over", "the", "to", "with"}
SYMBOLS = {"k", "k1", "k2", "glTF"}


def classes():
    """Every class that the add-on registers, its settings included."""
    found = [cls for module in paradesc.modules() for cls in module.classes]
    return [*found, bpy.types.PropertyGroup.bl_rna_get_subclass_py("PARADESC_PG_settings")]


def fields():
    """Names and members of all settings and of all options of operators."""
    for cls in classes():
        properties = rna_of(cls).properties
        for name in getattr(cls, "__annotations__", {}):
            if name in properties:
                yield f"{cls.__name__}.{name}", properties[name]


def rna_of(cls):
    """What Blender shows of a class; of operators only their own options, one of which may be called name."""
    if not issubclass(cls, bpy.types.Operator):
        return cls.bl_rna
    return getattr(bpy.ops.paradesc, cls.bl_idname.removeprefix("paradesc.")).get_rna_type()


def items():
    """Names and items of all menus of choices."""
    for name, field in fields():
        for item in getattr(field, "enum_items", ()):
            yield f"{name}.{item.identifier}", item


def is_title(label):
    """Whether every word begins with a capital, a digit or a sign, except small words within."""
    words = re.findall(r"[^\W\d_][\w']*", label)
    for index, word in enumerate(words):
        inside = 0 < index < len(words) - 1
        if not (word[0].isupper() or word in SYMBOLS or (inside and word in SMALL) or f"% {word}" in label):
            return False
    return bool(words)


def is_tooltip(text):
    """Whether it begins as a sentence and ends without a full stop."""
    return (text[:1].isupper() or not text[:1].isalpha()) and text[-1:] not in {"", ".", ",", ";", ":"}


def test_title_case_is_told_from_others():
    assert all(map(is_title, ["Mean Curvature", "Wait for Values", "% of Diagonal", "PNG, 16 Bits", "Copies for glTF"]))
    assert not any(map(is_title, ["Mean curvature", "Wait For values", "Map of", "over Seams", ""]))


def test_labels_of_settings_operators_and_panels_are_in_title_case():
    wrong = [f"{name}: {field.name}" for name, field in fields() if not is_title(field.name)]
    wrong += [f"{name}: {item.name}" for name, item in items() if not is_title(item.name)]
    labels = {cls.__name__: cls.bl_label for cls in classes() if hasattr(cls, "bl_label")}
    assert wrong + [f"{name}: {label}" for name, label in labels.items() if not is_title(label)] == []


def test_tooltips_begin_as_sentences_and_end_without_a_full_stop():
    shown = [(name, field.description) for name, field in fields()]
    shown += [(name, item.description) for name, item in items()]
    shown += [(cls.__name__, (cls.__doc__ or "").strip()) for cls in classes() if issubclass(cls, bpy.types.Operator)]
    assert [f"{name}: {text}" for name, text in shown if not is_tooltip(text)] == []


def test_descriptors_and_their_groups_are_named_so_too():
    for row in bridge.descriptors():
        assert is_title(row.label), row.label
        assert is_tooltip(row.description), row.description
    assert all(is_title(title) for title, _ in settings_panel.descriptor_groups())
