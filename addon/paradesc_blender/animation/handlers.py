"""Updates live values at Blender's events: frames, edits, renders, undo and files. No handler ever raises.

The handler of a frame runs after modifiers were evaluated. If it writes, Blender evaluates once more, so the new values
are drawn and rendered. With a window, renders call it from a thread of their own, for which the interface has to be
locked.
"""

import time

import bpy
from bpy.app.handlers import persistent

from ..bake.modal import ModalJob
from ..scene import record, viewports, writing
from ..settings import looks
from . import live, painting, pausing, sessions, unkeyed
from .sessions import STATE

# Seconds without another edit after which live values follow, and after a stroke in sculpt mode, whose end is seen.
EDIT_DELAY, STROKE_DELAY = 0.2, 0.02


# ---- Switching


def mode_changed(target: bpy.types.Object) -> None:
    """Reacts to live values of an object being switched on or off."""
    other = sessions.holder_of(target)  # before this one counts
    STATE.object_count = -1
    if other is not None and sessions.is_live(target):
        sessions.switch_off(target, shared_sentence(other))
        return
    targets = sessions.live_objects()
    for scene in target.users_scene:
        lock_interface(scene, any(item in targets for item in scene.objects if item.type == "MESH"))
    if target not in targets:
        return
    target.paradesc_live.sentence = ""
    record.forget(target.data, live.RADII)
    sessions.refresh_window([target])
    session = sessions.session_at(target)
    if session is not None and target.paradesc_live.mode != "OFF":
        session.reveal(target)
        viewports.reveal(bpy.context)


def shared_sentence(other: bpy.types.Object) -> str:
    """One sentence about why an object has no live values of its own."""
    return f'It shares its mesh with "{other.name}", which has live values: make it a single user.'


def lock_interface(scene: bpy.types.Scene, needed: bool) -> None:
    """Locks the interface during renders while live values need it, and restores the user's setting afterwards."""
    group = scene.paradesc_live
    if needed and not scene.render.use_lock_interface:
        scene.render.use_lock_interface = group.lock_taken = True
    elif not needed and group.lock_taken:
        scene.render.use_lock_interface = group.lock_taken = False


# ---- Blender's events


@persistent
def on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Follows another frame. Between the frames of a render, motion blur needs shapes only, so nothing is done."""
    targets = sessions.live_objects()
    if depsgraph is not None and painting.is_of_view_layer(depsgraph):
        unkeyed.forget()  # Blender has animated this frame itself
    if not targets or depsgraph is None or (pausing.is_held() and depsgraph.mode != "RENDER"):
        return
    between = STATE.render_time is not None and scene.frame_current_final != STATE.render_time
    if depsgraph.mode == "RENDER" and between:
        return
    sessions.refresh(scene, depsgraph, targets, depsgraph.mode != "RENDER" and sessions.is_watched())


@persistent
def on_edit(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Follows an edit: if it changed the shape of a live object, its values follow once editing pauses."""
    targets = sessions.live_objects()
    if depsgraph is not None and painting.is_of_view_layer(depsgraph) and not STATE.rendering:
        unkeyed.restore()
    if not targets and scene.paradesc_live.lock_taken and not STATE.rendering:
        lock_interface(scene, needed=False)  # the last one was deleted
    if not targets or depsgraph is None or sessions.is_ours():
        return
    touched = {update.id.original for update in depsgraph.updates}
    changed = {update.id.original for update in depsgraph.updates if update.is_updated_geometry}
    # Strokes of sculpt mode only tag the object as updated.
    hit = [item for item in targets if {item, item.data} & (touched if item.mode == "SCULPT" else changed)]
    if not hit and not settings_changed(targets, scene, depsgraph):
        return
    for target in hit:
        session = sessions.session_at(target)
        if session is None or target.mode == "SCULPT":  # strokes move vertices, and change nothing else
            continue
        if session.wrote:  # most likely it is that; and if not, a comparison at rest will tell
            session.wrote, session.unsure = False, True
        else:
            session.edited = True
    STATE.edited_at = time.monotonic()
    sessions.start_timer(follow_edits, delay_of(targets))


