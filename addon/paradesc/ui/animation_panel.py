"""The sidebar's panel about frames of an animation."""

import bpy

from ..animation.cache_places import object_cache
from ..bridge import ParadescError
from ..files import cache
from .drawing import SidebarPanel


class PARADESC_PT_animation(SidebarPanel, bpy.types.Panel):
    """Frames of an animation"""

    bl_label = "Animation"
    bl_options = {"DEFAULT_CLOSED"}
    bl_idname = "PARADESC_PT_animation"
    bl_order = 40
    bl_parent_id = "PARADESC_PT_bake"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws frames, cache and button."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        scene, group = context.scene, context.scene.paradesc_animation
        layout.prop(group, "frame_source")
        layout.prop(group, "use_scene_range")
        column = layout.column(align=True)
        if not group.use_scene_range:
            column.prop(group, "frame_start")
            column.prop(group, "frame_end")
        column.prop(group, "frame_step")
        layout.row(heading="Change").prop(group, "relative_to_rest", text="From Rest Pose")
        layout.prop(group, "cache_folder")
        layout.prop(group, "overwrite")
        layout.operator("paradesc.bake_frames", icon="RENDER_ANIMATION")
        for line in cache_lines(scene, context.active_object):
            layout.label(text=line)


def cache_lines(scene: bpy.types.Scene, target: bpy.types.Object | None) -> list[str]:
    """Says how many frames of an object the cache has, by file names alone, because panels are drawn often."""
    if target is None or target.type != "MESH":
        return []
    try:
        found = cache.frames_in(object_cache(scene, target))
    except ParadescError:
        return []
    return (
        [f"{len(found):,} frames in the cache: {min(found)} to {max(found)}"] if found else ["No frames in the cache"]
    )


classes = (PARADESC_PT_animation,)
