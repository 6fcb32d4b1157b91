"""The sidebar panel: masks, radius, source, the bake button, and what the last bake did."""

import bpy

from paradesc import bridge
from paradesc.core import advice, choices, spaces

from ..animation import sessions
from ..bake import sculpt_mask
from ..bake.modal import ModalJob, progress_text
from ..bake.pieces import Pieces
from ..scene import large_faces, mesh_io, pairs, sculpt_masks, targets
from ..settings import presets, research
from ..settings.translation import label
from . import image_result
from .drawing import SidebarPanel, choice, in_two_columns, sentence_lines, setting
from .live_panel import live_sentence
from .report_panel import stored_report
from .result import draw_result

# The bake button's share of a row that also has Live.
BAKE_SHARE = 0.7
TO_IMAGE = "Bake to Image"
MASK_ICONS = {"cavity": "HOLDOUT_ON", "edge_wear": "MOD_BEVEL", "curvature": "FORCE_HARMONIC", "openness": "LIGHT_SUN"}


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
        """Draws the settings that artists need, in the order of the work, and the obstacles to a bake."""
        layout, settings = self.layout, context.scene.paradesc
        missing = bridge.missing_sentence()
        if missing:
            sentence_lines(context, layout, missing, "ERROR")
            return
        chosen = layout.column()
        chosen.enabled = ModalJob.running is None
        draw_masks(context, chosen, settings)
        draw_radius(context, chosen, settings)
        if ModalJob.running:
            draw_progress(context, layout, ModalJob.running)
            return
        if context.active_object is not None and context.active_object.mode == "SCULPT":
            draw_sculpting(context, layout)
        draw_buttons(context, layout, settings)
        draw_obstacles(context, layout, settings)
        draw_live(context, layout)
        draw_result(context, layout)
        image_result.draw(context, layout)
        draw_research(context, layout)


