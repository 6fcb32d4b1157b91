"""Settings and sub-panel of live mode and playback: what of them is kept in objects and in scenes."""

import bpy

from ..animation import handlers, live
from ..core import legend
from ..settings import looks
from .panel import SidebarPanel, line_length, sentence_lines, wrapped

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
    """Starts or ends it."""
    handlers.mode_changed(group.id_data)


def settings_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Brings all live objects up to date with the settings."""
    handlers.refresh_window(handlers.live_objects(), watched=True)


def range_changed(group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """The same where somebody has set a range, which then stays."""
    if not handlers.is_ours():
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
    typed: bpy.props.BoolProperty(name="Typed", description="Whether somebody has set this range", options={"HIDDEN"})


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
        name="Buffer Size",
        description="At most so many texels along a side of the baked buffers in the viewport",
        default=512,
        min=64,
        max=8192,
        subtype="PIXEL",
        update=settings_changed,
    )
    fast_seams: bpy.props.BoolProperty(
        name="Fast over Seams",
        description="Carry every sample over seams by itself in the viewport, less exactly than to take what is "
        "connected. Faster where the surface often lies close to itself, as fingers, folds and scales do",
        default=False,
        update=settings_changed,
    )
    full_render: bpy.props.BoolProperty(
        name="Full Quality in Renders",
        description="Render with the settings of Quality and Method instead of these",
        default=True,
    )
    wait: bpy.props.BoolProperty(
        name="Wait for Values",
        description="Show every frame with its own values, as slowly as they are computed. Without it, values follow "
        "a moment later while you play, drag the current frame or edit. Renders always wait",
        default=True,
    )
    missing: bpy.props.EnumProperty(
        name="Missing Frames",
        description="What is shown at frames that the cache lacks",
        items=MISSING,
        default="HOLD",
        update=settings_changed,
    )
    ranges: bpy.props.CollectionProperty(
        name="Ranges", description="What the colors of each descriptor span", type=PARADESC_PG_live_range
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
        description="Where the object's values come from at every frame",
        items=MODES,
        default="OFF",
        update=mode_changed,
    )
    sentence: bpy.props.StringProperty(name="Message", description="Why live values were switched off")


class PARADESC_OT_live_range(bpy.types.Operator):
    """Let the colors of all live objects span the values of this frame, those of played ones that of all frames"""

    bl_idname = "paradesc.live_range"
    bl_label = "Range of This Frame"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Says why it cannot run where it cannot."""
        sentence = "" if handlers.live_objects() else "Switch an object to Live first"
        if sentence:
            cls.poll_message_set(sentence)
        return not sentence

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Takes the ranges anew from what is there."""
        handlers.take_ranges(context.scene)
        return {"FINISHED"}


class PARADESC_PT_live(SidebarPanel, bpy.types.Panel):
    """Values that follow the animation"""

    bl_label = "Live and Playback"
    bl_idname = "PARADESC_PT_live"
    bl_order = 51
    bl_parent_id = "PARADESC_PT_bake"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Only for meshes."""
        return context.active_object is not None and context.active_object.type == "MESH"

    def draw(self, context: bpy.types.Context) -> None:
        """The switch, what was said, settings, ranges and time."""
        layout, target = self.layout, context.active_object
        icon = "ERROR" if target.paradesc_live.sentence else "INFO"
        layout.row().prop(target.paradesc_live, "mode", expand=True)
        sentence = live_sentence(target)
        if sentence:
            sentence_lines(context, layout, sentence, icon)
        group = context.scene.paradesc_live
        column = layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        mode = target.paradesc_live.mode
        if mode == "CACHE":
            column.prop(group, "missing")
        if mode != "CACHE" or group.missing == "COMPUTE":
            for name in ("samples", "buffer_size"):
                column.prop(group, name)
            for name in ("fast_seams", "full_render", *(("wait",) if mode != "CACHE" else ())):
                layout.prop(group, name)
        if target.paradesc_live.mode != "OFF":
            draw_ranges(context, layout)
            draw_time(layout, target)
            draw_lock(layout, context.scene)


def live_sentence(target: bpy.types.Object) -> str:
    """What the panel has to say about this object, or ""."""
    if target.paradesc_live.sentence:
        return target.paradesc_live.sentence
    if target.paradesc_live.mode != "OFF" and target.mode in live.WAITING_MODES:
        return "Values follow when this mode is left."
    other = handlers.holder_of(target) if target.paradesc_live.mode != "OFF" else None
    if other is not None:
        return handlers.shared_sentence(other)
    session = handlers.session_at(target)
    if target.paradesc_live.mode != "OFF" and session is not None and session.note:
        return session.note
    if target.library is not None or target.data.library is not None:
        return f'The mesh "{target.data.name}" is linked from another file; make it local first.'
    return ""


def draw_ranges(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """What the colors span."""
    group, look = context.scene.paradesc_live, looks.scene_look(context.scene)
    column = layout.column(align=True)
    column.label(text="Colors at every frame:")
    if look.ranges:
        low, high = look.ranges[""]
        column.label(text=f"{low:g} to {high:g} (fixed)")
        return
    for item in group.ranges:
        for line in wrapped(legend.label(item.name), line_length(context)):
            column.label(text=line)
        row = column.row(align=True)
        row.prop(item, "minimum", text="")
        row.prop(item, "maximum", text="")
    column.operator("paradesc.live_range")


def draw_time(layout: bpy.types.UILayout, target: bpy.types.Object) -> None:
    """What the last frame took."""
    session = handlers.session_at(target)
    if session is None or not session.seconds:
        return
    total, computing = sum(session.seconds.values()), session.seconds.get("compute", 0.0)
    column = layout.column(align=True)
    column.label(text=f"Last frame: {1e3 * total:.0f} ms")
    column.label(text=f"– computing: {1e3 * computing:.0f} ms")


def draw_lock(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    """Warns where the user has taken the lock away."""
    if not scene.render.use_lock_interface:
        column = layout.column(align=True)
        column.label(text="Rendering in a window needs:", icon="ERROR")
        column.prop(scene.render, "use_lock_interface")


classes = (
    PARADESC_PG_live_range,
    PARADESC_PG_live,
    PARADESC_PG_live_object,
    PARADESC_OT_live_range,
    PARADESC_PT_live,
)


def register() -> None:
    """Gives scenes and objects their settings."""
    bpy.types.Scene.paradesc_live = bpy.props.PointerProperty(type=PARADESC_PG_live)
    bpy.types.Object.paradesc_live = bpy.props.PointerProperty(type=PARADESC_PG_live_object)


def unregister() -> None:
    """Takes them away."""
    del bpy.types.Object.paradesc_live
    del bpy.types.Scene.paradesc_live
