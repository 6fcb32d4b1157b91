"""What the panels share: their place in the sidebar, and sentences in lines that fit into it."""

from collections.abc import Callable
from functools import partial

import blf
import bpy

from .. import bridge

# Widths in the sidebar, in pixels at Blender's own scale: what lies beside the text, an icon.
MARGIN, ICON = 58, 24
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
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.draw_settings(context, self.layout, context.scene.paradesc)


def sentence_lines(context: bpy.types.Context, layout: bpy.types.UILayout, sentence: str, icon: str = "NONE") -> None:
    """Draws a sentence in lines that fit into the sidebar, the first with an icon if there is one."""
    column = layout.column(align=True)
    has_icon = icon != "NONE"
    lines = wrapped(sentence, room(context, has_icon), partial(text_width, context))
    for index, line in enumerate(lines):
        column.label(text=line, icon="BLANK1" if has_icon and index else icon)


def room(context: bpy.types.Context, has_icon: bool = False) -> float:
    """How wide a line may be at the present width of the sidebar, in pixels."""
    return context.region.width - (MARGIN + has_icon * ICON) * (context.preferences.system.ui_scale or 1.0)


def text_width(context: bpy.types.Context, text: str) -> float:
    """How wide a text is in Blender's labels, in pixels."""
    preferences = context.preferences
    blf.size(FONT, preferences.ui_styles[0].widget.points * (preferences.system.ui_scale or 1.0))
    return blf.dimensions(FONT, text)[0]


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
