"""What the panels share: their place in the sidebar, and sentences in lines that fit into it."""

import bpy

from .. import bridge

# Widths in the sidebar, in pixels at Blender's own scale: a character, what lies beside the text, an icon.
CHARACTER, MARGIN, ICON = 5.5, 46, 28


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


def sentence_lines(context: bpy.types.Context, layout: bpy.types.UILayout, sentence: str, icon: str) -> None:
    """Draws a sentence in lines, the first with an icon."""
    column = layout.column(align=True)
    for index, line in enumerate(wrapped(sentence, line_length(context, ICON))):
        column.label(text=line, icon="BLANK1" if index else icon)


def line_length(context: bpy.types.Context, taken: int = 0) -> int:
    """How many characters fit beside each other at the present width of the sidebar."""
    width = context.region.width / context.preferences.system.ui_scale
    return max(int((width - MARGIN - taken) / CHARACTER), 16)


def wrapped(sentence: str, width: int) -> list[str]:
    """The sentence in lines of at most width characters: Blender's labels do not wrap."""
    lines = [""]
    for word in sentence.split():
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
