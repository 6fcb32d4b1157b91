"""The sub-panel of Bake to Image: the button, and what the textures are like."""

import bpy

from ..bake.modal import ModalJob
from .panel import SettingsPanel


class PARADESC_PT_image(SettingsPanel, bpy.types.Panel):
    """Textures over the UV map"""

    bl_label = "Bake to Image"
    bl_idname = "PARADESC_PT_image"
    bl_order = 34
    bl_options = {"DEFAULT_CLOSED"}

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws size, outside and what is packed, then the button."""
        draw_image(layout, settings)


def draw_image(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws what textures are like, and the button unless something is being baked."""
    for name in ("texels", "image_outside", "image_packed", "image_to_material"):
        layout.prop(settings, name)
    if not ModalJob.running:
        layout.operator("paradesc.bake_image", icon="IMAGE_DATA")


classes = (PARADESC_PT_image,)
