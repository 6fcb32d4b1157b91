"""The sub-panel of Bake to Image: what the textures are like."""

import bpy

from .drawing import SettingsPanel, setting


class PARADESC_PT_image(SettingsPanel, bpy.types.Panel):
    """Textures over the UV map"""

    bl_label = "Image"
    bl_idname = "PARADESC_PT_image"
    bl_order = 25

    def draw_settings(self, _context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws size, outside, what is packed, where the textures go besides, and how far apart surfaces may lie."""
        for name in ("texels", "image_outside", "image_packed", "image_to_material", "cage"):
            setting(layout, settings, name)


classes = (PARADESC_PT_image,)
