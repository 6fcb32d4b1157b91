"""The sidebar's panels about colors: map and range, materials and nodes, other places for the values."""

import bpy

from ..core import choices
from ..settings.looks import CHANNELS
from ..settings.translation import label
from .drawing import SidebarPanel, button, in_two_columns, sentence_lines, setting, side_by_side


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
        in_two_columns(layout)
        setting(context, layout, group, "color_map")
        setting(context, layout, group, "span")
        column = layout.column(align=True)
        if group.span == "fixed":
            setting(context, column, group, "minimum")
            setting(context, column, group, "maximum")
            if choices.look_fault(group):
                sentence_lines(context, column, choices.look_fault(group), "ERROR")
        elif group.span == "percentile":
            setting(context, column, group, "percentile")
        if group.span != "fixed":
            setting(context, column, group, "symmetric")
        if follows_frames(context.active_object) and group.span != "fixed":
            button(context, layout, "paradesc.live_range", icon="LOCKED")
        row = layout.row(heading="Neutral")
        row.prop(group, "use_neutral", text="")
        value = row.row()
        value.active = group.use_neutral
        value.prop(group, "neutral", text="")
        shown, every = label("Recolor Shown"), label("Recolor All")
        row = side_by_side(context, layout, [shown, every])
        button(context, row, "paradesc.recolor", shown)
        button(context, row, "paradesc.recolor", every).every = True
        setting(context, layout, group, "show_legend")


def follows_frames(target: bpy.types.Object | None) -> bool:
    """Whether an object's values are live or played, so that their range is held at all frames."""
    return target is not None and target.type == "MESH" and target.paradesc_live.mode != "OFF"


class PARADESC_PT_materials(SidebarPanel, bpy.types.Panel):
    """Materials and nodes that use the values"""

    bl_label = "Materials, Nodes"
    bl_idname = "PARADESC_PT_materials"
    bl_order = 1
    bl_parent_id = "PARADESC_PT_looks"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Draws one button for each."""
        column = self.layout.column(align=True)
        labels = {"colors": label("Colors"), "flat": label("Flat"), "cavity": label("Cavity")}
        row = side_by_side(context, column, list(labels.values()))
        for kind, words in labels.items():
            button(context, row, "paradesc.make_material", words).kind = kind
        button(context, column, "paradesc.plug_cavity", label("Cavity in Active Material"), icon="NODE_MATERIAL")
        button(context, column, "paradesc.remove_material", icon="X")
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
        button(context, column, "paradesc.vertex_group", icon="GROUP_VERTEX")
        button(context, column, "paradesc.sculpt_mask", icon="MOD_MASK")
        button(context, column, "paradesc.corner_colors", icon="VPAINT_HLT")
        button(context, column, "paradesc.export_copies", icon="EXPORT")
        in_two_columns(layout)
        target = context.active_object
        column = layout.column(align=True)
        for channel in CHANNELS:
            if target is not None and target.type == "MESH":
                column.prop_search(group, f"pack_{channel}", target.data, "attributes")
            else:
                column.prop(group, f"pack_{channel}")
        column = layout.column(align=True)
        for name in ("pack_name", "pack_kind", "pack_domain"):
            setting(context, column, group, name)
        button(context, layout, "paradesc.pack", icon="IMAGE_RGB_ALPHA")


classes = (PARADESC_PT_looks, PARADESC_PT_materials, PARADESC_PT_channels)
