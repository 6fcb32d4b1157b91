"""Applies presets to a scene, and creates presets from a scene's settings."""

import bpy

from paradesc.core.members import Member
from paradesc.files import preset_file, preset_rules
from paradesc.files.preset_file import Content


def apply(scene: bpy.types.Scene, content: Content) -> None:
    """Applies a valid preset. Settings and colors that it does not name get their defaults; images keep theirs.

    A value is set only if it differs, because setting a color makes live values recolor.
    """
    known = preset_rules.rules()
    if content.settings is not None:
        for name in known["settings"]:
            scene.paradesc.property_unset(name)
        set_members(scene.paradesc, {"radius_fit": "typed", **content.settings}, known["settings"])
    if content.colors is not None:
        whole = preset_file.completed(content.colors, known["colors"])
        set_members(scene.paradesc_looks, whole, known["colors"])
    if content.image is not None:
        set_members(scene.paradesc, content.image, known["image"])


def set_members(group: bpy.types.PropertyGroup, values: dict[str, object], known: dict[str, Member]) -> None:
    """Sets the values that differ. radius_fit comes last, because setting a radius marks it as typed."""
    kept = preset_file.as_kept(values, known)
    for name in sorted(kept, key="radius_fit".__eq__):
        if getattr(group, name) != kept[name]:
            setattr(group, name, kept[name])


def content_of(scene: bpy.types.Scene, name: str, purpose: str = "") -> Content:
    """The preset of a scene's settings, colors and image settings."""
    groups = {"settings": scene.paradesc, "colors": scene.paradesc_looks, "image": scene.paradesc}
    sections = {
        section: {member: preset_file.plain(getattr(groups[section], member)) for member in known}
        for section, known in preset_rules.rules().items()
    }
    return Content(name, purpose, **sections)
