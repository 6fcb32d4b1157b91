"""The button that adds wear to materials, and its menu of looks."""

import bpy


class PARADESC_MT_wear(bpy.types.Menu):
    """Looks of dirt and wear"""

    bl_idname = "PARADESC_MT_wear"
    bl_label = "Looks of Wear"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws one entry for each look, and the one that takes wear out again."""
        self.layout.operator_enum("paradesc.add_wear", "look")
        self.layout.separator()
        self.layout.operator("paradesc.remove_wear", icon="X")


def draw_wear(layout: bpy.types.UILayout) -> None:
    """Draws the button, and the menu of looks beside it."""
    row = layout.row(align=True)
    row.operator("paradesc.add_wear", icon="NODE_MATERIAL")
    row.menu("PARADESC_MT_wear", text="", icon="DOWNARROW_HLT")


classes = (PARADESC_MT_wear,)
