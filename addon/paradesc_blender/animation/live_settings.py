"""The settings of live values and playback on scenes and objects, with their update callbacks."""

import bpy

from ..settings.hooks import OVERRIDABLE
from . import handlers, painting, sessions

MODES = [
    ("OFF", "Off", "Values stay as they were baked"),
    ("LIVE", "Live", "Compute the values of the deformed shape at every frame, after every edit, and in renders"),
    ("CACHE", "Cache", "Play the frames that Bake Frames left in the cache; nothing is computed"),
]
MISSING = [
    ("HOLD", "Hold Nearest", "Show the values of the nearest frame that is there"),
    ("COMPUTE", "Compute", "Compute them as live mode does"),
]


def mode_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Starts or ends live values. Values that remain are recognized as ours until somebody paints over them."""
    handlers.mode_changed(group.id_data)
    if group.mode == "OFF":
        painting.leave(group.id_data)


def settings_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Brings all live objects up to date with the settings."""
    sessions.refresh_window(sessions.live_objects(), watched=True)


def range_changed(group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Marks a range as typed by the user, so that it stays, and brings live objects up to date."""
    if not sessions.is_ours():
        group.typed = True
        settings_changed(group, context)


class PARADESC_PG_live_range(bpy.types.PropertyGroup):
    """The values that the two ends of a descriptor's colors stand for, at every frame and on every live object."""

    name: bpy.props.StringProperty(name="Descriptor", description="Whose values these are")
    minimum: bpy.props.FloatProperty(
        name="From", description="Value at the lower end of the colors", precision=4, update=range_changed
    )
    maximum: bpy.props.FloatProperty(
        name="To", description="Value at the upper end of the colors", precision=4, update=range_changed
    )
    typed: bpy.props.BoolProperty(name="Typed", description="Somebody set the range, so it stays", options={"HIDDEN"})


class PARADESC_PG_live(bpy.types.PropertyGroup):
    """Live mode's settings of one scene."""

    samples: bpy.props.IntProperty(
        name="Samples",
        description="At most so many samples around every vertex in the viewport; fewer are faster",
        default=16,
        min=8,
        max=4096,
        update=settings_changed,
    )
    buffer_size: bpy.props.IntProperty(
        name="Resolution",
        description="At most so many texels along a side of the baked buffers in the viewport",
        default=512,
        min=64,
        max=8192,
        subtype="PIXEL",
        update=settings_changed,
    )
    # Version 0.1.0 had it, so that its files and scripts set it.
    fast_seams: bpy.props.BoolProperty(
        name="Fast over Seams", description="Without effect", default=False, options={"HIDDEN"}
    )
    full_render: bpy.props.BoolProperty(
        name="Full Quality in Renders",
        description="Render with the settings of Quality and Method instead of these",
        default=True,
    )
    wait: bpy.props.BoolProperty(
        name="Wait for Values",
        description="Wait for each frame's values before drawing it. Otherwise values follow a moment later while you "
        "play, scrub or edit. Renders always wait",
        default=True,
    )
    missing: bpy.props.EnumProperty(
        name="Missing Frames",
        description="Values at frames that the cache lacks",
        items=MISSING,
        default="HOLD",
        update=settings_changed,
    )
    ranges: bpy.props.CollectionProperty(
        name="Ranges", description="Range of values that the colors span", type=PARADESC_PG_live_range
    )
    ranges_look: bpy.props.StringProperty(
        name="Range Settings", description="The settings of Colors that the ranges follow from", options={"HIDDEN"}
    )
    lock_taken: bpy.props.BoolProperty(
        name="Interface Locked", description="Live mode has switched on Render > Lock Interface", options={"HIDDEN"}
    )


class PARADESC_PG_live_object(bpy.types.PropertyGroup):
    """Live mode of one object."""

    mode: bpy.props.EnumProperty(
        name="Update",
        description="Source of the object's values at every frame",
        items=MODES,
        default="OFF",
        update=mode_changed,
        override=OVERRIDABLE,
    )
    follows: bpy.props.BoolProperty(
        name="Live",
        description="Values follow the animation, edits and renders: the mode Live, as one switch",
        get=lambda group: group.mode == "LIVE",
        set=lambda group, wanted: setattr(group, "mode", "LIVE" if wanted else "OFF"),
        override=OVERRIDABLE,
    )
    sentence: bpy.props.StringProperty(name="Message", description="Reason why live values were switched off")


classes = (PARADESC_PG_live_range, PARADESC_PG_live, PARADESC_PG_live_object)
GROUPS = {
    (bpy.types.Scene, "paradesc_live"): PARADESC_PG_live,
    (bpy.types.Object, "paradesc_live"): PARADESC_PG_live_object,
}
