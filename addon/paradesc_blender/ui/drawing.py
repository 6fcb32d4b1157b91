"""The shared parts of panels: their place in the sidebar, settings, and sentences wrapped to its width."""

import re
from collections.abc import Callable
from functools import partial

import blf
import bpy

from paradesc import bridge
from paradesc.core import legend
from paradesc.core.job import registry_row

from ..bake.modal import ModalJob
from ..settings import research
from ..settings.translation import label

# The pixels of a line that are not text, at scale 1: the panel's margins, and an icon.
MARGIN, ICON = 58, 24
# Blender's default font, in which it draws labels.
FONT = 0
# A piece that no line breaks: a word with the space before it, or a Chinese or Japanese character with punctuation.
SIGN = "\u2e80-\u3000\u3003-\u9fff\uff00-\uffef"
WORD = re.compile(f" ?(?:[^ {SIGN}，．、。：；）」！？]+|[「（]?[{SIGN}])[，．、。：；）」！？]*")


class SidebarPanel:
    """Base of all panels, in the Paradesc tab of the 3D viewport's sidebar. Subclasses define draw_settings()."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Paradesc"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws the settings in Blender's two columns; grey during a bake, which has already taken their values."""
        in_two_columns(self.layout)
        self.layout.enabled = ModalJob.running is None
        self.draw_settings(context, self.layout, context.scene.paradesc)


class SettingsPanel(SidebarPanel):
    """Base of the sub-panels, which are closed at first."""

    bl_parent_id = "PARADESC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Works only with the native library, which defines the descriptors."""
        return not bridge.missing_sentence()


def in_two_columns(layout: bpy.types.UILayout) -> None:
    """Makes Blender draw names before values, without the dots for animation."""
    layout.use_property_split = True
    layout.use_property_decorate = False


def setting(layout: bpy.types.UILayout, group: bpy.types.PropertyGroup, name: str, **options: object) -> None:
    """Draws a setting, unless it is a hidden research setting. A switch has the whole width."""
    if research.is_hidden(group, name):
        return
    if group.bl_rna.properties[name].type == "BOOLEAN":
        layout = layout.row()
        layout.use_property_split = False
    layout.prop(group, name, text=label(group.bl_rna.properties[name].name), translate=False, **options)


def choice(layout: bpy.types.UILayout, group: bpy.types.PropertyGroup, name: str, chosen: str) -> None:
    """Draws one choice of a setting as a button."""
    words = group.bl_rna.properties[name].enum_items[chosen].name
    layout.prop_enum(group, name, chosen, text=label(words), translate=False)


def sentence_lines(context: bpy.types.Context, layout: bpy.types.UILayout, sentence: str, icon: str = "NONE") -> None:
    """Draws a sentence wrapped to the sidebar's width, with an icon in its first line if one is given."""
    column = layout.column(align=True)
    has_icon = icon != "NONE"
    lines = wrapped(label(sentence), room(context, has_icon), partial(text_width, context))
    for index, line in enumerate(lines):
        column.label(text=line, icon="BLANK1" if has_icon and index else icon, translate=False)


def room(context: bpy.types.Context, has_icon: bool = False) -> float:
    """The width in pixels for the text of a line at the sidebar's present width."""
    return context.region.width - (MARGIN + has_icon * ICON) * scale(context)


def scale(context: bpy.types.Context) -> float:
    """The scale of the interface; 1 if Blender has not set it yet."""
    return context.preferences.system.ui_scale or 1.0


def text_width(context: bpy.types.Context, text: str) -> float:
    """The width in pixels of a text in Blender's labels."""
    blf.size(FONT, context.preferences.ui_styles[0].widget.points * scale(context))
    return blf.dimensions(FONT, text)[0]


def descriptor_words(name: str) -> str:
    """The label of a descriptor's values, with their radius if there are several."""
    return label(registry_row(name).label) + legend.label_ending(name)


def wrapped(sentence: str, most: float, width_of: Callable[[str], float] = len) -> list[str]:
    """The sentence in lines of at most this width, except longer words. Blender's labels do not wrap by themselves."""
    lines = [""]
    for word in WORD.findall(" ".join(sentence.split())):
        longer = (lines[-1] + word).strip()
        if lines[-1] and width_of(longer) > most:
            lines.append(word.strip())
        else:
            lines[-1] = longer
    return lines
