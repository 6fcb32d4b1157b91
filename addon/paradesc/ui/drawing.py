"""The parts that panels share: their place in the sidebar, settings, and sentences in lines that fit into it."""

import re
from collections.abc import Callable
from functools import partial

import blf
import bpy

from .. import bridge
from ..bake.modal import ModalJob
from ..core import legend
from ..core.job import registry_row
from ..settings import research
from ..settings.translation import label

# Pixels beside a line's text at Blender's own scale: the panel's margins, and an icon.
MARGIN, ICON = 58, 24
# Blender's own, in which labels are drawn.
FONT = 0
# A piece that no line breaks: a word with the space before it, or a Chinese or Japanese sign with the commas behind it.
SIGN = "\u2e80-\u3000\u3003-\u9fff\uff00-\uffef"
WORD = re.compile(f" ?(?:[^ {SIGN}，．、。：；）」！？]+|[「（]?[{SIGN}])[，．、。：；）」！？]*")


class SidebarPanel:
    """The place of all panels: the Paradesc tab of the 3D viewport's sidebar. They have draw_settings()."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Paradesc"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws in Blender's two columns, grey while a bake runs, which has taken its settings."""
        in_two_columns(self.layout)
        self.layout.enabled = ModalJob.running is None
        self.draw_settings(context, self.layout, context.scene.paradesc)


class SettingsPanel(SidebarPanel):
    """A sub-panel, closed until somebody wants it."""

    bl_parent_id = "PARADESC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Needs the native library, which has the descriptors."""
        return not bridge.missing_sentence()


def in_two_columns(layout: bpy.types.UILayout) -> None:
    """Makes Blender draw names before settings, without the dots for animation."""
    layout.use_property_split = True
    layout.use_property_decorate = False


def setting(layout: bpy.types.UILayout, group: bpy.types.PropertyGroup, name: str, **options: object) -> None:
    """Draws a setting, a switch over the whole width, unless it is one for research and those are hidden."""
    if research.is_hidden(group, name):
        return
    if group.bl_rna.properties[name].type == "BOOLEAN":
        layout = layout.row()
        layout.use_property_split = False
    layout.prop(group, name, text=label(group.bl_rna.properties[name].name), translate=False, **options)


def choice(layout: bpy.types.UILayout, group: bpy.types.PropertyGroup, name: str, chosen: str) -> None:
    """Draws a button for one of the choices of a setting."""
    words = group.bl_rna.properties[name].enum_items[chosen].name
    layout.prop_enum(group, name, chosen, text=label(words), translate=False)


def sentence_lines(context: bpy.types.Context, layout: bpy.types.UILayout, sentence: str, icon: str = "NONE") -> None:
    """Draws a sentence in lines that fit into the sidebar, the first with an icon if there is one."""
    column = layout.column(align=True)
    has_icon = icon != "NONE"
    lines = wrapped(label(sentence), room(context, has_icon), partial(text_width, context))
    for index, line in enumerate(lines):
        column.label(text=line, icon="BLANK1" if has_icon and index else icon, translate=False)


def room(context: bpy.types.Context, has_icon: bool = False) -> float:
    """How wide a line may be at the present width of the sidebar, in pixels."""
    return context.region.width - (MARGIN + has_icon * ICON) * scale(context)


def scale(context: bpy.types.Context) -> float:
    """The interface's scale; 1 if Blender has none yet."""
    return context.preferences.system.ui_scale or 1.0


def text_width(context: bpy.types.Context, text: str) -> float:
    """How wide a text is in Blender's labels, in pixels."""
    blf.size(FONT, context.preferences.ui_styles[0].widget.points * scale(context))
    return blf.dimensions(FONT, text)[0]


def descriptor_words(name: str) -> str:
    """The label of a descriptor's values, which may be those of one radius among several."""
    return label(registry_row(name).label) + legend.label_ending(name)


def wrapped(sentence: str, most: float, width_of: Callable[[str], float] = len) -> list[str]:
    """The sentence in lines that are at most so wide, if no word is wider: Blender's labels do not wrap."""
    lines = [""]
    for word in WORD.findall(" ".join(sentence.split())):
        longer = (lines[-1] + word).strip()
        if lines[-1] and width_of(longer) > most:
            lines.append(word.strip())
        else:
            lines[-1] = longer
    return lines
