"""The sidebar's panel about frames of an animation."""

import bpy

from paradesc.bridge import ParadescError
from paradesc.files import cache

from ..scene import targets
from ..settings.animation import object_cache
from ..settings.translation import label
from .drawing import SettingsPanel, sentence_lines, setting


class PARADESC_PT_animation(SettingsPanel, bpy.types.Panel):
    """Frames of an animation"""

    bl_label = "Animation"
    bl_idname = "PARADESC_PT_animation"
    bl_order = 40

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, _settings: object) -> None:
        """Draws frames, cache and button."""
        scene, group = context.scene, context.scene.paradesc_animation
        setting(layout, group, "frame_source")
        setting(layout, group, "use_scene_range")
        column = layout.column(align=True)
        if not group.use_scene_range:
            setting(column, group, "frame_start")
            setting(column, group, "frame_end")
        for name in ("frame_step", "relative_to_rest", "cache_folder", "overwrite"):
            setting(layout, group, name)
        layout.operator("paradesc.bake_frames", icon="RENDER_ANIMATION")
        for line in cache_lines(scene, targets.first(context)):
            sentence_lines(context, layout, line)


def cache_lines(scene: bpy.types.Scene, target: bpy.types.Object | None) -> list[str]:
    """Lines about the number of frames in an object's cache. Only file names are read, as panels redraw often."""
    if target is None:
        return []
    try:
        found = cache.frames_in(object_cache(scene, target))
    except ParadescError:
        return []
    if not found:
        return ["No frames in the cache"]
    line = label("{count} frames in the cache: {first} to {last}")
    return [line.format(count=f"{len(found):,}", first=min(found), last=max(found))]


classes = (PARADESC_PT_animation,)
