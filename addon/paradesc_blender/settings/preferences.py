"""The add-on's own preferences, which apply to this machine and not to a scene."""

import re
from pathlib import Path

import bpy

from . import asset_library
from .translation import label

# Blender finds the preferences by the name of the add-on's package, which contains this folder.
ADDON = __package__.rpartition(".")[0]
GIGABYTE = 1_000_000_000


class PARADESC_AP_preferences(bpy.types.AddonPreferences):
    """In Blender's Preferences, below the add-on's entry"""

    bl_idname = ADDON

    memory_limit: bpy.props.FloatProperty(
        name="Memory Limit (GB)",
        description="Refuse bakes that need more memory than this; 0 is automatic, half of what is free at the time",
        default=0.0,
        min=0.0,
        soft_max=64.0,
        max=1e6,
        step=100,
        precision=1,
    )

    show_results: bpy.props.BoolProperty(
        name="Show Results",
        description="After a bake or with Live, solid viewports show the colors in flat light; the eye button restores "
        "them",
        default=True,
    )
    presets_folder: bpy.props.StringProperty(
        name="Presets Folder",
        description="A folder whose presets the panel lists below your own, such as one that a studio shares",
        default="",
        subtype="DIR_PATH",
    )

    research_settings: bpy.props.BoolProperty(
        name="Research Settings",
        description="Show every setting in the panels, including those that compare methods and reproduce the paper",
        default=False,
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """Draws the settings, and where to read on."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "show_results")
        layout.prop(self, "research_settings")
        limit = layout.row()
        limit.prop(self, "memory_limit")
        if self.memory_limit == 0:
            limit.label(text=label("Automatic"), translate=False)
        layout.prop(self, "presets_folder")
        asset_library.draw(layout)
        row = layout.row()
        row.operator("paradesc.manual", text=label("Documentation"), translate=False, icon="HELP")
        home = website()
        if home:
            row.operator("wm.url_open", text=label("Website"), translate=False, icon="URL").url = home
        if tracker(home):
            row.operator("wm.url_open", text=label("Report a Bug"), translate=False, icon="ERROR").url = tracker(home)


def found() -> PARADESC_AP_preferences | None:
    """The preferences; None if the add-on is imported but not enabled."""
    addon = bpy.context.preferences.addons.get(ADDON)
    return None if addon is None else addon.preferences


def shows_research() -> bool:
    """Returns whether the panels draw every setting."""
    preferences = found()
    return preferences is not None and preferences.research_settings


def memory_limit() -> int:
    """The memory in bytes that a computation may take; 0 if there is no limit."""
    preferences = found()
    return 0 if preferences is None else round(preferences.memory_limit * GIGABYTE)


def shows_results() -> bool:
    """Returns whether viewports show the results of a bake at once."""
    preferences = found()
    return True if preferences is None else preferences.show_results


def presets_folder() -> Path | None:
    """The folder of shared presets; None if the preferences name none."""
    preferences = found()
    chosen = "" if preferences is None else preferences.presets_folder
    return Path(bpy.path.abspath(chosen)) if chosen else None


def website() -> str:
    """The address in the package's manifest, or ""."""
    manifest = Path(__file__).resolve().parents[1] / "blender_manifest.toml"
    text = manifest.read_text(encoding="utf-8") if manifest.is_file() else ""
    named = re.search(r'^website = "([^"]+)"', text, re.MULTILINE)
    return named[1] if named else ""


def tracker(home: str) -> str:
    """The address for bug reports, if the website is a repository on a forge; else ""."""
    repository = re.fullmatch(r"(https://(?:github\.com|gitlab\.com|codeberg\.org)/[\w.-]+/[\w.-]+?)/?", home)
    return f"{repository[1]}/issues" if repository else ""


classes = (PARADESC_AP_preferences,)
