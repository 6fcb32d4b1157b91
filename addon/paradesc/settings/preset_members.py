"""Which properties presets set, what those may be, and how a preset is applied to a scene and taken from one.

All rules follow from the properties' definitions, so they hold whether or not the add-on is registered.
"""

from pathlib import Path
from types import SimpleNamespace

import bpy

from ..bridge import ParadescError
from ..files import preset_file
from ..files.old_presets import read_any
from ..files.preset_file import Content, Rule, Rules
from . import looks, properties

# These belong to the machine or to an object and not to a purpose, or say where results go.
NO_PRESET = {"backend", "device_index", "material_maps", "space", "shape_key", "cage"}
COLORS = ("color_map", "span", "percentile", "symmetric", "minimum", "maximum", "use_neutral", "neutral")
KINDS = {
    bpy.props.BoolProperty: "bool",
    bpy.props.IntProperty: "int",
    bpy.props.FloatProperty: "float",
    bpy.props.StringProperty: "text",
    bpy.props.EnumProperty: "choice",
}
NOTHING = {"bool": False, "int": 0, "float": 0.0, "text": ""}


def members() -> list[str]:
    """Names of the settings that a preset sets, without colors and images."""
    return list(setting_definitions())


def setting_definitions() -> dict[str, object]:
    """Definitions of the settings that a preset sets."""
    groups = [group for group in properties.GROUPS if group != properties.output_members]
    return {name: member for group in groups for name, member in group().items() if name not in NO_PRESET}


def image_definitions() -> dict[str, object]:
    """Definitions of what a preset says of images: their kind and size, never whether and where files are written."""
    return {
        name: member
        for name, member in properties.output_members().items()
        if member.function != bpy.props.StringProperty and not name.startswith("write_") and name not in NO_PRESET
    }


def rules() -> Rules:
    """What each member of each section may be."""
    colors = looks.PARADESC_PG_looks.__annotations__
    found = {
        "settings": setting_definitions(),
        "colors": {name: colors[name] for name in COLORS},
        "image": image_definitions(),
    }
    return {section: rules_of(definitions) for section, definitions in found.items()}


def rules_of(definitions: dict[str, object]) -> dict[str, Rule]:
    """The rules that properties follow by their definitions."""
    return {name: rule_of(member.function, member.keywords) for name, member in definitions.items()}


def rule_of(function: object, words: dict) -> Rule:
    """The rule of one property."""
    kind = KINDS[function]
    choices = tuple(item[0] for item in words.get("items", ()))
    if "ENUM_FLAG" in words.get("options", ()):
        return Rule("choices", sorted(words["default"]), choices=choices)
    default = words.get("default", NOTHING[kind] if kind in NOTHING else choices[0])
    bounds = {name: words[short] for name, short in (("minimum", "min"), ("maximum", "max")) if short in words}
    if kind == "int":
        bounds = {"minimum": -(2**31), "maximum": 2**31 - 1, **bounds}
    return Rule(kind, default, **bounds, choices=choices)


# ---- Checking


def sound(path: Path) -> Content:
    """Reads a preset and checks all of it; raises PresetError."""
    content = read_any(path)
    check(path, content)
    return content


def check(path: Path, content: Content) -> None:
    """Raises PresetError if any member is unknown or may not be what it is, also together with others."""
    known = rules()
    preset_file.check(path, content, known)
    for section, fault in (("settings", settings_fault), ("colors", looks.fault)):
        given = getattr(content, section)
        if given is None:
            continue
        whole = preset_file.completed(given, known[section])
        sentence = fault(SimpleNamespace(**preset_file.as_kept(whole, known[section])))
        if sentence:
            preset_file.refuse(path, f"cannot be used: {sentence.rstrip('.')}")


def settings_fault(group: object) -> str:
    """One sentence about what is wrong with settings that each are within their limits, or ""."""
    try:
        properties.more_radii(group)
    except ParadescError as error:
        return error.sentence
    return ""


# ---- Scenes


def apply(scene: bpy.types.Scene, content: Content) -> None:
    """Applies a sound preset: settings and colors that it does not name get their default, images stay as they are.

    A value is set only if it differs, because setting one color makes live values recolor.
    """
    known = rules()
    if content.settings is not None:
        for name in known["settings"]:
            scene.paradesc.property_unset(name)
        set_members(scene.paradesc, content.settings, known["settings"])
    if content.colors is not None:
        whole = preset_file.completed(content.colors, known["colors"])
        set_members(scene.paradesc_looks, whole, known["colors"])
    if content.image is not None:
        set_members(scene.paradesc, content.image, known["image"])


def set_members(group: bpy.types.PropertyGroup, values: dict[str, object], known: dict[str, Rule]) -> None:
    """Sets what differs."""
    for name, value in preset_file.as_kept(values, known).items():
        if getattr(group, name) != value:
            setattr(group, name, value)


def content_of(scene: bpy.types.Scene, name: str, purpose: str = "") -> Content:
    """A scene's settings, colors and image settings as a preset."""
    groups = {"settings": scene.paradesc, "colors": scene.paradesc_looks, "image": scene.paradesc}
    sections = {
        section: {member: preset_file.plain(getattr(groups[section], member)) for member in known}
        for section, known in rules().items()
    }
    return Content(name, purpose, **sections)
