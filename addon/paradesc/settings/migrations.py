"""Keeps old files as they were: a setting that a file leaves at its default keeps the default of its time."""

import bpy
from bpy.app.handlers import persistent

from ..core import source_kinds

# Files before version 1 measured the mean curvature of the base mesh unless they were told otherwise.
VERSION = 1
FORMER_DESCRIPTOR, FORMER_TEXELS = "mean_curvature", 512


@persistent
def on_load(*_ignored: object) -> None:
    """Gives the scenes of an older file the defaults with which they were saved."""
    for scene in bpy.data.scenes:
        if scene.library is not None or not scene.is_property_set("paradesc") or scene.paradesc.version >= VERSION:
            continue
        group, animation = scene.paradesc, scene.paradesc_animation
        known = group.bl_rna.properties["descriptors"].enum_items
        if not group.is_property_set("descriptors") and FORMER_DESCRIPTOR in known:
            group.descriptors = {FORMER_DESCRIPTOR}
        if not group.is_property_set("texels"):
            group.texels = FORMER_TEXELS
        if not animation.is_property_set("source"):
            animation.source = source_kinds.ORIGINAL
        group.version = VERSION


@persistent
def on_save(*_ignored: object) -> None:
    """Notes which defaults the scenes are saved with."""
    for scene in bpy.data.scenes:
        if scene.library is None and scene.is_property_set("paradesc"):
            scene.paradesc.version = VERSION


HANDLERS = {"load_post": on_load, "save_pre": on_save}
classes = ()


def register() -> None:
    """Adds each handler to Blender."""
    for name, function in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(function)


def unregister() -> None:
    """Removes the handlers."""
    for name, function in HANDLERS.items():
        hooks = getattr(bpy.app.handlers, name)
        if function in hooks:
            hooks.remove(function)
