"""Keeps old files as they were: settings that were at the defaults of their version keep those values."""

import bpy
from bpy.app.handlers import persistent

from ..core import source_kinds
from . import hooks
from .properties import VERSION

# Files before version 1 measured the mean curvature of the base mesh unless they were told otherwise; those before
# version 2 measured one mask, at 2 % of the diagonal.
FORMER_DESCRIPTORS, FORMER_TEXELS = ("mean_curvature", "cavity"), 512


@persistent
def on_load(*_ignored: object) -> None:
    """Gives scenes of an older file the defaults of its version."""
    for scene in bpy.data.scenes:
        migrate(scene)


@persistent
def on_update(scene: bpy.types.Scene, *_ignored: object) -> None:
    """Migrates a scene that was appended from an older file, once Blender shows it."""
    migrate(scene)


def migrate(scene: bpy.types.Scene) -> None:
    """Stores the earlier defaults in a scene whose settings were stored before they had a version.

    If no setting is stored, nobody has chosen any, and the present defaults apply.
    """
    if scene.library is not None or not scene.is_property_set("paradesc"):
        return
    group, animation = scene.paradesc, scene.paradesc_animation
    if group.version >= VERSION or not stores_any(group):
        return
    former, known = FORMER_DESCRIPTORS[group.version], group.bl_rna.properties["descriptors"].enum_items
    if group.version == 0:
        keep_first_defaults(group, animation)
    if not group.is_property_set("descriptors") and former in known:
        group.descriptors = {former}
    if not group.is_property_set("radius_fit"):
        group.radius_fit = "typed"
    group.version = VERSION


def keep_first_defaults(group: bpy.types.PropertyGroup, animation: bpy.types.PropertyGroup) -> None:
    """Stores the defaults of files that have no version yet."""
    if not group.is_property_set("texels"):
        group.texels = FORMER_TEXELS
    if not animation.is_property_set("source"):
        animation.source = source_kinds.ORIGINAL


def stores_any(group: bpy.types.PropertyGroup) -> bool:
    """Whether any setting is stored."""
    names = [item.identifier for item in group.bl_rna.properties if item.identifier not in ("rna_type", "name")]
    return any(map(group.is_property_set, names))


HANDLERS = {"load_post": on_load, "depsgraph_update_post": on_update}
classes = ()


def register() -> None:
    """Adds each handler to Blender; a file that is open already is looked at now."""
    hooks.hang(HANDLERS)
    if hasattr(bpy.data, "scenes"):  # false while Blender starts
        on_load()


def unregister() -> None:
    """Removes the handlers."""
    hooks.take_down(HANDLERS)
