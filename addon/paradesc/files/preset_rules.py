"""The rules for presets, which follow from core/members.py, the meaning of presets, and the built-in presets.

The rules are the same with and without Blender, so that one file always means one computation. Never imports bpy.
"""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from ..core import choices, members
from ..core.color_maps import Look
from ..core.job import Settings
from ..core.members import Member
from .preset_file import LONGEST_TEXT, Content, quoted, read, refuse

# These belong to the machine or to an object and not to a purpose, or say where results go.
NO_PRESET = {"backend", "device_index", "material_maps", "space", "shape_key", "cage"}
LARGEST_NUMBER = 3.4e38  # 32-bit floats end just above


# ---- Our own


def ours(name: str, purpose: str, *descriptors: str, **settings: object) -> Content:
    """A built-in preset: its descriptors and the settings that differ from the defaults. It has the usual colors."""
    return Content(name, purpose, {"descriptors": sorted(descriptors), **settings}, {}, {})


# The first four are masks, which stand at the top of the panel.
PRESETS = {
    "cavity": ours(
        "Cavity", "Grooves and dents, from 0 to 1: a mask for dirt, or to darken a color with",
        "cavity", radius_fit="medium",
    ),
    "edge_wear": ours(
        "Edge Wear", "Edges and tips that stand out, from 0 to 1: a mask for worn paint or bare metal",
        "convexity", radius_fit="medium",
    ),
    "curvature": ours(
        "Curvature", "Mean and Gaussian curvature, with sign: where and how strongly the surface bends",
        "mean_curvature", "gaussian_curvature", radius_fit="medium",
    ),
    "openness": ours(
        "Openness",
        "Openness of the space around each point, 0.5 on a plane: a mask for dust, or for soft light and shade",
        "ambient_openness", radius_fit="medium",
    ),
    "shape_classes": ours(
        "Shape Classes", "Cup, rut, saddle, ridge or cap by the shape index, and its strength by the curvedness",
        "shape_index", "curvedness", radius_percent=3.0,
    ),
    "corners": ours(
        "Corners", "Corner points: the Harris response, and 1 at each corner in harris_corner",
        "harris", radius_percent=3.0, samples=64,
    ),
}  # fmt: skip


# ---- Rules


def rules() -> dict[str, dict[str, Member]]:
    """The rule of each member, by section: of images the kind and size, never whether or where they are written."""
    groups = [group() for group in members.GROUPS if group != members.output_members]
    settings = {name: rule for group in groups for name, rule in group.items() if name not in NO_PRESET}
    # A preset without a radius fit has the radius that it names, or the default.
    settings["radius_fit"] = replace(settings["radius_fit"], words={**settings["radius_fit"].words, "default": "typed"})
    image = {
        name: rule
        for name, rule in members.output_members().items()
        if rule.kind != "text" and not name.startswith("write_") and name not in NO_PRESET
    }
    return {"settings": settings, "colors": members.color_members(), "image": image}


def sound(path: Path) -> Content:
    """Reads a preset and checks all of it; raises PresetError if anything is wrong."""
    content = read(path)
    check(path, content)
    return content


def check(path: Path, content: Content) -> None:
    """Raises PresetError if a member is unknown, has a forbidden value, or contradicts another member."""
    known = rules()
    for section, given in content.sections().items():
        for name, value in given.items():
            if name not in known[section]:
                refuse(path, f"has {quoted(name)} in {section}, which is not a setting; remove it or update the add-on")
            wanted = wanted_instead(known[section][name], value)
            if wanted:
                refuse(path, f"has {quoted(value)} as {quoted(name)} in {section}; give {wanted}")
    for section, fault in (("settings", choices.settings_fault), ("colors", choices.look_fault)):
        given = getattr(content, section)
        whole = as_kept(completed(given or {}, known[section]), known[section])
        sentence = "" if given is None else fault(SimpleNamespace(**whole))
        if sentence:
            refuse(path, f"cannot be used: {sentence.rstrip('.')}")


def wanted_instead(rule: Member, value: object) -> str:
    """The values that a property accepts, in words, if this value is not one of them; else ""."""
    if rule.kind in ("int", "float"):
        return wanted_number(rule, value)
    if rule.kind == "bool":
        is_sound, wanted = isinstance(value, bool), "true or false"
    elif rule.kind == "text":
        is_sound = isinstance(value, str) and value.isprintable() and len(value) <= LONGEST_TEXT
        wanted = f"a line of at most {LONGEST_TEXT} characters"
    else:
        several, names = rule.kind == "choices", [item[0] for item in rule.words["items"]]
        given = value if isinstance(value, list) else [value]
        is_sound = isinstance(value, list if several else str) and given and all(item in names for item in given)
        wanted = f"{'a list of some' if several else 'one'} of {', '.join(names)}"
    return "" if is_sound else wanted


def wanted_number(rule: Member, value: object) -> str:
    """The numbers that a property accepts, in words, or "" for this value. Floats are compared as Blender's 32 bits."""
    is_whole = rule.kind == "int"
    low, high = (-(2**31), 2**31 - 1) if is_whole else (-LARGEST_NUMBER, LARGEST_NUMBER)
    low, high = rule.words.get("min", low), rule.words.get("max", high)
    is_number = isinstance(value, int if is_whole else (int, float)) and not isinstance(value, bool)
    if is_number and abs(value) <= LARGEST_NUMBER:
        same = int if is_whole else np.float32
        if same(low) <= same(value) <= same(high):
            return ""
    bounds = [f"{word} {end:.10g}" for word, end in (("from", low), ("to", high)) if abs(end) < LARGEST_NUMBER]
    return " ".join(["a whole number" if is_whole else "a number", *bounds])


def completed(given: dict[str, object], known: dict[str, Member]) -> dict[str, object]:
    """Every property of a section; those that the preset does not name have their defaults."""
    return {name: given.get(name, rule.default) for name, rule in known.items()}


def as_kept(given: dict[str, object], known: dict[str, Member]) -> dict[str, object]:
    """The values in Blender's form: floats in 32 bits, choices as sets."""
    kinds = {"float": lambda value: float(np.float32(value)), "choices": set}
    return {name: kinds.get(known[name].kind, lambda value: value)(value) for name, value in given.items()}


def plain(value: object) -> object:
    """A value of Blender in JSON's form: floats with the fewest digits that give the same float, choices sorted."""
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    if isinstance(value, float) and abs(value) <= LARGEST_NUMBER:
        return float(str(np.float32(value)))
    return value


# ---- Meaning


def settings_of(content: Content | None, base: Settings | None) -> Settings | None:
    """The settings with those of a preset, if there is one; device, space and memory limit stay."""
    if content is None:
        return base
    base = base or Settings()
    texels = (content.image or {}).get("texels", base.options.texels)
    if content.settings is None:
        return replace(base, options=replace(base.options, texels=texels))
    values = completed(content.settings, rules()["settings"])
    machine = {"backend": base.backend, "device_index": base.device_index, "space": base.space}
    return choices.settings_of(SimpleNamespace(**values, **machine, texels=texels), base.memory_limit)


def look_of(content: Content | None, otherwise: Look | None) -> Look | None:
    """The look that a preset asks for, if there is one and it has colors."""
    if content is None or content.colors is None:
        return otherwise
    return choices.look_of(SimpleNamespace(**completed(content.colors, rules()["colors"])))
