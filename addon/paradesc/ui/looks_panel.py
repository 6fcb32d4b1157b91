"""The sidebar's panels about colors: map and range, materials and nodes, other places for the values."""

import bpy

from ..settings import looks
from ..settings.looks import CHANNELS
from .drawing import SidebarPanel, sentence_lines


class PARADESC_PT_looks(SidebarPanel, bpy.types.Panel):
    """Colors of what was baked, and of the next bake"""

    bl_label = "Colors"
    bl_idname = "PARADESC_PT_looks"
    bl_order = 20
    bl_parent_id = "PARADESC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draws map and range."""
        layout, group = self.layout, context.scene.paradesc_looks
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(group, "color_map")
        layout.prop(group, "span")
        column = layout.column(align=True)
        if group.span == "fixed":
            column.prop(group, "minimum")
            column.prop(group, "maximum")
            if looks.fault(group):
                sentence_lines(context, column, looks.fault(group), "ERROR")
        elif group.span == "percentile":
            column.prop(group, "percentile")
        if group.span != "fixed":
            column.prop(group, "symmetric")
        if follows_frames(context.active_object) and group.span != "fixed":
            layout.operator("paradesc.live_range", icon="LOCKED")
        row = layout.row(heading="Neutral")
        row.prop(group, "use_neutral", text="")
        value = row.row()
        value.active = group.use_neutral
        value.prop(group, "neutral", text="")
        row = layout.row(align=True)
        row.operator("paradesc.recolor", text="Recolor Shown", icon="FILE_REFRESH")
        row.operator("paradesc.recolor", text="All").every = True
        layout.prop(group, "show_legend")


def follows_frames(target: bpy.types.Object | None) -> bool:
    """Whether an object's values are live or played, so that their range is held at all frames."""
    return target is not None and target.type == "MESH" and target.paradesc_live.mode != "OFF"


class PARADESC_PT_materials(SidebarPanel, bpy.types.Panel):
    """Materials and nodes that use the values"""

    bl_label = "Materials and Nodes"
    bl_idname = "PARADESC_PT_materials"
    bl_order = 1
    bl_parent_id = "PARADESC_PT_looks"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws one button for each."""
        column = self.layout.column(align=True)
        row = column.row(align=True)
        row.operator("paradesc.make_material", text="Colors", icon="MATERIAL").kind = "colors"
        row.operator("paradesc.make_material", text="Flat").kind = "flat"
        row.operator("paradesc.make_material", text="Cavity").kind = "cavity"
        column.operator("paradesc.plug_cavity", text="Cavity in Active Material", icon="NODE_MATERIAL")
        column.operator("paradesc.remove_material", icon="X")
        self.layout.operator_menu_enum("paradesc.add_geometry_nodes", "kind", icon="GEOMETRY_NODES")


class PARADESC_PT_channels(SidebarPanel, bpy.types.Panel):
    """Other places for the values"""

    bl_label = "Convert"
    bl_idname = "PARADESC_PT_channels"
    bl_order = 2
    bl_parent_id = "PARADESC_PT_looks"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draws the buttons that copy what is shown, and the settings that pack four values into one attribute."""
        layout, group = self.layout, context.scene.paradesc_looks
        column = layout.column(align=True)
        column.operator("paradesc.vertex_group", icon="GROUP_VERTEX")
        column.operator("paradesc.sculpt_mask", icon="MOD_MASK")
        column.operator("paradesc.corner_colors", icon="VPAINT_HLT")
        column.operator("paradesc.export_copies", icon="EXPORT")
        layout.use_property_split = True
        layout.use_property_decorate = False
        target = context.active_object
        column = layout.column(align=True)
        for channel in CHANNELS:
            if target is not None and target.type == "MESH":
                column.prop_search(group, f"pack_{channel}", target.data, "attributes")
            else:
                column.prop(group, f"pack_{channel}")
        column = layout.column(align=True)
        for name in ("pack_name", "pack_kind", "pack_domain"):
            column.prop(group, name)
        layout.operator("paradesc.pack", icon="IMAGE_RGB_ALPHA")


classes = (PARADESC_PT_looks, PARADESC_PT_materials, PARADESC_PT_channels)
