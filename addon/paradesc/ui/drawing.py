"""What the panels share: their place in the sidebar, and sentences in lines that fit into it."""

from collections.abc import Callable
from functools import partial

import blf
import bpy

from .. import bridge
from ..core import legend
from ..core.job import registry_row
from ..settings.translation import label

# Widths in the sidebar, in pixels at Blender's own scale: what lies beside the text, an icon.
MARGIN, ICON = 58, 24
# In a button, what lies beside its text, and its icon or the arrow of a menu; the share of a line for a setting's name.
PADDING, BUTTON_ICON, LABEL_SHARE = 3, 18, 0.4
# Blender's own, in which labels are drawn.
FONT = 0


class SidebarPanel:
    """The place of all panels: the Paradesc tab of the 3D viewport's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Paradesc"


class SettingsPanel(SidebarPanel):
    """A sub-panel of settings, closed until somebody wants it."""

    bl_parent_id = "PARADESC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Needs the native library, which has the descriptors."""
        return not bridge.missing_sentence()

    def draw(self, context: bpy.types.Context) -> None:
        """Draws in Blender's two columns, without the dots for animation."""
        in_two_columns(self.layout)
        self.draw_settings(context, self.layout, context.scene.paradesc)


def in_two_columns(layout: bpy.types.UILayout) -> None:
    """Makes Blender draw names before settings, without the dots for animation."""
    layout.use_property_split = True
    layout.use_property_decorate = False


def sentence_lines(context: bpy.types.Context, layout: bpy.types.UILayout, sentence: str, icon: str = "NONE") -> None:
    """Draws a sentence in lines that fit into the sidebar, the first with an icon if there is one."""
    column = layout.column(align=True)
    has_icon = icon != "NONE"
    lines = wrapped(label(sentence), room(context, has_icon), partial(text_width, context))
    for index, line in enumerate(lines):
        column.label(text=line, icon="BLANK1" if has_icon and index else icon, translate=False)


def button(
    context: bpy.types.Context, layout: bpy.types.UILayout, name: str, text: str = "", **options: object
) -> object:
    """Draws the button of an operator with its own label, or a text that is translated by now; gives its properties."""
    own = getattr(bpy.ops.paradesc, name.removeprefix("paradesc.")).get_rna_type().name
    words, icon = text or label(own, "Operator"), options.pop("icon", "NONE")
    part, words = place(context, layout, words, icon != "NONE")
    icon = icon if words or icon != "NONE" else "TRIA_RIGHT"
    return part.operator(name, text=words, icon=icon, translate=False, **options)


def place(
    context: bpy.types.Context, layout: bpy.types.UILayout, text: str, has_icon: bool = False, others: int = 0
) -> tuple[bpy.types.UILayout, str]:
    """Where to draw what has a text, and the text; if it is too wide, it stands in lines beside, and is "" there.

    others: how many icons more there will be in the line.
    """
    taken = others * ICON * scale(context)
    if text_width(context, text) <= room(context) - (PADDING + has_icon * BUTTON_ICON) * scale(context) - taken:
        return layout, text
    row = layout.row(align=True)
    part = row.row()
    column = row.column(align=True)
    for line in wrapped(text, room(context, has_icon=True) - taken, partial(text_width, context)):
        column.label(text=line, translate=False)
    return part, ""


def side_by_side(
    context: bpy.types.Context, layout: bpy.types.UILayout, texts: list[str], has_icon: bool = False
) -> bpy.types.UILayout:
    """A row for buttons of these texts, which share it evenly; a column where one of them would be cut."""
    there = all(fits(context, text, 1 / len(texts), has_icon) for text in texts)
    return layout.row(align=True) if there else layout.column(align=True)


def setting(
    context: bpy.types.Context,
    layout: bpy.types.UILayout,
    group: object,
    name: str,
    beside: tuple[str, str] | None = None,
) -> None:
    """Draws a setting with its name before it, or above it where one of the two would be cut.

    beside: an operator and its icon, drawn behind the value.
    """
    member = group.bl_rna.properties[name]
    words = label(member.name, member.translation_context)
    row = layout.row(align=True)
    if member.type == "BOOLEAN":
        row.use_property_split = False
        part, words = place(context, row, words, has_icon=True)
        part.prop(group, name, text=words, translate=False)
        return
    item = member.enum_items.get(getattr(group, name)) if member.type == "ENUM" else None
    value = label(item.name) if item is not None else getattr(group, name) if member.type == "STRING" else ""
    text = None
    if not (fits(context, words, LABEL_SHARE) and fits(context, value, 1 - LABEL_SHARE, has_icon=True)):
        column = row.column(align=True)
        column.label(text=words, translate=False)
        row, text = column.row(align=True), ""
        row.use_property_split = False
    part, value = (row, value) if item is None else place(context, row, value, has_icon=True)
    if item is not None and not value:
        part.prop_menu_enum(group, name, text="", icon="DOWNARROW_HLT")
    else:
        part.prop(group, name, text=text)
    if beside is not None:
        row.operator(beside[0], text="", icon=beside[1])


def fits(context: bpy.types.Context, text: str, share: float = 1.0, has_icon: bool = False) -> bool:
    """Whether a button with a text is seen whole on a share of the sidebar's width."""
    beside = (PADDING + has_icon * BUTTON_ICON) * scale(context)
    return text_width(context, text) <= share * room(context) - beside


def room(context: bpy.types.Context, has_icon: bool = False) -> float:
    """How wide a line may be at the present width of the sidebar, in pixels."""
    return context.region.width - (MARGIN + has_icon * ICON) * scale(context)


def scale(context: bpy.types.Context) -> float:
    """The interface's scale; 1 if Blender has none yet."""
    return context.preferences.system.ui_scale or 1.0


def text_width(context: bpy.types.Context, text: str) -> float:
    """How wide a text is in Blender's labels, in pixels."""
    preferences = context.preferences
    blf.size(FONT, preferences.ui_styles[0].widget.points * scale(context))
    return blf.dimensions(FONT, text)[0]


def descriptor_words(name: str) -> str:
    """The label of a descriptor's values, which may be those of one radius among several."""
    return label(registry_row(name).label) + legend.label_ending(name)


def wrapped(sentence: str, most: float, width_of: Callable[[str], float] = len) -> list[str]:
    """The sentence in lines that are at most so wide, if no word is wider: Blender's labels do not wrap."""
    lines = [""]
    for word in sentence.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and width_of(longer) > most:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines
