"""Keeps a scene's settings and colors as they are, to bring them back if what changes them comes to nothing."""

import bpy

from . import presets

GROUPS = ("paradesc", "paradesc_looks")


def identity(datablock: bpy.types.ID) -> object:
    """Identifies a datablock in this session, even if it is renamed; before Blender 4.2 its name has to stay."""
    if hasattr(datablock, "session_uid"):
        return datablock.session_uid
    return (datablock.name, datablock.as_pointer())


class Snapshot:
    """The settings of a scene at one time: plain values, since another file may be open when they are asked for."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        """Takes them."""
        self.scene_name, self.identity = scene.name, identity(scene)
        self.chosen = presets.shown_chosen()
        self.values = {
            (place, item.identifier): (getattr(group, item.identifier), group.is_property_set(item.identifier))
            for place in GROUPS
            for group in [getattr(scene, place)]
            for item in group.bl_rna.properties
            if not item.is_readonly and item.type not in ("POINTER", "COLLECTION")
        }

    def restore(self) -> None:
        """Brings them back, where they differ; what was at its default follows that again."""
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
