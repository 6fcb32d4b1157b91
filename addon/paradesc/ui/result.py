"""What the main panel says of the last bake of the active mesh: one line, what to show of it, and what limits it."""

import bpy

from .. import bridge
from ..scene import viewports
from ..settings import presets
from ..settings.translation import label
from ..show import recolor
from .drawing import descriptor_words, sentence_lines
from .report_panel import stored_report


def draw_result(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws it, if there was a bake whose values are still there."""
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
    """What a bake did and how long it took: "Openness · 0.2 s"."""
    asked = stored["settings"].get("descriptors")
    names = [name for name in asked if isinstance(name, str)] if isinstance(asked, list) else []
    seconds = f"{stored['field_report']['seconds_total']:.1f}"
    return label("{what} · {seconds} s").format(what=baked_words(names), seconds=seconds)


def baked_words(names: list[str]) -> str:
    """The mask that these descriptors are, or the only one of them, or how many there are."""
    mask = next((one for one in presets.MASKS if presets.PRESETS[one].members["descriptors"] == set(names)), "")
    if mask:
        return label(presets.PRESETS[mask].label)
    known = {row.name: row.label for row in bridge.descriptors()}
    if len(names) == 1:
        return label(known.get(names[0], names[0]))
    return label("{count} descriptors").format(count=len(names))


def shown_words(mesh: bpy.types.Mesh) -> str:
    """The descriptor whose colors the mesh shows, in words."""
    name = recolor.shown_name(mesh)
    return descriptor_words(name) if name else label("Choose what to show")
