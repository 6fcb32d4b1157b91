"""The settings that few people need, because they compare methods, reproduce the paper or serve pipelines.

Panels draw them if the preference Research Settings is on. They keep their values either way, and the panel says so if
one of them differs from its default, so that none has an effect unseen.
"""

import bpy

from paradesc import bridge

from . import preferences

# The research settings, by the property group of the scene.
RESEARCH = {
    "paradesc": (
        *(row.name for row in bridge.TABLE if row.research or row.panel == "method"),
        *("corner_threshold", "more_radii", "material_maps"),
    ),
    "paradesc_looks": ("symmetric", "use_neutral", "neutral", "pack_name", "pack_kind", "pack_domain"),
    "paradesc_animation": ("frame_source", "relative_to_rest"),
    "paradesc_live": ("samples", "buffer_size", "full_render", "missing"),
}
# This setting has an effect only while another one is on.
PARTS = {"neutral": "use_neutral"}


def is_hidden(group: bpy.types.PropertyGroup, name: str) -> bool:
    """Returns whether the panels hide this setting of a scene."""
    return name in RESEARCH.get(group.path_from_id(), ()) and not preferences.shows_research()


def changed(scene: bpy.types.Scene) -> list[tuple[bpy.types.PropertyGroup, str]]:
    """The research settings of a scene that have an effect, as they are not at their defaults."""
    every = [(getattr(scene, place), name) for place, names in RESEARCH.items() for name in names]
    acting = [(group, name) for group, name in every if name not in PARTS or getattr(group, PARTS[name])]
    return [(group, name) for group, name in acting if getattr(group, name) != group.bl_rna.properties[name].default]


class PARADESC_OT_show_research(bpy.types.Operator):
    """Switch on Research Settings in the add-on's preferences, so that the panels draw every setting"""

    bl_idname = "paradesc.show_research"
    bl_label = "Show"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Works only if the add-on is enabled and so has preferences."""
        return preferences.found() is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Turns the preference on, as the user would."""
        preferences.found().research_settings = True
        context.preferences.is_dirty = True
        return {"FINISHED"}


class PARADESC_OT_reset_research(bpy.types.Operator):
    """Reset all research settings of this scene to their defaults"""

    bl_idname = "paradesc.reset_research"
    bl_label = "Reset"
    bl_options = {"INTERNAL", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Resets the settings that differ; their update callbacks run."""
        for group, name in changed(context.scene):
            setattr(group, name, group.bl_rna.properties[name].default)
            group.property_unset(name)
        return {"FINISHED"}


classes = (PARADESC_OT_show_research, PARADESC_OT_reset_research)
