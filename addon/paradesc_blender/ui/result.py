"""Draws the result of the last bake in the main panel: one line, the choice of what to show, and warnings."""

from itertools import islice

import bpy

from paradesc import bridge
from paradesc.core import advice, color_maps

from ..bake.fit import PANEL
from ..scene import large_faces, targets, viewports
from ..settings import presets
from ..settings.translation import label
from ..show import recolor
from .drawing import descriptor_words, sentence_lines, setting
from .report_panel import stored_report


def draw_result(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws the result of the last bake, if its values still exist."""
    target = targets.first(context)
    stored = stored_report(target)
    if not stored:
        return
    mesh = target.data
    column = layout.column(align=True)
    sentence_lines(context, column, result_sentence(stored))
    name = recolor.shown_name(mesh)
    if recolor.baked_names(mesh):
        row = column.row(align=True)
        shown = descriptor_words(name) if name else label("Choose what to show")
        row.operator_menu_enum("paradesc.show", "name", text=shown, icon="COLOR")
        if context.space_data.shading.type != "SOLID":
            row.operator("paradesc.view_colors", text="", icon="SHADING_SOLID")
            if viewports.SOLID_BEFORE in context.screen:  # after wear, which shows materials
                row.operator("paradesc.restore_shading", text="", icon="HIDE_OFF")
        elif not viewports.is_shown(context):
            row.operator("paradesc.view_colors", text="", icon="HIDE_ON")
        elif viewports.can_restore(context):
            row.operator("paradesc.restore_shading", text="", icon="HIDE_OFF")
    if name and not recolor.is_direction(name):
        draw_levels(context, layout)
        seen, diagonal = stored["drawn"].get(name, {}), stored["mesh_report"].get("diagonal", 0.0)
        percent = 100 * seen.get("radius", 0.0) / diagonal if diagonal > 0 else 0.0
        draw_extremes(context, layout, seen, percent, ("paradesc.bake", {name}))
    column = layout.column(align=True)
    for sentence in stored["warnings"].splitlines():
        sentence_lines(context, column, sentence, "ERROR")
    is_small = stored["field_report"]["radius"] < stored["mesh_report"].get("mean_edge", 0.0)
    if is_small and context.scene.paradesc.radius_fit == "typed":
        column.operator("paradesc.bake", text=label("Bake with Fitted Radius"), translate=False).fit = "medium"


def draw_levels(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws the settings that change colors at once, with names inside the fields."""
    looks, column = context.scene.paradesc_looks, layout.column(align=True)
    setting(column, looks, "contrast", slider=True)
    setting(column, looks, "brightness", slider=True)
    row = column.row(align=True)
    row.prop(looks, "invert", text=label("Invert"), translate=False, toggle=True)
    if len([*islice(recolor.baked_targets(context), 2)]) == 2:
        row.prop(looks, "same_scale", text=label("Same Scale"), translate=False, toggle=True)


def draw_extremes(
    context: bpy.types.Context,
    layout: bpy.types.UILayout,
    seen: dict[str, float],
    percent: float,
    again: tuple[str, set[str]],
) -> None:
    """Draws a warning if nearly all of a mask of edges is white, with buttons for a smaller and a larger radius.

    Nothing is wrong with one that is black, or white if it is inverted: a cube has no hollows. If faces are too large,
    which the panel says above, no radius helps. seen: the extremes of the mask; percent: the radius in percent of the
    diagonal; again: the operator that baked the mask, and its descriptors.
    """
    operator, names = again
    is_white = seen.get("bright", 0.0) > color_maps.MOST_EXTREME and not context.scene.paradesc_looks.invert
    if not (is_white and percent > 0 and names & color_maps.EDGES) or large_faces.of_chosen(context):
        return
    masks = presets.masks_of(names)
    column = layout.column(align=True)
    sentence_lines(context, column, "Most of it is white", "INFO")
    row = column.row(align=True)
    for text, step in (("Finer", -1), ("Broader", 1)):
        asked = row.operator(operator, text=label(text), translate=False)
        asked.mask = masks[0] if len(masks) == 1 else PANEL[0]
        asked.fit, asked.radius = next_radius(context.scene.paradesc.radius_fit, percent, step)


def next_radius(size: str, percent: float, step: int) -> tuple[str, float]:
    """The next smaller (step: -1) or larger size (1) and 0; without one, half or twice the percentage."""
    sizes = [*advice.SIZES]
    place = sizes.index(size) + step if size in sizes else -1
    return (sizes[place], 0.0) if 0 <= place < len(sizes) else (PANEL[0], percent * 2.0**step)


def result_sentence(stored: dict[str, dict]) -> str:
    """One line about the last bake and its time: "Openness · 0.2 s"."""
    asked = stored["settings"].get("descriptors")
    names = [name for name in asked if isinstance(name, str)] if isinstance(asked, list) else []
    seconds = stored["field_report"]["seconds_total"]
    shown = f"{seconds:.1f}" if seconds >= 0.1 else f"{seconds:.2f}"
    return label("{what} · {seconds} s").format(what=baked_words(names), seconds=shown)


def baked_words(names: list[str]) -> str:
    """The labels of these descriptors' masks, the label of a single descriptor, or how many there are."""
    masks = presets.masks_of(set(names))
    if masks:
        return ", ".join(label(presets.PRESETS[mask].name) for mask in masks)
    known = {row.name: row.label for row in bridge.descriptors()}
    if len(names) == 1:
        return label(known.get(names[0], names[0]))
    return label("{count} descriptors").format(count=len(names))
