"""The settings of a scene that say which mesh of an object is measured, at which frames, and where those are kept."""

from pathlib import Path

import bpy

from paradesc.bridge import InputError
from paradesc.core.source_kinds import AUTOMATIC, AUTOMATIC_SOURCE, DEFORMED, ORIGINAL, SOURCES
from paradesc.files import cache

from .properties import path_options

# Files store choices as numbers.
AS_SOURCE = ("source", "As Source", "Mesh that a single bake measures; Deformed in place of Base Mesh")
DEFAULT_CACHE = f"//{cache.DEFAULT_FOLDER}"


class PARADESC_PG_animation(bpy.types.PropertyGroup):
    """The mesh and the frames that are measured in one scene."""

    source: bpy.props.EnumProperty(
        name="Source",
        description="Mesh that a single bake measures",
        items=[*SOURCES, AUTOMATIC_SOURCE],
        default=AUTOMATIC,
    )
    frame_source: bpy.props.EnumProperty(
        name="Frame Source",
        description="Mesh that is measured at each frame",
        items=[*SOURCES[1:], AS_SOURCE],
        default=AS_SOURCE[0],
    )
    use_scene_range: bpy.props.BoolProperty(
        name="Scene Range", description="Bake the frames from the scene's start to its end", default=True
    )
    frame_start: bpy.props.IntProperty(name="Start", description="First frame to bake", default=1)
    frame_end: bpy.props.IntProperty(name="End", description="Last frame to bake", default=250)
    frame_step: bpy.props.IntProperty(name="Step", description="Interval between baked frames", default=1, min=1)
    cache_folder: bpy.props.StringProperty(
        name="Cache",
        description="Folder of the frames, which have a folder for each object; // is the folder of the .blend",
        subtype="DIR_PATH",
        default=DEFAULT_CACHE,
        options=path_options(),
    )
    relative_to_rest: bpy.props.BoolProperty(
        name="Change from Rest Pose",
        description="Also the change against the original mesh, as values of their own (mean_curvature_change)",
        default=False,
    )
    overwrite: bpy.props.BoolProperty(
        name="Overwrite", description="Compute frames again that are already in the cache", default=False
    )


def frame_source(group: bpy.types.PropertyGroup) -> str:
    """The source of frames in a scene; AUTOMATIC stands for one that depends on each object."""
    chosen = group.source if group.frame_source == AS_SOURCE[0] else group.frame_source
    return DEFORMED if chosen == ORIGINAL else chosen


def wanted_frames(scene: bpy.types.Scene) -> range:
    """The frames that the settings name."""
    group = scene.paradesc_animation
    first, last = scene.frame_start, scene.frame_end
    if not group.use_scene_range:
        first, last = group.frame_start, group.frame_end
    try:
        return cache.frame_range(first, last, group.frame_step)
    except ValueError as error:
        raise InputError(str(error)) from error


def cache_root(scene: bpy.types.Scene) -> Path:
    """The folder of all objects' frames."""
    folder = scene.paradesc_animation.cache_folder or DEFAULT_CACHE
    if folder.startswith("//") and not bpy.data.filepath:
        raise InputError("Save the .blend first, or choose a cache folder that does not begin with //.")
    return Path(bpy.path.abspath(folder))


def object_cache(scene: bpy.types.Scene, target: bpy.types.Object) -> Path:
    """The folder of one object's frames."""
    return cache.object_folder(cache_root(scene), target.name)


classes = (PARADESC_PG_animation,)
GROUPS = {(bpy.types.Scene, "paradesc_animation"): PARADESC_PG_animation}
