"""The sub-panel of Bake to Image, with the settings of textures."""

import bpy

from .drawing import SettingsPanel, setting


class PARADESC_PT_image(SettingsPanel, bpy.types.Panel):
    """Textures over the UV map"""

    bl_label = "Image"
    bl_idname = "PARADESC_PT_image"
    bl_order = 25

    def draw_settings(self, _context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws size, outside, packing, use in materials, and the cage distance."""
        for name in ("texels", "image_outside", "image_packed", "image_to_material", "cage"):
            setting(layout, settings, name)


classes = (PARADESC_PT_image,)