def draw_masks(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws one button for each mask, pressed if chosen. Other choices under Analysis are listed in a line."""
    chosen = presets.masks_of(settings.descriptors)
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    for name in presets.MASKS:
        text, icon = label(presets.PRESETS[name].name), MASK_ICONS[name]
        grid.operator("paradesc.mask", text=text, translate=False, icon=icon, depress=name in chosen).name = name
    if not chosen:
        labels = [row.label for row in bridge.descriptors() if row.name in settings.descriptors]
        count = label("{count} descriptors, under Analysis").format(count=len(labels))
        sentence_lines(context, layout, labels[0] if len(labels) == 1 else count)


def draw_radius(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws the radius, as a size that fits the mesh or as a number, and the source."""
    sizes = layout.row(align=True)
    for size in advice.SIZES:
        choice(sizes, settings, "radius_fit", size)
    column = layout.column()
    in_two_columns(column)
    setting(column, settings, choices.radius_member(settings))
    setting(column, context.scene.paradesc_animation, "source")


def draw_sculpting(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws one button for each mask of sculpt mode, and the reason if they cannot be used."""
    column = layout.column(align=True)
    sentence_lines(context, column, "Protect by Sculpt Mask")
    grid = column.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    for name in sculpt_mask.MASKS:
        grid.operator("paradesc.mask_from_shape", text=label(presets.PRESETS[name].name), translate=False).mask = name
    sentence = sculpt_masks.multires_obstacle(context.active_object)
    if sentence:
        sentence_lines(context, layout, sentence, "INFO")


def draw_buttons(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws the bake buttons, with the one that suits the meshes first, and beside it the switch of live values."""
    chosen = targets.chosen(context)
    text = button_text(len(targets.by_mesh(chosen)), presets.masks_of(settings.descriptors))
    buttons = [("paradesc.bake", text, "SHADING_TEXTURE"), ("paradesc.bake_image", label(TO_IMAGE), "IMAGE_DATA")]
    if large_faces.of_chosen(context):
        sentence_lines(context, layout, "Faces are too large for vertex colors", "INFO")
        buttons.reverse()
    row = layout.split(factor=BAKE_SHARE, align=True) if chosen else layout.column(align=True)
    row.scale_y = 1.4
    for place, (name, words, icon) in zip((row, layout), buttons, strict=True):
        place.operator(name, text=words, icon=icon, translate=False)
        if place == row and chosen:
            row.prop(chosen[0].paradesc_live, "follows", toggle=True)
    found = pairs.meant(context)
    if found:
        layout.operator("paradesc.bake_onto", text=onto_text(found), icon="TRIA_DOWN_BAR", translate=False)
    row = layout.row(align=True)
    row.operator("paradesc.add_wear", icon="NODE_MATERIAL")
    row.menu("PARADESC_MT_wear", text="", icon="DOWNARROW_HLT")


def draw_obstacles(context: bpy.types.Context, layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draws why a bake is impossible, what it leaves out, and buttons that remedy it."""
    sentence, chosen = targets.obstacle(context), targets.chosen(context)
    if sentence:
        sentence_lines(context, layout, sentence, "INFO")
    if any(mesh_io.unwritable(target) for target in chosen):
        layout.operator("paradesc.make_local", icon="LINK_BLEND")
    skipped = targets.skipped(context)
    if skipped:
        types = skipped[0].bl_rna.properties["type"].enum_items  # in Blender's words
        kinds = ", ".join(dict.fromkeys(label(types[item.type].name) for item in skipped))
        words = label("{count} skipped: {kinds}").format(count=len(skipped), kinds=kinds)
        sentence_lines(context, layout, words, "INFO")
        layout.operator("paradesc.convert_to_mesh", icon="MESH_DATA")
    asked = chosen[: large_faces.MOST_ASKED] if settings.space == "object" else []
    if any(not spaces.is_even(item.matrix_world) for item in asked):
        if not stored_report(chosen[0]):  # its warnings say so at length
            sentence_lines(context, layout, "The object's uneven scale is ignored", "INFO")
        layout.prop_enum(settings, "space", "world", text=label("Measure in World"), translate=False, icon="WORLD")


def draw_live(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws the time that live values take per frame, or why they stopped."""
    target = targets.first(context)
    if target is None:
        return
    sentence, session = live_sentence(target), sessions.session_at(target)
    if sentence:
        sentence_lines(context, layout, sentence, "ERROR" if target.paradesc_live.sentence else "INFO")
    elif target.paradesc_live.follows and session is not None and session.seconds:
        time = f"{1e3 * sum(session.seconds.values()):.0f} ms"
        sentence_lines(context, layout, label("Live: {time} a frame").format(time=time))


def draw_research(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws a note if hidden settings are not at their defaults, with buttons to show and to reset them."""
    count = sum(research.is_hidden(group, name) for group, name in research.changed(context.scene))
    if not count:
        return
    words = label("{count} research settings are set" if count > 1 else "{count} research setting is set")
    column = layout.column(align=True)
    sentence_lines(context, column, words.format(count=count), "INFO")
    row = column.row(align=True)
    row.operator("paradesc.show_research")
    row.operator("paradesc.reset_research")


def draw_progress(context: bpy.types.Context, layout: bpy.types.UILayout, running: Pieces) -> None:
    """Draws the progress as a property, because Blender 4 keeps drawing its own bar in place of later ones."""
    layout.prop(context.window_manager, "paradesc_progress", text="", slider=True)
    sentence_lines(context, layout, progress_text(running), "SORTTIME")
    layout.operator("paradesc.cancel", icon="X")


def button_text(count: int, masks: list[str] = ()) -> str:
    """The text of the bake button, for several meshes or for the masks of one."""
    if count > 1:
        return label("Bake {count} Meshes").format(count=count)
    if len(masks) > 1:
        return label("Bake Masks")
    return label("Bake {what}").format(what=label(presets.PRESETS[masks[0]].name if masks else "Descriptors"))


def onto_text(found: dict[bpy.types.Object, list[bpy.types.Object]]) -> str:
    """The text of the button that bakes detailed meshes onto low-poly ones."""
    if len(found) > 1:
        return label("Bake onto {count} Meshes").format(count=len(found))
    return label("Bake onto {name}").format(name=next(iter(found)).name)


classes = (PARADESC_PT_bake,)
