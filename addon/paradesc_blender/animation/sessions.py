"""Keeps the state of live objects between events, and updates their values. Nothing here ever raises.

The frames of a render and the edits in a window may come from two threads, of which one at a time writes.
"""

import logging
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import bpy

from paradesc.bridge import ParadescError
from paradesc.core import contexts

from ..scene import writing
from ..settings import looks
from ..settings.snapshot import identity
from . import live, painting, pausing, playback, surfaces

# Seconds between two checks of the computation on a thread.
COLLECT_STEP = 0.01
# Seconds until the next look where something else goes first.
LATER = 0.2
KINDS = {"LIVE": live.Session, "CACHE": playback.Player}
LOG = logging.getLogger("paradesc")
Place = tuple[bpy.types.Scene, bpy.types.ViewLayer]


class State:
    """The state that lasts between two events. It is cleared when a file is loaded."""

    def __init__(self) -> None:
        self.sessions: dict[object, live.Session | playback.Player] = {}  # by the object's identity
        self.listed: list[tuple[str, object]] = []  # names and identities of live objects
        self.object_count = -1  # in the file, when they were listed
        self.edited_at: float | None = None
        self.render_time: float | None = None  # the frame that is being rendered, with its subframe
        self.rendering = False
        self.turn = threading.Lock()  # held by the one thread that writes
        self.owner = 0


STATE = State()


def forget_all() -> None:
    """Frees every session, and the devices that are no longer used."""
    for session in STATE.sessions.values():
        session.close()
    STATE.sessions.clear()
    STATE.object_count = -1
    contexts.close_idle()


def live_objects() -> list[bpy.types.Object]:
    """The objects with live values switched on; listed again when objects were added, removed or renamed.

    If objects share a mesh, such as linked duplicates, only the first counts, because the mesh can hold the values of
    one object.
    """
    objects = bpy.data.objects
    found = [objects.get((name, None)) for name, _ in STATE.listed]
    same = all(
        item is not None and identity(item) == known and is_live(item)
        for item, (_, known) in zip(found, STATE.listed, strict=True)
    )
    if len(objects) != STATE.object_count or not same:
        found = [item for item in objects if is_live(item)]
        STATE.listed, STATE.object_count = [(item.name, identity(item)) for item in found], len(objects)
    first: dict[bpy.types.Mesh, bpy.types.Object] = {}
    for item in found:
        first.setdefault(item.data, item)
    for known in set(STATE.sessions) - {identity(item) for item in first.values()}:
        STATE.sessions.pop(known).close()
    return list(first.values())


def holder_of(target: bpy.types.Object) -> bpy.types.Object | None:
    """Another live object with the same mesh. The mesh can hold the values of only one of them."""
    return next((item for item in live_objects() if item.data == target.data and item != target), None)


def is_live(target: bpy.types.Object) -> bool:
    """Returns whether live values are on for an object. It must be local, as a linked one could not keep them.

    Reading the settings of an object would store them there, so objects without stored settings are not asked.
    """
    stored = target.type == "MESH" and target.library is None and target.is_property_set("paradesc_live")
    return stored and target.paradesc_live.mode != "OFF"


# ---- Values


@contextmanager
def our_turn(wait: bool) -> Iterator[bool]:
    """Yields True to one thread at a time, and False to events that are caused by this thread's own writing."""
    if is_ours() or not STATE.turn.acquire(blocking=wait):
        yield False
        return
    STATE.owner = threading.get_ident()
    try:
        yield True
    finally:
        STATE.owner = 0
        STATE.turn.release()


def is_ours() -> bool:
    """Returns whether this thread is the one that writes."""
    return STATE.owner == threading.get_ident()


def refresh(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, targets: list[bpy.types.Object], watched: bool = False
) -> None:
    """Brings the values of these objects up to date. Renders wait for their turn, other events give up.

    watched: a window shows the objects, so their values may follow a moment later unless the scene waits for them.
    """
    wait = not watched or waits(scene, depsgraph)
    with our_turn(wait=depsgraph.mode == "RENDER") as ours:
        for target in targets if ours else ():
            with switching_off(target):
                writing.insist(partial(session_of(target).refresh, target, depsgraph, scene, wait))
    if not wait and any(session.busy for session in STATE.sessions.values()):
        start_timer(collect, COLLECT_STEP)


