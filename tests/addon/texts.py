"""Every text of the add-on that users see in Blender and that its catalogs translate: from its classes and its code."""

import ast
import inspect
import re

import bpy

import paradesc
from paradesc import bridge
from paradesc.settings import research
from shapes import ADDON

PACKAGE = ADDON / "paradesc"
# The folders of what people meet in Blender.
FOLDERS = ("core", "settings", "scene", "bake", "animation", "show", "ui")
# English stays what is said on the command line and in Python alone, or before the catalogs are there, and sentences
# that are put together of parts by the rules of English: of faults of the mesh, of UV maps and of images' texels.
ENGLISH = {
    *("core/compare", "core/corners", "core/packing", "core/polygons", "core/stream", "core/tangents"),
    *("core/mesh_faults", "core/uv_faults", "core/udim", "core/transfer", "core/texel_tiles"),
    *("scene/scene_io", "scene/unwrap", "ui/failure"),
}
# Names that Blender's files keep, parts of sentences, and words between programs.
NO_TEXTS = {
    *("Paradesc", "Paradesc cavity", "Paradesc unwrap", "paradesc live", "Paradesc {0} by {1}", "{0} of {1}"),
}
CALLS = {"label", "said", "tooltip", "sentence_lines", "report", "poll_message_set", "line"}
DRAWN = {"text", "heading"}
# Signs of a sentence, or of a text that format() fills: a later word that is small, or a place in braces.
SENTENCE = re.compile(r'["“–A-Z{].*? [a-z]{2,}')
PLACE = re.compile(r"\{[^}]*\}")


def classes():
    """Every class that the add-on registers, its settings included."""
    found = [cls for module in paradesc.modules() for cls in module.classes]
    return [*found, bpy.types.PropertyGroup.bl_rna_get_subclass_py("PARADESC_PG_settings")]


def rna_of(cls):
    """What Blender shows of a class; of operators only their own options, one of which may be called name."""
    if not issubclass(cls, bpy.types.Operator):
        return cls.bl_rna
    return getattr(bpy.ops.paradesc, cls.bl_idname.removeprefix("paradesc.")).get_rna_type()


def fields():
    """Classes, names and properties of all settings and of all options of operators."""
    for cls in classes():
        properties = rna_of(cls).properties
        own = {name for base in cls.__mro__ for name in base.__dict__.get("__annotations__", {})}
        yield from ((cls, name, properties[name]) for name in properties.keys() if name in own)


def of_classes():
    """Labels of operators, panels and menus, and tooltips of buttons and menus."""
    for cls in classes():
        if hasattr(cls, "bl_label"):
            yield cls.bl_label, cls.__name__
        if issubclass(cls, (bpy.types.Operator, bpy.types.Menu)) and "description" not in dir(cls):
            yield inspect.cleandoc(cls.__doc__), cls.__name__


def of_settings():
    """Names of settings and of their choices, and tooltips, but for research and of formulas: they stay English."""
    hidden = {name for names in research.RESEARCH.values() for name in names} | {"descriptors", "map_descriptor"}
    for cls, name, field in fields():
        where = f"{cls.__name__}.{name}"
        if field.is_hidden:
            continue
        shown = [(field.name, field.description), *((item.name, item.description) for item in items(field))]
        research_only = name in hidden and issubclass(cls, bpy.types.PropertyGroup)
        for words, description in shown:
            yield words, where
            yield "" if research_only else description, where


def items(field):
    """The choices of a setting, if it has any."""
    return field.enum_items if field.type == "ENUM" else ()


def of_code():
    """The texts that Python puts together or hands on, with the module; of an f-string, with numbered places."""
    for folder in FOLDERS:
        for path in sorted((PACKAGE / folder).glob("*.py")):
            if f"{folder}/{path.stem}" not in ENGLISH:
                tree = ast.parse(path.read_text(encoding="utf-8"))
                yield from ((text, f"{folder}/{path.name}") for text in literals(tree))


def literals(tree):
    """The texts of one module that are shown, or read as sentences; those of properties have been seen in classes."""
    silent, shown = set(), set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            silent.add(node.body[0].value)
        if isinstance(node, ast.JoinedStr):
            silent.update(part for part in ast.walk(node) if part is not node and isinstance(part, ast.Constant))
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            if name.endswith("Property") or name == "member":
                silent.update(part for word in node.keywords for part in ast.walk(word.value))
            given = [*(node.args if name in CALLS else ()), *(word.value for word in node.keywords if word.arg in DRAWN)]
            shown.update(part for value in given for part in choices_of(value))
    for node in ast.walk(tree):
        text = "" if node in silent else text_of(node)
        if re.search("[A-Za-z]{2}", PLACE.sub("", text)):
            if (node in shown and not text.isupper()) or SENTENCE.match(text):
                yield text


def choices_of(node):
    """What an expression may be: both ends of a condition."""
    return [*choices_of(node.body), *choices_of(node.orelse)] if isinstance(node, ast.IfExp) else [node]


def text_of(node):
    """The text of a literal; "" of anything else."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    parts, count = [], 0
    for part in node.values if isinstance(node, ast.JoinedStr) else ():
        parts.append(part.value if isinstance(part, ast.Constant) else f"{{{count}}}")
        count += not isinstance(part, ast.Constant)
    return "".join(parts)


def collected():
    """All of it: each text with the places where it stands."""
    found = {}
    for source in (of_classes, of_settings, of_code):
        for text, where in source():
            if text and text not in NO_TEXTS:
                found.setdefault(text, []).append(where)
    for row in bridge.descriptors():
        found.setdefault(row.label, []).append("registry")
    return found
