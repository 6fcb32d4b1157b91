"""Blender's events to live values: frames, edits, renders, undo and files. No handler ever raises.

A frame's handler runs after modifiers were evaluated; where it writes, Blender evaluates once more, so what it leaves
is what is drawn and rendered. In a window, renders call it from a thread of their own, for which the interface has to
be locked.
"""

import logging
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.app.handlers import persistent

from . import live, playback
from .bridge import ParadescError

# Seconds without another edit after which live values follow.
EDIT_DELAY = 0.2
KINDS = {"LIVE": live.Session, "CACHE": playback.Player}
LOG = logging.getLogger("paradesc")


class State:
    """What lasts between two events. Cleared when a file is loaded."""

    def __init__(self) -> None:
        self.sessions: dict[str, live.Session | playback.Player] = {}  # by the object's name
        self.names: list[str] = []  # of live objects
        self.object_count = -1  # in the file, when names were listed
        self.edited_at: float | None = None
        self.render_time: float | None = None  # the frame that is being rendered, with its subframe
        self.rendering = False
        self.turn = threading.Lock()  # held by the one thread that writes
        self.owner = 0


STATE = State()


def forget_all() -> None:
    """Frees every session."""
    for session in STATE.sessions.values():
        session.close()
    STATE.sessions.clear()
    STATE.object_count = -1


def live_objects() -> list[bpy.types.Object]:
    """The objects that have live values switched on; listed afresh when objects came, went or were renamed."""
    objects = bpy.data.objects
    found = [objects.get(name) for name in STATE.names]
    if len(objects) != STATE.object_count or not all(item and is_live(item) for item in found):
        found = [item for item in objects if is_live(item)]
        STATE.names, STATE.object_count = [item.name for item in found], len(objects)
        for name in set(STATE.sessions) - set(STATE.names):
            STATE.sessions.pop(name).close()
    return found


def is_live(target: bpy.types.Object) -> bool:
    """Local meshes that are switched on; linked ones could not keep what is written."""
    return target.type == "MESH" and target.library is None and target.paradesc_live.mode != "OFF"


# ---- Values


@contextmanager
def our_turn(wait: bool) -> Iterator[bool]:
    """Gives True to one thread at a time, and False to what it calls itself by what it writes."""
    me = threading.get_ident()
    if STATE.owner == me or not STATE.turn.acquire(blocking=wait):
        yield False
        return
    STATE.owner = me
    try:
        yield True
    finally:
        STATE.owner = 0
        STATE.turn.release()


def refresh(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, targets: list[bpy.types.Object]) -> None:
    """Brings the values of these objects up to date. Renders wait for their turn, other events do without."""
    with our_turn(wait=depsgraph.mode == "RENDER") as ours:
        for target in targets if ours else ():
            refresh_one(scene, depsgraph, target)


def refresh_one(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, target: bpy.types.Object) -> None:
    """One object; what goes wrong switches it off and is said in the panel, and in a farm's log."""
    try:
        session_of(target).refresh(target, depsgraph, scene)
    except ParadescError as error:
        switch_off(target, error.sentence)
    except Exception as error:  # noqa: BLE001 (whatever it is, an exception would stop nothing but the sentence)
        switch_off(target, f"Live values stopped: {type(error).__name__}: {error}")


def session_of(target: bpy.types.Object) -> live.Session | playback.Player:
    """What the object keeps, by its mode."""
    wanted = KINDS[target.paradesc_live.mode]
    found = STATE.sessions.get(target.name)
    if not isinstance(found, wanted):
        if found is not None:
            found.close()
        found = STATE.sessions[target.name] = wanted()
    return found


def switch_off(target: bpy.types.Object, sentence: str) -> None:
    """Ends the live values of an object and says why."""
    LOG.error('%s: live values of "%s" are switched off. %s', "Paradesc", target.name, sentence)
    target.paradesc_live.mode = "OFF"
    target.paradesc_live.sentence = sentence


def refresh_window(targets: list[bpy.types.Object]) -> None:
    """Brings objects up to date in what the windows show, or, without one, in the current view layer."""
    if STATE.owner == threading.get_ident() or STATE.rendering:
        return
    windows = bpy.context.window_manager.windows
    shown = [(window.scene, window.view_layer) for window in windows] or [(bpy.context.scene, bpy.context.view_layer)]
    for scene, layer in shown:
        layer.update()
        refresh(scene, layer.depsgraph, targets)


# ---- Switching


def mode_changed(target: bpy.types.Object) -> None:
    """Live values of an object were switched on or off."""
    STATE.object_count = -1
    targets = live_objects()
    for scene in target.users_scene:
        lock_interface(scene, any(item in targets for item in scene.objects if item.type == "MESH"))
    if target not in targets:
        return
    target.paradesc_live.sentence = ""
    other = next((item for item in targets if item.data == target.data and item != target), None)
    if other is not None:
        switch_off(target, f'It shares its mesh with "{other.name}", which has live values: make it a single user.')
        return
    refresh_window([target])


