"""The sidebar panel: masks, radius, source, the bake button, and what the last bake did."""

import bpy

from .. import bridge
from ..animation import handlers
from ..bake import sculpt_mask
from ..bake.modal import ModalJob, Steps, progress_text
from ..core import choices
from ..scene import pairs, sculpt_masks, targets, viewports
from ..settings import presets
from ..settings.translation import label
from ..show import recolor
from . import image_result
from .drawing import (
    SidebarPanel,
    button,
    descriptor_words,
    fits,
    in_two_columns,
    place,
    sentence_lines,
    setting,
    side_by_side,
)
from .live_panel import live_sentence
from .report_panel import stored_report
from .wear_panel import draw_wear

# Of the row that the button has beside Live.
BAKE_SHARE = 0.72
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
        draw_masks(context, layout, settings)
        column = layout.column()
        in_two_columns(column)
        fit = ("paradesc.fit_radius", "FULLSCREEN_EXIT")
        setting(context, column, settings, choices.radius_member(settings), beside=fit)
        setting(context, column, context.scene.paradesc_animation, "source")
        if ModalJob.running:
            draw_progress(context, layout, ModalJob.running)
            return
        if context.active_object is not None and context.active_object.mode == "SCULPT":
            draw_sculpting(context, layout)
        draw_button(context, layout, settings)
        draw_live(context, layout)
        draw_result(context, layout)
        image_result.draw(context, layout)


def draw_masks(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws one button for each mask, the chosen one pressed; whatever else is chosen under Analysis has a line."""
    chosen = presets.chosen_mask(settings)
    labels = {name: label(presets.PRESETS[name].label) for name in presets.MASKS}
    columns = 2 if all(fits(context, words, 0.5, has_icon=True) for words in labels.values()) else 1
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, align=True)
    for name, words in labels.items():
        options = {"icon": MASK_ICONS[name], "depress": name == chosen}
        button(context, grid, "paradesc.mask", words, **options).name = name
    if not chosen:
        labels = [row.label for row in bridge.descriptors() if row.name in settings.descriptors]
        count = label("{count} descriptors, under Analysis").format(count=len(labels))
        sentence_lines(context, layout, labels[0] if len(labels) == 1 else count)


def draw_sculpting(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws one button for each mask of sculpt mode, and what stands in their way."""
    layout.label(text="Sculpt Mask")
    labels = {name: label(presets.PRESETS[name].label) for name in sculpt_mask.MASKS}
    row = side_by_side(context, layout, list(labels.values()))
    for name, words in labels.items():
        button(context, row, "paradesc.mask_from_shape", words).mask = name
    sentence = sculpt_masks.multires_obstacle(context.active_object)
    if sentence:
        sentence_lines(context, layout, sentence, "INFO")


def draw_button(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws the button, the switch of live values beside it, and what stands in the way."""
    chosen = targets.chosen(context)
    there = context.active_object is not None and context.active_object.type == "MESH"
    text, live = button_text(len(targets.by_mesh(chosen)), presets.chosen_mask(settings)), label("Live")
    beside = fits(context, text, BAKE_SHARE, has_icon=True) and fits(context, live, 1 - BAKE_SHARE)
    row = layout.split(factor=BAKE_SHARE, align=True) if there and beside else layout.column(align=True)
    row.scale_y = 1.4
    button(context, row, "paradesc.bake", text, icon="SHADING_TEXTURE")
    if there:
        row.prop(context.active_object.paradesc_live, "follows", toggle=True)
    button(context, layout, "paradesc.bake_image", icon="IMAGE_DATA")
    draw_wear(context, layout)
    found = pairs.chosen(context)
    if found:
        button(context, layout, "paradesc.bake_onto", onto_text(found), icon="TRIA_DOWN_BAR")
    sentence = targets.obstacle(context)
    if sentence:
        sentence_lines(context, layout, sentence, "INFO")
    if any(targets.unwritable(target) for target in chosen):
        button(context, layout, "paradesc.make_local", icon="LINK_BLEND")


def draw_live(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws what live values cost a frame, or why they stopped."""
    target = context.active_object
    if target is None or target.type != "MESH":
        return
    sentence, session = live_sentence(target), handlers.session_at(target)
    if sentence:
        sentence_lines(context, layout, sentence, "ERROR" if target.paradesc_live.sentence else "INFO")
    elif target.paradesc_live.follows and session is not None and session.seconds:
        time = f"{1e3 * sum(session.seconds.values()):.0f} ms"
        sentence_lines(context, layout, label("Live: {time} a frame").format(time=time))


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
        part, words = place(context, row, shown_words(mesh), has_icon=True, others=2)  # the arrow and the eye
        part.operator_menu_enum("paradesc.show", "name", text=words, icon="COLOR" if words else "DOWNARROW_HLT")
        if context.space_data.shading.type != "SOLID":
            row.operator("paradesc.view_colors", text="", icon="SHADING_SOLID")
        elif context.space_data.shading.color_type != viewports.ATTRIBUTES:
            row.operator("paradesc.view_colors", text="", icon="HIDE_ON")
        elif viewports.can_restore(context):
            row.operator("paradesc.restore_shading", text="", icon="HIDE_OFF")
    for sentence in stored["warnings"].splitlines():
        sentence_lines(context, column, sentence, "ERROR")
    if stored["field_report"]["radius"] < stored["mesh_report"].get("mean_edge", 0.0):
        button(context, column, "paradesc.fit_radius", label("Fit Radius to Mesh"))


def result_sentence(stored: dict[str, dict]) -> str:
    """What a bake did and how long it took."""
    asked = stored["settings"].get("descriptors")
    names = [name for name in asked if isinstance(name, str)] if isinstance(asked, list) else []
    known = {row.name: row.label for row in bridge.descriptors()}
    count = label("{count} descriptors").format(count=len(names))
    what = label(known.get(names[0], names[0])) if len(names) == 1 else count
    field, mesh = stored["field_report"], stored["mesh_report"]
    line = label("{what}, {count} vertices, {seconds} s")
    return line.format(what=what, count=f"{mesh['vertex_count']:,}", seconds=f"{field['seconds_total']:.2f}")


def shown_words(mesh: bpy.types.Mesh) -> str:
    """The descriptor whose colors the mesh shows, in words."""
    name = recolor.shown_name(mesh)
    return descriptor_words(name) if name else label("Choose what to show")


def button_text(count: int, mask: str = "") -> str:
    """The text of the button for so many meshes, and for a mask if one is chosen."""
    what = label(presets.PRESETS[mask].label if mask else "Descriptors")
    text = label("Bake {what} on {count} Meshes") if count > 1 else label("Bake {what}")
    return text.format(what=what, count=count)


def onto_text(found: dict[bpy.types.Object, list[bpy.types.Object]]) -> str:
    """The text of the button that bakes detailed meshes onto low-poly ones."""
    if len(found) > 1:
        return label("Bake onto {count} Meshes").format(count=len(found))
    return label("Bake onto {name}").format(name=next(iter(found)).name)


def draw_progress(context: bpy.types.Context, layout: bpy.types.UILayout, running: Steps) -> None:
    """Draws how far the work is; Blender has a bar for it since 4.0."""
    if hasattr(layout, "progress"):
        layout.progress(factor=running.fraction, text=f"{running.fraction:.0%}", type="BAR")
    sentence_lines(
        context, layout, label("{progress} (Esc cancels)").format(progress=progress_text(running)), "SORTTIME"
    )


classes = (PARADESC_PT_bake,)
