"""Finds the frames of a scene that are baked, and their folders."""

from pathlib import Path

import bpy

from paradesc.files import cache

from ..scene.mesh_io import refuse
from ..settings.animation import DEFAULT_CACHE


def wanted_frames(scene: bpy.types.Scene) -> range:
    """The frames that the settings name."""
    group = scene.paradesc_animation
    first, last = scene.frame_start, scene.frame_end
    if not group.use_scene_range:
        first, last = group.frame_start, group.frame_end
    try:
        return cache.frame_range(first, last, group.frame_step)
    except ValueError as error:
        raise refuse(str(error)) from error


def cache_root(scene: bpy.types.Scene) -> Path:
    """The folder of all objects' frames."""
    folder = scene.paradesc_animation.cache_folder or DEFAULT_CACHE
    if folder.startswith("//") and not bpy.data.filepath:
        raise refuse("Save the .blend first, or choose a cache folder that does not begin with //.")
    return Path(bpy.path.abspath(folder))


def object_cache(scene: bpy.types.Scene, target: bpy.types.Object) -> Path:
    """The folder of one object's frames."""
    return cache.object_folder(cache_root(scene), target.name)
