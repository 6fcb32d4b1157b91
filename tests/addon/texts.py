"""Every text of the add-on that users see in Blender and that its catalogs translate: from its classes and its code."""

import ast
import inspect
import re

import bpy

import paradesc_blender
from paradesc import bridge
from paradesc_blender.scene import targets
from paradesc_blender.settings import research
from shapes import PACKAGES

# The folders of what people meet in Blender.
FOLDERS = ("core", "settings", "scene", "bake", "animation", "show", "ui")
# English stays what is said on the command line and in Python alone, or before the catalogs are there; so do sentences
# that have English words in their places.
ENGLISH = {
    *("core/compare", "core/corners", "core/packing", "core/polygons", "core/stream", "core/tangents"),
    *("scene/scene_io", "scene/unwrap", "ui/failure"),
}
PARTS = {
    "Images of {0} × {1} texels from high to low need about {2} GB of memory, and ",
    "{0} GB may be used ({1}); ",
    "the memory limit",
    "The {0} {1} ignored on the processor.",
    "The {0} has no path; give one under Output.",
    "Save the .blend first, or give the {0} a whole path: // stands for its folder.",
}
# Texts that Blender's files and programs read, that the command line says of arrays, and that nobody sees.
NO_TEXTS = {
    *("Paradesc", "Paradesc Cavity", "Paradesc Cavity of mean_curvature", "Paradesc {0} by {1}", "{0} of {1}"),
    *("Paradesc unwrap", "paradesc live", "The native library is missing", "Paradesc's settings of one scene."),
    # how Python shows a profile
    *("{0} radii from {1} to {2}", "expected error {0}, the least, at the radius {1}", "{0} vertices, {1}: {2}"),
    "The arrays have no UV coordinates; give them, or choose the backend cpu or reference, which need none.",
}
CALLS = {"label", "said", "tooltip", "sentence_lines", "report", "can_run", "line"}
DRAWN = {"text", "heading"}
# Signs of a sentence, or of a text that format() fills: a later word that is small, or a place in braces.
SENTENCE = re.compile(r'(["“–A-Z{]|has |its |the |measure |sizes |; ).*? [a-z]{2,}|has [a-z]+')
PLACE = re.compile(r"\{[^}]*\}")
# And of a label, in the folders where such words are not the names of nodes and sockets.
LABEL = re.compile("[A-Z][a-z]+( ([A-Z][a-z]+|of|to|with))*")
LABELLED = ("settings", "bake", "animation", "ui")


def folder_at(name):
    """A folder of either package."""
    return next(package / name for package in PACKAGES if (package / name).is_dir())


def classes():
    """Every class that the add-on registers, its settings included."""
    found = [cls for module in paradesc_blender.modules() for cls in module.classes]
    return [*found, bpy.types.PropertyGroup.bl_rna_get_subclass_py("PARADESC_PG_settings")]


def rna_of(cls):
    """The properties of a class that Blender shows; for operators only their own options, which may be called name."""
    if not issubclass(cls, bpy.types.Operator):
        return cls.bl_rna
    return getattr(bpy.ops.paradesc, cls.bl_idname.removeprefix("paradesc.")).get_rna_type()


def fields():
    """Classes, names and properties of all settings and of all options of operators."""
    for cls in classes():
        properties = rna_of(cls).properties
        own = {name for base in cls.__mro__ for name in base.__dict__.get("__annotations__", {})}
        own -= set() if issubclass(cls, bpy.types.Operator) else {"name"}  # which every group has from Blender
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
    for cls, name, field in fields():
        if not field.is_hidden:
            where = f"{cls.__name__}.{name}"
            for words in (field.name, *(item.name for item in items(field))):
                yield words, where
            for description in () if is_for_research(cls, name) else descriptions(field):
                yield description, where


def is_for_research(cls, name):
    """Returns whether a setting is drawn for research alone, or lists the descriptors, whose tooltips are formulas."""
    hidden = {name for names in research.RESEARCH.values() for name in names} | {"descriptors", "map_descriptor"}
    return name in hidden and issubclass(cls, bpy.types.PropertyGroup)


def descriptions(field):
    """The tooltips of a setting and of its choices."""
    return [field.description, *(item.description for item in items(field))]


def items(field):
    """The choices of a setting, if it has any."""
    return field.enum_items if field.type == "ENUM" else ()


def of_code():
    """The texts that Python puts together or hands on, with the module; of an f-string, with numbered places."""
    seen = {text for _, _, field in fields() for text in (field.name, *descriptions(field))}
    for folder in FOLDERS:
        for path in sorted(folder_at(folder).glob("*.py")):
            if f"{folder}/{path.stem}" not in ENGLISH:
                tree = ast.parse(path.read_text(encoding="utf-8"))
                yield from ((text, f"{folder}/{path.name}") for text in literals(tree, folder) if text not in seen)


def literals(tree, folder):
    """The texts of one module that are shown, or read as sentences; those of properties have been seen in classes."""
    silent, shown = set(), set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            silent.add(node.body[0].value)
        if isinstance(node, ast.JoinedStr):
            silent.update(part for part in node.values if isinstance(part, ast.Constant))
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            if name.endswith("Property") or name == "member":
                silent.update(part for word in node.keywords for part in ast.walk(word.value))
            given = [word.value for word in node.keywords if word.arg in DRAWN] + node.args * (name in CALLS)
            shown.update(part for value in given for part in choices_of(value))
    for node in ast.walk(tree):
        text = "" if node in silent else text_of(node)
        if re.search("[A-Za-z]{2}", PLACE.sub("", text)):
            is_label = folder in LABELLED and LABEL.fullmatch(text)
            if is_label or SENTENCE.match(text) or (node in shown and not text.isupper()):
                yield text


def choices_of(node):
    """The values that an expression may have: both ends of a condition."""
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
            if text and text not in NO_TEXTS | PARTS:
                found.setdefault(text, []).append(where)
    for row in bridge.descriptors():
        found.setdefault(row.label, []).append("registry")
    kinds = bpy.types.Object.bl_rna.properties["type"].enum_items
    for kind in targets.CONVERTIBLE:
        found.setdefault(kinds[kind].name, []).append("scene/targets.py")
    return found