def settings_changed(
    targets: list[bpy.types.Object], scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph
) -> bool:
    """Returns whether the scene's settings differ from those with which the values on the objects were computed."""
    if not any(update.id.original == scene for update in depsgraph.updates):
        return False
    asked = filter(None, map(sessions.session_at, targets))
    return any(session.scene_name == scene.name and not session.has_settings(scene) for session in asked)


def delay_of(targets: list[bpy.types.Object]) -> float:
    """Seconds to wait for another edit before values are updated."""
    return STROKE_DELAY if any(target.mode == "SCULPT" for target in targets) else EDIT_DELAY


@writing.allowed
def follow_edits() -> float | None:
    """A timer that returns the seconds until its next call, or None once all values are up to date."""
    if STATE.edited_at is None:
        return None
    delay = delay_of(sessions.live_objects())
    left = STATE.edited_at + delay - time.monotonic()
    if left > 0:
        return left
    playing = any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows)
    busy = any(session.busy for session in STATE.sessions.values())
    if STATE.rendering or playing or busy or ModalJob.running or pausing.is_held() or pausing.is_busy():
        return delay
    STATE.edited_at = None
    for session in STATE.sessions.values():
        session.edited = session.edited or session.unsure
    sessions.refresh_window(sessions.live_objects(), watched=True)
    return None


@persistent
def on_render_start(scene: bpy.types.Scene, _depsgraph: object = None) -> None:
    """Notes that a render begins: from now on the events of windows wait."""
    STATE.rendering = True
    if any(item in sessions.live_objects() for item in scene.objects if item.type == "MESH"):
        lock_interface(scene, needed=True)


@persistent
def on_render_frame(scene: bpy.types.Scene, _depsgraph: object = None) -> None:
    """Notes that a frame of a render begins."""
    STATE.render_time = scene.frame_current_final


@persistent
def on_render_end(_scene: bpy.types.Scene, _depsgraph: object = None) -> None:
    """Notes that a render ended or was cancelled."""
    STATE.rendering, STATE.render_time = False, None


@persistent
def on_load_start(*_ignored: object) -> None:
    """Forgets everything, because another file is being loaded."""
    sessions.forget_all()
    unkeyed.forget()
    STATE.edited_at, STATE.render_time, STATE.rendering = None, None, False


@persistent
def on_save(*_ignored: object) -> None:
    """Makes sure that the file is saved with the values of its frame."""
    for _ in range(3):  # for the request under way, for the one that waits, and to see that none is left
        if not any(session.busy for session in STATE.sessions.values()):
            break
        sessions.collect(wait=True)


@persistent
def on_undo(*_ignored: object) -> None:
    """Checks everything again, because names, topology and values may have changed."""
    unkeyed.forget()
    STATE.object_count = -1
    for session in STATE.sessions.values():
        session.edited = True
    if STATE.sessions:
        STATE.edited_at = time.monotonic()
        sessions.start_timer(follow_edits, EDIT_DELAY)


HANDLERS = {
    "frame_change_post": on_frame,
    "depsgraph_update_post": on_edit,
    "render_init": on_render_start,
    "render_pre": on_render_frame,
    "render_complete": on_render_end,
    "render_cancel": on_render_end,
    "load_pre": on_load_start,
    "save_pre": on_save,
    "undo_post": on_undo,
    "redo_post": on_undo,
}

classes = ()


def register() -> None:
    """Listens to color settings."""
    looks.listen(sessions.look_changed)


def unregister() -> None:
    """Frees all sessions."""
    looks.ignore(sessions.look_changed)
    for function in (follow_edits, sessions.collect):
        if bpy.app.timers.is_registered(function):
            bpy.app.timers.unregister(function)
    sessions.forget_all()
