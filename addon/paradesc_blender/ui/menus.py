"""The menu of wear, and entries in Blender's own menus, where artists look for masks: in Paint, Object and Mask."""

import bpy

from paradesc import bridge

from ..bake import sculpt_mask
from ..scene import large_faces
from ..settings import presets
from ..settings.translation import label


class PARADESC_MT_bake(bpy.types.Menu):
    """Masks of the selected meshes, as vertex colors or images"""

    bl_idname = "PARADESC_MT_bake"
    bl_label = "Paradesc Masks"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws one entry for each mask, which bakes to images if faces are too large for vertex colors."""
        large = large_faces.of_chosen(context)
        words = label("Bake {what} to Image" if large else "Bake {what}")
        for name in presets.MASKS:
            text = words.format(what=label(presets.PRESETS[name].name))
            operator = "paradesc.bake_image" if large else "paradesc.bake"
            self.layout.operator(operator, text=text, translate=False).mask = name


class PARADESC_MT_wear(bpy.types.Menu):
    """Looks of dirt and wear"""

    bl_idname = "PARADESC_MT_wear"
    bl_label = "Looks of Wear"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws one entry for each look, and the one that takes wear out again."""
        self.layout.operator_enum("paradesc.add_wear", "look")
        self.layout.separator()
        self.layout.operator("paradesc.remove_wear", icon="X")


def draw_entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Draws the menu of masks as an entry of another menu."""
    if not bridge.missing_sentence():
        menu.layout.separator()
        menu.layout.menu("PARADESC_MT_bake")


def draw_sculpt_masks(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Draws one entry for each mask of sculpt mode."""
    if not bridge.missing_sentence():
        menu.layout.separator()
        words = label("Mask from {what} at Radius")
        for name in sculpt_mask.MASKS:
            text = words.format(what=label(presets.PRESETS[name].name))
            menu.layout.operator("paradesc.mask_from_shape", text=text, translate=False).mask = name


PLACES = {
    "VIEW3D_MT_paint_vertex": draw_entry,
    "VIEW3D_MT_object": draw_entry,
    "VIEW3D_MT_mask": draw_sculpt_masks,
}
classes = (PARADESC_MT_bake, PARADESC_MT_wear)


def register() -> None:
    """Adds the entries."""
    for name, draw in PLACES.items():
        getattr(bpy.types, name).append(draw)


def unregister() -> None:
    """Removes them."""
    for name, draw in PLACES.items():
        getattr(bpy.types, name).remove(draw)
