"""Replaces the whole add-on if it cannot be imported: says in one sentence why, and what to do."""

import sys

import bpy

# The name of the package, which is the add-on's name in Blender's preferences.
ADDON = __package__.rpartition(".")[0]
# The number of letters in a line of a sidebar of default width. Measuring text would need modules that may be missing.
LINE = 28
# Seconds until a window shows the sentence, which is impossible while Blender starts or draws its preferences.
SOON = 0.2
sentence = [""]


class OtherVersionError(ImportError):
    """The package paradesc that Python finds is of another version; the text is the sentence."""


def sentence_of(error: ImportError) -> str:
    """One sentence that says what is wrong, and what to do."""
    if (error.name or "").partition(".")[0] == "numpy" and isinstance(error, ModuleNotFoundError):
        return (
            'Paradesc needs NumPy, which this Blender lacks: on Debian and Ubuntu run "sudo apt install '
            'python3-numpy" and start Blender again, or take a Blender from blender.org, which brings it.'
        )
    if isinstance(error, OtherVersionError):
        return str(error)
    words = " ".join(str(error).split())[:200].rstrip(".") or type(error).__name__
    return f"Paradesc cannot be loaded ({words}): install it again, for a Blender of this system and version."


class PARADESC_AP_failure(bpy.types.AddonPreferences):
    """In Blender's Preferences, below the add-on's entry"""

    bl_idname = ADDON

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws the sentence."""
        draw_sentence(self.layout)


class PARADESC_PT_failure(bpy.types.Panel):
    """A sentence that says what is wrong, in place of the add-on's panels"""

    bl_label = "Paradesc"
    bl_idname = "PARADESC_PT_failure"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Paradesc"

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws the sentence."""
        draw_sentence(self.layout)


def draw_sentence(layout: bpy.types.UILayout) -> None:
    """Draws the sentence in lines of a few words, since labels do not wrap."""
    column, line = layout.column(align=True), ""
    for word in [*sentence[0].split(), ""]:
        if line and (not word or len(line) + len(word) > LINE):
            column.label(text=line, translate=False)
            line = ""
        line = f"{line} {word}".strip()


def pop_up() -> None:
    """Shows the sentence in the window."""
    bpy.context.window_manager.popup_menu(lambda menu, _context: draw_sentence(menu.layout), title="Paradesc")


CLASSES = (PARADESC_AP_failure, PARADESC_PT_failure)


def register(error: ImportError) -> None:
    """Shows the sentence: in the console, in a window, in the preferences and in the sidebar."""
    sentence[0] = sentence_of(error)
    sys.stderr.write(f"{sentence[0]}\n")
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    if not bpy.app.background:
        bpy.app.timers.register(pop_up, first_interval=SOON)


def unregister() -> bool:
    """Removes the sentence; returns False if it is not registered."""
    if not hasattr(bpy.types, PARADESC_PT_failure.bl_idname):
        return False
    if bpy.app.timers.is_registered(pop_up):
        bpy.app.timers.unregister(pop_up)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    return True
