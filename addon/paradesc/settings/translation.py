"""Blender's translation for texts that Python puts together, and for tooltips that Python answers with.

Blender itself looks up every text that is handed to it as it stands in the code.
"""

import bpy

look_up = bpy.app.translations.pgettext_iface
# Blender before 4.1 keeps reports with tooltips.
look_up_report = getattr(bpy.app.translations, "pgettext_rpt", bpy.app.translations.pgettext_tip)


def label(text: str, context: str = "*") -> str:
    """A label in the language of the interface; format() fills its braces afterwards."""
    return look_up(text, context)


def said(sentence: str) -> str:
    """A sentence that an operator reports, in the language of reports; format() fills its braces afterwards."""
    return look_up_report(sentence)


def tooltip(text: str) -> str:
    """A tooltip, or a reason why a button is grey, in the language of tooltips."""
    return bpy.app.translations.pgettext_tip(text)
