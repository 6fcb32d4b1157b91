"""The add-on's own preferences, which apply to this machine and not to a scene."""

from pathlib import Path

import bpy

from . import asset_library

# Blender finds the preferences by the name of the add-on's package, which contains this folder.
ADDON = __package__.rpartition(".")[0]
GIGABYTE = 1_000_000_000


class PARADESC_AP_preferences(bpy.types.AddonPreferences):
    """In Blender's Preferences, below the add-on's entry"""

    bl_idname = ADDON

    memory_limit: bpy.props.FloatProperty(
        name="Memory Limit (GB)",
        description="What would take more memory than this is refused before it begins; 0: half of what is free then",
        default=0.0,
        min=0.0,
        soft_max=64.0,
        max=1e6,
        step=100,
        precision=1,
    )

    show_results: bpy.props.BoolProperty(
        name="Show Results",
        description="After a bake, solid viewports show its colors; the panel's Restore Shading takes that back",
        default=True,
    )
    presets_folder: bpy.props.StringProperty(
        name="Presets Folder",
        description="A folder whose presets the panel lists below your own, such as one that a studio shares",
        default="",
        subtype="DIR_PATH",
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws the settings."""
        self.layout.use_property_split = True
        for name in ("show_results", "memory_limit", "presets_folder"):
            self.layout.prop(self, name)
        asset_library.draw(self.layout)


def found() -> PARADESC_AP_preferences | None:
    """The preferences, or None if the add-on is imported but not enabled."""
    addon = bpy.context.preferences.addons.get(ADDON)
    return None if addon is None else addon.preferences


def memory_limit() -> int:
    """Bytes that a computation may take; 0 if nobody has set a limit."""
    preferences = found()
    return 0 if preferences is None else round(preferences.memory_limit * GIGABYTE)


def shows_results() -> bool:
    """Whether viewports show what was baked, without a further click."""
    preferences = found()
    return True if preferences is None else preferences.show_results


def presets_folder() -> Path | None:
    """The folder of shared presets, or None if nobody has named one."""
    preferences = found()
    chosen = "" if preferences is None else preferences.presets_folder
    return Path(bpy.path.abspath(chosen)) if chosen else None


classes = (PARADESC_AP_preferences,)
