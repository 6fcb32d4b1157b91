"""The sidebar's panel about values that follow the animation: live, or played from the cache."""

import bpy

from ..animation import handlers, live, sessions, surfaces
from ..scene import targets
from ..settings import looks
from ..settings.translation import label
from .drawing import SettingsPanel, choice, descriptor_words, sentence_lines, setting


class PARADESC_PT_live(SettingsPanel, bpy.types.Panel):
    """Values that follow the animation"""

    bl_label = "Live and Playback"
    bl_idname = "PARADESC_PT_live"
    bl_order = 41

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Shows only for meshes."""
        return targets.first(context) is not None

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, _settings: object) -> None:
        """Draws the switch, its sentence, settings, ranges and time."""
        target, group = targets.first(context), context.scene.paradesc_live
        mode = target.paradesc_live.mode
        switch = layout.row(align=True)
        switch.use_property_split = False
        for item in target.paradesc_live.bl_rna.properties["mode"].enum_items:
            choice(switch, target.paradesc_live, "mode", item.identifier)
        sentence = live_sentence(target)
        if sentence:
            sentence_lines(context, layout, sentence, "ERROR" if target.paradesc_live.sentence else "INFO")
        if mode == "CACHE":
            setting(layout, group, "missing")
        if mode != "CACHE" or group.missing == "COMPUTE":
            for name in ("samples", "buffer_size", "full_render"):
                setting(layout, group, name)
        if mode != "CACHE":
            setting(layout, group, "wait")
        if mode != "OFF":
            draw_ranges(context, layout)
            draw_time(context, layout, target)
            draw_lock(context, layout, context.scene)


def live_sentence(target: bpy.types.Object) -> str:
    """The panel's message about this object, or ""."""
    if target.paradesc_live.sentence:
        return target.paradesc_live.sentence
    if target.paradesc_live.mode != "OFF":
        waiting, other = surfaces.waiting_sentence(target), sessions.holder_of(target)
        if waiting or other is not None:
            return waiting or handlers.shared_sentence(other)
        session, simulation = sessions.session_at(target), live.unbaked_simulation(target)
        if session is not None and session.note:
            return session.note
        if simulation:
            return f'Bake the simulation "{simulation}" first; until then live values may change how it moves.'
    if target.library is not None or target.data.library is not None:
        return f'The mesh "{target.data.name}" is linked from another file; make it local first.'
    return ""


def draw_ranges(context: bpy.types.Context, layout: bpy.types.UILayout) -> None:
    """Draws the ranges of the colors."""
    group, look = context.scene.paradesc_live, looks.scene_look(context.scene)
    column = layout.column(align=True)
    sentence_lines(context, column, "Colors at every frame:")
    if look.ranges:
        low, high = look.ranges[""]
        column.label(text=label("{low} to {high} (fixed)").format(low=f"{low:g}", high=f"{high:g}"), translate=False)
        return
    for item in group.ranges:
        sentence_lines(context, column, descriptor_words(item.name))
        row = column.row(align=True)
        row.prop(item, "minimum", text="")
        row.prop(item, "maximum", text="")
    column.operator("paradesc.live_range")


def draw_time(context: bpy.types.Context, layout: bpy.types.UILayout, target: bpy.types.Object) -> None:
    """Draws the time that the last frame took."""
    session = sessions.session_at(target)
    if session is None or not session.seconds:
        return
    total, computing = sum(session.seconds.values()), session.seconds.get("compute", 0.0)
    column = layout.column(align=True)
    for text, seconds in (("Last frame: {time}", total), ("– computing: {time}", computing)):
        sentence_lines(context, column, label(text).format(time=f"{1e3 * seconds:.0f} ms"))


def draw_lock(context: bpy.types.Context, layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    """Draws a warning if somebody has switched off Lock Interface."""
    if not scene.render.use_lock_interface:
        column = layout.column(align=True)
        sentence_lines(context, column, "Rendering in a window needs:", "ERROR")
        column.use_property_split = False
        column.prop(scene.render, "use_lock_interface")


classes = (PARADESC_PT_live,)
