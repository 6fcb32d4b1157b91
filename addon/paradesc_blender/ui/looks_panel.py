"""The sidebar's panels about colors: map and range, materials and nodes, and copies of the values."""

import bpy

from paradesc.core import choices

from ..scene import targets
from ..settings.looks import CHANNELS
from ..settings.translation import label
from .drawing import SettingsPanel, sentence_lines, setting


class PARADESC_PT_looks(SettingsPanel, bpy.types.Panel):
    """Colors of what was baked, and of the next bake"""

    bl_label = "Colors"
    bl_idname = "PARADESC_PT_looks"
    bl_order = 20

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, _settings: object) -> None:
        """Draws map and range."""
        group = context.scene.paradesc_looks
        setting(layout, group, "color_map")
        setting(layout, group, "span")
        column = layout.column(align=True)
        if group.span == "fixed":
            setting(column, group, "minimum")
            setting(column, group, "maximum")
            if choices.look_fault(group):
                sentence_lines(context, column, choices.look_fault(group), "ERROR")
        elif group.span == "percentile":
            setting(column, group, "percentile")
        if group.span != "fixed":
            setting(column, group, "symmetric")
        target = targets.first(context)
        if target is not None and target.paradesc_live.mode != "OFF" and group.span != "fixed":  # all frames have one
            layout.operator("paradesc.live_range", icon="LOCKED")
        setting(layout, group, "use_neutral")
        if group.use_neutral:
            setting(layout, group, "neutral")
        row = layout.row(align=True)
        row.operator("paradesc.recolor", text=label("Recolor"), translate=False)
        row.operator("paradesc.recolor", text=label("All"), translate=False).every = True
        setting(layout, group, "show_legend")


class PARADESC_PT_materials(SettingsPanel, bpy.types.Panel):
    """Materials and nodes that use the values"""

    bl_label = "Materials, Nodes"
    bl_idname = "PARADESC_PT_materials"
    bl_order = 1
    bl_parent_id = "PARADESC_PT_looks"

    def draw_settings(self, _context: bpy.types.Context, layout: bpy.types.UILayout, _settings: object) -> None:
        """Draws one button for each."""
        column = layout.column(align=True)
        row = column.row(align=True)
        for kind, text in (("colors", "Colors"), ("flat", "Flat"), ("cavity", "Cavity")):
            row.operator("paradesc.make_material", text=label(text), translate=False).kind = kind
        column.operator("paradesc.plug_cavity", text=label("In Active Material"), translate=False, icon="NODE_MATERIAL")
        column.operator("paradesc.remove_material", icon="X")
        layout.operator_menu_enum("paradesc.add_geometry_nodes", "kind", icon="GEOMETRY_NODES")


class PARADESC_PT_channels(SettingsPanel, bpy.types.Panel):
    """Other places for the values"""

    bl_label = "Convert"
    bl_idname = "PARADESC_PT_channels"
    bl_order = 2
    bl_parent_id = "PARADESC_PT_looks"

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, _settings: object) -> None:
        """Draws the buttons that copy the shown values, and the settings for packing four attributes into one."""
        group = context.scene.paradesc_looks
        column = layout.column(align=True)
        column.operator("paradesc.vertex_group", icon="GROUP_VERTEX")
        column.operator("paradesc.sculpt_mask", icon="MOD_MASK")
        column.operator("paradesc.corner_colors", icon="VPAINT_HLT")
        column.operator("paradesc.export_copies", icon="EXPORT")
        column.operator("paradesc.make_result_object", icon="DUPLICATE")
        target = targets.first(context)
        column = layout.column(align=True)
        for channel in CHANNELS:
            if target is not None:
                column.prop_search(group, f"pack_{channel}", target.data, "attributes")
            else:
                column.prop(group, f"pack_{channel}")
        column = layout.column(align=True)
        for name in ("pack_name", "pack_kind", "pack_domain"):
            setting(column, group, name)
        layout.operator("paradesc.pack", icon="IMAGE_RGB_ALPHA")


classes = (PARADESC_PT_looks, PARADESC_PT_materials, PARADESC_PT_channels)
