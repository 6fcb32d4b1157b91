"""Has timers and renders write although Blender has lost track of whether Python may.

Blender before 5.0 keeps that in one variable for all threads, which is off while a panel is drawn. If an engine begins
to render at that moment, the variable stays off for the timers of all add-ons. A panel that is drawn while the handler
of a rendered frame runs switches it off there.
"""

import functools
import threading
import time
from collections.abc import Callable
from typing import TypeVar

import bpy

Result = TypeVar("Result")
# A panel is drawn in some hundredths of a second.
TRIES, STEP = 200, 0.005
REFUSAL = "in this context is not allowed"
_asked: list[Callable[[], None]] = []


def allowed(timer: Callable[..., Result]) -> Callable[..., Result]:
    """Makes a timer run where it may write."""

    @functools.wraps(timer)
    def wrapped(*words: object, **named: object) -> Result:
        return insist(functools.partial(timer, *words, **named))

    return wrapped


def insist(function: Callable[[], Result]) -> Result:
    """Calls a function where it may write, and once more if that is taken from it meanwhile."""
    for _ in range(TRIES):
        try:
            if is_allowed():
                return function()
        except AttributeError as error:
            if REFUSAL not in str(error):
                raise
        if threading.current_thread() is threading.main_thread():
            break  # which draws panels itself, so that none will end
        time.sleep(STEP)
    return by_property(function)


def is_allowed() -> bool:
    """Returns whether Python may write now. This tries to set a property that is read-only, so nothing ever changes."""
    try:
        bpy.data.scenes[0].users = 0
    except AttributeError as error:
        return REFUSAL not in str(error)
    return True


def by_property(function: Callable[[], Result]) -> Result:
    """Calls a function where a property is set, for which Blender always lets Python write."""
    results: list[Result] = []
    errors: list[Exception] = []

    def asked() -> None:
        try:
            results.append(function())
        except Exception as error:  # noqa: BLE001 (raised below, because Blender would print it and go on)
            errors.append(error)

    _asked.append(asked)
    bpy.data.window_managers[0].paradesc_asked = True
    for error in errors:
        raise error
    return results[0]


def answer(_manager: bpy.types.WindowManager, _value: bool) -> None:
    """Calls what was asked for, and stores nothing."""
    _asked.pop()()


classes = ()


def register() -> None:
    """Adds the property that calls functions instead of being set."""
    bpy.types.WindowManager.paradesc_asked = bpy.props.BoolProperty(name="", get=lambda _manager: False, set=answer)


def unregister() -> None:
    """Removes the property."""
    del bpy.types.WindowManager.paradesc_asked
