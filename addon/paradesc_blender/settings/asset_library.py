"""Offers the add-on's groups and materials in Blender's Asset Browser, where the user asks for it."""

from pathlib import Path

import bpy

from . import translation

FOLDER = Path(__file__).resolve().parents[1] / "assets"
FILE = FOLDER / "paradesc.blend"
NAME = "Paradesc"


def place() -> int:
    """The index of our folder among the asset libraries of the preferences, or -1."""
    libraries = bpy.context.preferences.filepaths.asset_libraries
    return next((number for number, one in enumerate(libraries) if one.path and Path(one.path) == FOLDER), -1)


class PARADESC_OT_asset_library(bpy.types.Operator):
    """Show Paradesc's materials and node groups in the Asset Browser, or remove them from it"""

    bl_idname = "paradesc.asset_library"
    bl_label = "Add to Asset Browser"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Adds the folder to the asset libraries of the preferences; removes it if it is there."""
        libraries, found = context.preferences.filepaths.asset_libraries, place()
        if found >= 0:
            bpy.ops.preferences.asset_library_remove(index=found)
            self.report({"INFO"}, translation.said("Removed from the Asset Browser"))
            return {"FINISHED"}
        bpy.ops.preferences.asset_library_add(directory=str(FOLDER))
        libraries[len(libraries) - 1].name = NAME
        self.report({"INFO"}, translation.said("Added to the Asset Browser, as the library Paradesc"))
        return {"FINISHED"}


def draw(layout: bpy.types.UILayout) -> None:
    """Draws the button, with a label for what it will do."""
    there = place() >= 0
    words = translation.label("Remove from Asset Browser" if there else "Add to Asset Browser")
    layout.operator("paradesc.asset_library", text=words, icon="ASSET_MANAGER", translate=False)


classes = (PARADESC_OT_asset_library,)