def lock_interface(scene: bpy.types.Scene, needed: bool) -> None:
    """Locks the interface during renders while it is needed, and gives back what was set before."""
    group = scene.paradesc_live
    if needed and not scene.render.use_lock_interface:
        scene.render.use_lock_interface = group.lock_taken = True
    elif not needed and group.lock_taken:
        scene.render.use_lock_interface = group.lock_taken = False


# ---- Blender's events


@persistent
def on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Another frame was evaluated. Between the frames of a render, motion blur asks for shapes only."""
    targets = live_objects()
    if not targets or depsgraph is None:
        return
    between = STATE.render_time is not None and scene.frame_current_final != STATE.render_time
    if depsgraph.mode == "RENDER" and between:
        return
    refresh(scene, depsgraph, targets)


@persistent
def on_edit(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Something was edited: if it was the shape of a live object, its values follow when the hand rests."""
    targets = live_objects()
    if not targets or depsgraph is None or STATE.owner == threading.get_ident():
        return
    hit = list(edited_objects(targets, depsgraph))
    if not hit:
        return
    for target in hit:
        if target.name in STATE.sessions:
            STATE.sessions[target.name].edited = True
    STATE.edited_at = time.monotonic()
    if not bpy.app.background and not bpy.app.timers.is_registered(follow_edits):
        bpy.app.timers.register(follow_edits, first_interval=EDIT_DELAY)


def edited_objects(targets: list[bpy.types.Object], depsgraph: bpy.types.Depsgraph) -> Iterator[bpy.types.Object]:
    """Those of the objects whose shape the depsgraph evaluated again."""
    changed = {update.id.original for update in depsgraph.updates if update.is_updated_geometry}
    for target in targets:
        if target in changed or target.data in changed:
            yield target


def follow_edits() -> float | None:
    """A timer: seconds until the next look, or None when values have followed."""
    if STATE.edited_at is None:
        return None
    left = STATE.edited_at + EDIT_DELAY - time.monotonic()
    if left > 0:
        return left
    if STATE.rendering or any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows):
        return EDIT_DELAY
    STATE.edited_at = None
    refresh_window(live_objects())
    return None


@persistent
def on_render_start(scene: bpy.types.Scene, _depsgraph: object = None) -> None:
    """A render begins: from here on the windows' events wait."""
    STATE.rendering = True
    if any(item in live_objects() for item in scene.objects if item.type == "MESH"):
        lock_interface(scene, needed=True)


@persistent
def on_render_frame(scene: bpy.types.Scene, _depsgraph: object = None) -> None:
    """A frame of a render begins."""
    STATE.render_time = scene.frame_current_final


@persistent
def on_render_end(_scene: bpy.types.Scene, _depsgraph: object = None) -> None:
    """A render ended, or was cancelled."""
    STATE.rendering, STATE.render_time = False, None


@persistent
def on_load_start(*_ignored: object) -> None:
    """Another file takes this one's place."""
    forget_all()
    STATE.edited_at, STATE.render_time, STATE.rendering = None, None, False


@persistent
def on_undo(*_ignored: object) -> None:
    """Names, topology and values may be others now."""
    STATE.object_count = -1
    for session in STATE.sessions.values():
        session.edited = True


HANDLERS = {
    "frame_change_post": on_frame,
    "depsgraph_update_post": on_edit,
    "render_init": on_render_start,
    "render_pre": on_render_frame,
    "render_complete": on_render_end,
    "render_cancel": on_render_end,
    "load_pre": on_load_start,
    "undo_post": on_undo,
    "redo_post": on_undo,
}

classes = ()


def register() -> None:
    """Hangs the handlers in, once each."""
    for name, function in HANDLERS.items():
        hooks = getattr(bpy.app.handlers, name)
        for hook in [hook for hook in hooks if is_same(hook, function)]:
            hooks.remove(hook)
        hooks.append(function)


def unregister() -> None:
    """Takes them out, and frees what they kept."""
    for name, function in HANDLERS.items():
        hooks = getattr(bpy.app.handlers, name)
        if function in hooks:
            hooks.remove(function)
    if bpy.app.timers.is_registered(follow_edits):
        bpy.app.timers.unregister(follow_edits)
    forget_all()


def is_same(hook: object, function: object) -> bool:
    """The same handler, also of an earlier import of the add-on."""
    return (getattr(hook, "__module__", ""), getattr(hook, "__name__", "")) == (function.__module__, function.__name__)
