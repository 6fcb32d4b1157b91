"""Entries in Blender's own menus, where artists look for masks: beside Dirty Vertex Colors, and in the Object menu."""

import bpy

from .. import bridge
from ..settings import presets


class PARADESC_MT_bake(bpy.types.Menu):
    """Masks of the selected meshes, as vertex colors"""

    bl_idname = "PARADESC_MT_bake"
    bl_label = "Paradesc Masks"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws one entry for each mask."""
        for name in presets.MASKS:
            self.layout.operator("paradesc.bake", text=f"Bake {presets.PRESETS[name].label}").mask = name


def draw_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Draws the menu of masks inside another one."""
    if not bridge.missing_sentence():
        menu.layout.separator()
        menu.layout.menu("PARADESC_MT_bake")


PLACES = ("VIEW3D_MT_paint_vertex", "VIEW3D_MT_object")
classes = (PARADESC_MT_bake,)


def register() -> None:
    """Adds the entries."""
    for name in PLACES:
        getattr(bpy.types, name).append(draw_entry)


def unregister() -> None:
    """Removes them."""
    for name in PLACES:
        getattr(bpy.types, name).remove(draw_entry)