def waits(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> bool:
    """Returns whether the event has to wait for values: in background mode, in renders, or if the scene says so."""
    return bpy.app.background or depsgraph.mode == "RENDER" or STATE.rendering or scene.paradesc_live.wait


def is_watched() -> bool:
    """Returns whether an animation is playing or the current frame is being dragged."""
    screens = [window.screen for window in bpy.context.window_manager.windows]
    return any(screen.is_animation_playing or screen.is_scrubbing for screen in screens)


@contextmanager
def switching_off(target: bpy.types.Object) -> Iterator[None]:
    """Ends an object's live values if the body raises an error; an object that was deleted is forgotten.

    The error is reported in the panel and in a farm's log.
    """
    try:
        yield
    except ParadescError as error:
        switch_off(target, error.sentence)
    except ReferenceError:
        STATE.object_count = -1
    except Exception as error:  # noqa: BLE001 (whatever it is, an exception would stop nothing but the sentence)
        switch_off(target, f"Live values stopped: {type(error).__name__}: {error}")


@writing.allowed
def collect(wait: bool = False) -> float | None:
    """A timer that shows what a thread has computed; returns the seconds until its next call, or None."""
    if STATE.rendering:
        return LATER
    sculpting = not wait and any(target.mode == "SCULPT" for target in live_objects())
    # Looking at buttons is an operator with an overridden context, during which no other thread may run Python.
    if sculpting and (any(session.computing for session in STATE.sessions.values()) or pausing.is_busy()):
        return COLLECT_STEP
    with our_turn(wait=False) as ours:
        for target in live_objects() if ours else ():
            session = session_at(target)
            if session is not None and session.busy:
                with switching_off(target):
                    session.collect(target, wait)
    return COLLECT_STEP if any(session.busy for session in STATE.sessions.values()) else None


def start_timer(function: Callable[[], float | None], seconds: float) -> None:
    """Has Blender call this timer, unless it does so already."""
    if not bpy.app.background and not bpy.app.timers.is_registered(function):
        bpy.app.timers.register(function, first_interval=seconds)


def session_at(target: bpy.types.Object) -> live.Session | playback.Player | None:
    """The session that the object has so far, if any."""
    return STATE.sessions.get(identity(target))


def session_of(target: bpy.types.Object) -> live.Session | playback.Player:
    """The session of the object, another one if its mode has changed."""
    wanted, found = KINDS[target.paradesc_live.mode], session_at(target)
    if not isinstance(found, wanted):
        if found is not None:
            found.close()
        found = STATE.sessions[identity(target)] = wanted()
    return found


def switch_off(target: bpy.types.Object, sentence: str) -> None:
    """Ends the live values of an object and says why; does nothing if the object is gone."""
    try:
        LOG.error('%s: live values of "%s" are switched off. %s', "Paradesc", target.name, sentence)
        target.paradesc_live.mode = "OFF"
        target.paradesc_live.sentence = sentence
    except ReferenceError:
        STATE.object_count = -1


def refresh_window(targets: list[bpy.types.Object], watched: bool = False) -> None:
    """Brings objects up to date in the windows' scenes, or without a window in the current view layer."""
    if is_ours() or STATE.rendering:
        return
    windows = bpy.context.window_manager.windows
    shown = [(window.scene, window.view_layer) for window in windows] or [(bpy.context.scene, bpy.context.view_layer)]
    for _, layer in shown:
        layer.update()
    places = [place_of(target, shown) for target in targets]
    for place in dict.fromkeys(places):
        if place is not None:
            scene, layer = place
            layer.update()
            refresh(scene, layer.depsgraph, [t for t, p in zip(targets, places, strict=True) if p == place], watched)


def place_of(target: bpy.types.Object, shown: list[Place]) -> Place | None:
    """The shown scene whose values the mesh has, which is the one whose frame changed last; a mesh holds one set."""
    session = session_at(target)
    known = "" if session is None else session.scene_name
    there = [place for place in shown if surfaces.evaluated_object(target, place[1].depsgraph) is not None]
    return min(there, key=lambda place: place[0].name != known, default=None)


def take_ranges(scene: bpy.types.Scene) -> None:
    """Makes the colors of all live objects span their present values, and those of played objects all frames."""
    forget_ranges()
    refresh_window(live_objects())
    look = looks.scene_look(scene)
    with our_turn(wait=True):
        found = [session_at(target).found_ranges(look) for target in live_objects() if session_at(target)]
        painting.take_ranges(scene.paradesc_live, found)
    refresh_window(live_objects())


def forget_ranges() -> None:
    """Makes the ranges of caches be read again when they are needed next."""
    for session in STATE.sessions.values():
        session.forget_ranges()


def look_changed(scene: bpy.types.Scene, _setting: str = "") -> None:
    """Applies changed color settings to live objects at once."""
    if not live_objects():
        return
    if painting.keeps_ranges(scene.paradesc_live, looks.scene_look(scene)):
        refresh_window(live_objects())
    else:
        take_ranges(scene)
