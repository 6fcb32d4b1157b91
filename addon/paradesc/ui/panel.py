"""The sidebar panel: masks, radius, source, the bake button, and what the last bake did."""

import bpy

from .. import bridge
from ..animation import handlers
from ..bake import sculpt_mask
from ..bake.modal import ModalJob, Steps, progress_text
from ..core import legend
from ..scene import sculpt_masks, targets, viewports
from ..settings import presets, properties
from ..show import recolor
from .drawing import SidebarPanel, sentence_lines
from .live_panel import live_sentence
from .report_panel import stored_report

MASK_ICONS = {"cavity": "SHARPCURVE", "edge_wear": "SPHERECURVE", "curvature": "SMOOTHCURVE", "openness": "LIGHT_SUN"}


class PARADESC_PT_bake(SidebarPanel, bpy.types.Panel):
    """Masks, and the button"""

    bl_label = "Paradesc"
    bl_idname = "PARADESC_PT_bake"

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """Draws the menu of presets and the button for the manual at the right end of the panel's header."""
        row = self.layout.row(align=True)
        row.menu("PARADESC_MT_presets", text="", icon="PRESET")
        row.operator("paradesc.manual", text="", icon="QUESTION", emboss=False)

    def draw(self, context: bpy.types.Context) -> None:
        """Draws what an artist needs, in the order of the work, and what stands in the way."""
        layout, settings = self.layout, context.scene.paradesc
        missing = bridge.missing_sentence()
        if missing:
            sentence_lines(context, layout, missing, "ERROR")
            return
        draw_masks(layout, settings)
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        row = column.row(align=True)
        row.prop(settings, properties.radius_member(settings))
        row.operator("paradesc.fit_radius", text="", icon="FULLSCREEN_EXIT")
        column.prop(context.scene.paradesc_animation, "source")
        if ModalJob.running:
            draw_progress(context, layout, ModalJob.running)
            return
        if context.active_object is not None and context.active_object.mode == "SCULPT":
            draw_sculpting(context, layout)
        draw_button(context, layout, settings)
        draw_live(context, layout)
        draw_result(context, layout)


def draw_masks(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws one button for each mask, the chosen one pressed; whatever else is chosen under Analysis has a line."""
    chosen = presets.chosen_mask(settings)
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    for name in presets.MASKS:
        button = grid.operator(
            "paradesc.preset", text=presets.PRESETS[name].label, icon=MASK_ICONS[name], depress=name == chosen
        )
        button.name = name
    if not chosen:
        labels = [row.label for row in bridge.descriptors() if row.name in settings.descriptors]
        layout.label(text=labels[0] if len(labels) == 1 else f"{len(labels)} descriptors, under Analysis")


def draw_sculpting(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws one button for each mask of sculpt mode, and what stands in their way."""
    layout.label(text="Sculpt Mask")
    row = layout.row(align=True)
    for name in sculpt_mask.MASKS:
        row.operator("paradesc.mask_from_shape", text=presets.PRESETS[name].label).mask = name
    sentence = sculpt_masks.multires_obstacle(context.active_object)
    if sentence:
        sentence_lines(context, layout, sentence, "INFO")


def draw_button(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws the button, the switch of live values beside it, and what stands in the way."""
    chosen = targets.chosen(context)
    there = context.active_object is not None and context.active_object.type == "MESH"
    row = layout.split(factor=0.72, align=True) if there else layout.row()
    row.scale_y = 1.4
    text = button_text(len(targets.by_mesh(chosen)), presets.chosen_mask(settings))
    row.operator("paradesc.bake", text=text, icon="SHADING_TEXTURE")
    if there:
        row.prop(context.active_object.paradesc_live, "follows", toggle=True)
    layout.operator("paradesc.bake_image", icon="IMAGE_DATA")
    sentence = targets.obstacle(context)
    if sentence:
        sentence_lines(context, layout, sentence, "INFO")
    if any(targets.unwritable(target) for target in chosen):
        layout.operator("paradesc.make_local", icon="LINK_BLEND")


def draw_live(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws what live values cost a frame, or why they stopped."""
    target = context.active_object
    if target is None or target.type != "MESH":
        return
    sentence, session = live_sentence(target), handlers.session_at(target)
    if sentence:
        sentence_lines(context, layout, sentence, "ERROR" if target.paradesc_live.sentence else "INFO")
    elif target.paradesc_live.follows and session is not None and session.seconds:
        sentence_lines(context, layout, f"Live: {1e3 * sum(session.seconds.values()):.0f} ms a frame")


def draw_result(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws one line on what the last bake of this mesh did, what to show of it, and what limits it."""
    stored = stored_report(context.active_object)
    if not stored:
        return
    mesh = context.active_object.data
    column = layout.column(align=True)
    sentence_lines(context, column, result_sentence(stored))
    if recolor.baked_names(mesh):
        row = column.row(align=True)
        row.operator_menu_enum("paradesc.show", "name", text=shown_words(mesh), icon="COLOR")
        if context.space_data.shading.type != "SOLID":
            row.operator("paradesc.view_colors", text="", icon="SHADING_SOLID")
        elif context.space_data.shading.color_type != viewports.ATTRIBUTES:
            row.operator("paradesc.view_colors", text="", icon="HIDE_ON")
        elif viewports.can_restore(context):
            row.operator("paradesc.restore_shading", text="", icon="HIDE_OFF")
    for sentence in stored["warnings"].splitlines():
        sentence_lines(context, column, sentence, "ERROR")
    if stored["field_report"]["radius"] < stored["mesh_report"].get("mean_edge", 0.0):
        column.operator("paradesc.fit_radius", text="Fit Radius to Mesh")


def result_sentence(stored: dict[str, dict]) -> str:
    """What a bake did and how long it took."""
    asked = stored["settings"].get("descriptors")
    names = [name for name in asked if isinstance(name, str)] if isinstance(asked, list) else []
    known = {row.name: row.label for row in bridge.descriptors()}
    label = known.get(names[0], names[0]) if len(names) == 1 else f"{len(names)} descriptors"
    field, mesh = stored["field_report"], stored["mesh_report"]
    return f"{label}, {mesh['vertex_count']:,} vertices, {field['seconds_total']:.2f} s"


def shown_words(mesh: bpy.types.Mesh) -> str:
    """The descriptor whose colors the mesh shows, in words."""
    name = recolor.shown_name(mesh)
    return legend.label(name) if name else "Choose what to show"


def button_text(count: int, mask: str = "") -> str:
    """The text of the button for so many meshes, and for a mask if one is chosen."""
    what = presets.PRESETS[mask].label if mask else "Descriptors"
    return f"Bake {what}" + (f" on {count} Meshes" if count > 1 else "")


def draw_progress(context: bpy.types.Context, layout: bpy.types.UILayout, running: Steps) -> None:
    """Draws how far the work is; Blender has a bar for it since 4.0."""
    if hasattr(layout, "progress"):
        layout.progress(factor=running.fraction, text=f"{running.fraction:.0%}", type="BAR")
    sentence_lines(context, layout, f"{progress_text(running)} (Esc cancels)", "SORTTIME")


classes = (PARADESC_PT_bake,)
