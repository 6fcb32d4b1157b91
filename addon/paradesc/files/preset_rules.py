"""The rules for presets, which follow from core/members.py, the meaning of presets, and the built-in presets.

The rules are the same with and without Blender, so that one file always means one computation. Never imports bpy.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace

from ..core import choices, members
from ..core.color_maps import Look
from ..core.job import Settings
from ..core.members import Member
from . import preset_file
from .preset_file import Content, Rules

# These belong to the machine or to an object and not to a purpose, or say where results go.
NO_PRESET = {"backend", "device_index", "material_maps", "space", "shape_key", "cage"}


# ---- Our own


@dataclass(frozen=True)
class Preset:
    """A built-in preset: settings and colors that differ from the defaults, image settings, and the purpose."""

    label: str
    purpose: str
    members: dict[str, object] = field(default_factory=dict)
    colors: dict[str, object] = field(default_factory=dict)
    image: dict[str, object] = field(default_factory=dict)

    def content(self) -> Content:
        """The preset in the form of a preset file."""
        settings = {name: preset_file.plain(value) for name, value in self.members.items()}
        return Content(self.label, self.purpose, settings, self.colors, self.image)


FITTED = {"radius_fit": "medium"}
# The first four are masks, which stand at the top of the panel.
PRESETS = {
    "cavity": Preset(
        "Cavity",
        "Grooves and dents, from 0 to 1: a mask for dirt, or to darken a color with",
        {"descriptors": {"cavity"}, **FITTED},
    ),
    "edge_wear": Preset(
        "Edge Wear",
        "Edges and tips that stand out, from 0 to 1: a mask for worn paint or bare metal",
        {"descriptors": {"convexity"}, **FITTED},
    ),
    "curvature": Preset(
        "Curvature",
        "Mean and Gaussian curvature, with sign: where and how strongly the surface bends",
        {"descriptors": {"mean_curvature", "gaussian_curvature"}, **FITTED},
    ),
    "openness": Preset(
        "Openness",
        "Openness of the space around each point, 0.5 on a plane: a mask for dust, or for soft light and shade",
        {"descriptors": {"ambient_openness"}, **FITTED},
    ),
    "shape_classes": Preset(
        "Shape Classes",
        "Cup, rut, saddle, ridge or cap by the shape index, and its strength by the curvedness",
        {"descriptors": {"shape_index", "curvedness"}, "radius_percent": 3.0},
    ),
    "corners": Preset(
        "Corners",
        "Corner points: the Harris response, and 1 at each corner in harris_corner",
        {"descriptors": {"harris"}, "radius_percent": 3.0, "samples": 64},
    ),
}


# ---- Rules


def setting_members() -> dict[str, Member]:
    """The settings that a preset contains, without colors and images."""
    groups = [group for group in members.GROUPS if group != members.output_members]
    return {name: member for group in groups for name, member in group().items() if name not in NO_PRESET}


def image_members() -> dict[str, Member]:
    """The image settings that a preset contains: kind and size, but never whether or where files are written."""
    return {
        name: member
        for name, member in members.output_members().items()
        if member.kind != "text" and not name.startswith("write_") and name not in NO_PRESET
    }


def rules() -> Rules:
    """The rule of each member, by section."""
    settings = setting_members()
    # A preset without a radius fit has the radius that it names, or the default.
    settings["radius_fit"] = replace(settings["radius_fit"], words={**settings["radius_fit"].words, "default": "typed"})
    return {"settings": settings, "colors": members.color_members(), "image": image_members()}


# ---- Checking


def sound(path: Path) -> Content:
    """Reads a preset and checks all of it; raises PresetError if anything is wrong."""
    content = preset_file.read(path)
    check(path, content)
    return content


def check(path: Path, content: Content) -> None:
    """Raises PresetError if a member is unknown, has a forbidden value, or contradicts another member."""
    known = rules()
    preset_file.check(path, content, known)
    for section, fault in (("settings", choices.settings_fault), ("colors", choices.look_fault)):
        given = getattr(content, section)
        if given is None:
            continue
        whole = preset_file.completed(given, known[section])
        sentence = fault(SimpleNamespace(**preset_file.as_kept(whole, known[section])))
        if sentence:
            preset_file.refuse(path, f"cannot be used: {sentence.rstrip('.')}")


# ---- Meaning


def settings_of(content: Content | None, base: Settings | None) -> Settings | None:
    """The settings with those of a preset, if there is one; device, space and memory limit stay."""
    if content is None:
        return base
    base = base or Settings()
    texels = (content.image or {}).get("texels", base.options.texels)
    if content.settings is None:
        return replace(base, options=replace(base.options, texels=texels))
    values = preset_file.completed(content.settings, rules()["settings"])
    machine = {"backend": base.backend, "device_index": base.device_index, "space": base.space}
    return choices.settings_of(SimpleNamespace(**values, **machine, texels=texels), base.memory_limit)


def look_of(content: Content | None, otherwise: Look | None) -> Look | None:
    """The look that a preset asks for, if there is one and it has colors."""
    if content is None or content.colors is None:
        return otherwise
    return choices.look_of(SimpleNamespace(**preset_file.completed(content.colors, rules()["colors"])))
