"""Takes carriers out of the scene when Blender appends or pastes objects whose modifiers carry values.

Blender puts every object that comes along into the scene, and the carrier would be seen there. A carrier that somebody
puts into a collection by hand stays there, because only those are taken out that the file did not have before.
"""

import bpy
from bpy.app.handlers import persistent

from . import carrying, writing


class State:
    """The contents of the file at the last look. Undo may bring carriers back that were taken out."""

    def __init__(self) -> None:
        self.count = -1  # of all objects
        self.known: set[str] | None = None  # the names of carriers; None before the first look
        self.taken: set[str] = set()  # the names of those that were taken out


STATE = State()


@writing.allowed
def look() -> None:
    """Takes carriers that are new out of all collections. A timer, which ends at once."""
    local = (item for item in bpy.data.objects if item.library is None)
    there = {item.name: item for item in local if carrying.is_carrier(item)}
    known = there.keys() if STATE.known is None else STATE.known
    for name in there.keys() - known:
        for collection in [one for one in there[name].users_collection if one.library is None]:
            collection.objects.unlink(there[name])
            STATE.taken.add(name)
    STATE.known, STATE.count = set(there), len(bpy.data.objects)


@persistent
def on_update(*_ignored: object) -> None:
    """Looks soon if objects were added or removed. Blender may still be using the scene's objects here."""
    if len(bpy.data.objects) == STATE.count:
        return
    if bpy.app.background:  # no timer runs there
        look()
    elif not bpy.app.timers.is_registered(look):
        bpy.app.timers.register(look, first_interval=0.0)


@persistent
def on_undo(*_ignored: object) -> None:
    """Takes out again what undo has brought back."""
    if STATE.taken:
        STATE.known = (STATE.known or set()) - STATE.taken
        STATE.count = -1
        on_update()


@persistent
def on_load(*_ignored: object) -> None:
    """Notes what another file has."""
    STATE.known, STATE.taken = None, set()
    look()


HANDLERS = {"depsgraph_update_post": on_update, "undo_post": on_undo, "redo_post": on_undo, "load_post": on_load}
classes = ()


def register() -> None:
    """Forgets what was known before the add-on was disabled."""
    STATE.count, STATE.known, STATE.taken = -1, None, set()


def unregister() -> None:
    """Ends the timer."""
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
