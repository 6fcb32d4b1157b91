"""Keeps a scene's settings and colors, to restore them if an operator that changes them fails."""

import bpy

from . import presets

GROUPS = ("paradesc", "paradesc_looks")


def identity(datablock: bpy.types.ID) -> object:
    """An identity of a datablock for this session that survives renaming; before Blender 4.2 it does not."""
    if hasattr(datablock, "session_uid"):
        return datablock.session_uid
    return (datablock.name, datablock.as_pointer())


class Snapshot:
    """A scene's settings at one time, as plain values, because another file may be open when they are restored."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        """Copies the scene's settings."""
        self.scene_name, self.identity = scene.name, identity(scene)
        self.chosen = (presets.PARADESC_MT_presets.bl_label, *presets.chosen)
        self.values = {
            (place, item.identifier): (getattr(group, item.identifier), group.is_property_set(item.identifier))
            for place in GROUPS
            for group in [getattr(scene, place)]
            for item in group.bl_rna.properties
            if not item.is_readonly and item.type not in ("POINTER", "COLLECTION")
        }

    def restore(self) -> None:
        """Restores the settings that differ; those that were at their defaults are unset again."""
        scene = bpy.data.scenes.get(self.scene_name)
        if scene is None or identity(scene) != self.identity:
            return
        for (place, name), (value, stored) in self.values.items():
            group = getattr(scene, place)
            if getattr(group, name) != value:
                setattr(group, name, value)
            if not stored and group.is_property_set(name):
                group.property_unset(name)
        presets.show_chosen(*self.chosen)
