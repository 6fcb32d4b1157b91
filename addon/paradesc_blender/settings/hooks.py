"""Adds to Blender what a module of ours declares, each only once, and takes it away again.

A module has a tuple of classes. It may have GROUPS, the groups of settings by the type and the member that get them;
HANDLERS, functions by Blender's list of handlers; and register() and unregister() for anything else.
"""

import atexit
import gc
from collections.abc import Callable
from types import ModuleType

import bpy

from .translation import in_our_context

Handlers = dict[str, Callable[..., None]]
# Characters are linked and overridden in studios, and their objects keep what is chosen for them.
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}


def add(module: ModuleType) -> None:
    """Adds what a module declares."""
    for cls in module.classes:
        bpy.utils.register_class(in_our_context(cls))
    for (owner, name), group in getattr(module, "GROUPS", {}).items():
        override = OVERRIDABLE if owner is bpy.types.Object else set()
        setattr(owner, name, bpy.props.PointerProperty(type=group, override=override))
    hang(getattr(module, "HANDLERS", {}))
    if hasattr(module, "register"):
        module.register()


def remove(module: ModuleType) -> None:
    """Undoes add(), in reverse order."""
    if hasattr(module, "unregister"):
        module.unregister()
    take_down(getattr(module, "HANDLERS", {}))
    for owner, name in reversed(getattr(module, "GROUPS", {})):
        delattr(owner, name)
    for cls in reversed(module.classes):
        bpy.utils.unregister_class(cls)


def hang(handlers: Handlers) -> None:
    """Adds each function to the list of its name, in place of the same one from an earlier import of the add-on."""
    for name, function in handlers.items():
        hooks = getattr(bpy.app.handlers, name)
        for hook in [hook for hook in hooks if is_same(hook, function)]:
            hooks.remove(hook)
        hooks.append(function)


def take_down(handlers: Handlers) -> None:
    """Removes the functions from their lists."""
    for name, function in handlers.items():
        hooks = getattr(bpy.app.handlers, name)
        if function in hooks:
            hooks.remove(function)


def is_same(hook: object, function: object) -> bool:
    """Returns whether a handler is this function, even from an earlier import."""
    return (getattr(hook, "__module__", ""), getattr(hook, "__name__", "")) == (function.__module__, function.__name__)


def clear_at_end(classes: list[type]) -> None:
    """Makes the properties of these classes be cleared when Python exits."""
    atexit.unregister(clear)
    atexit.register(clear, classes)


def clear(classes: list[type]) -> None:
    """Clears the properties of unregistered classes: bpy would crash at exit if properties with callbacks remained."""
    if bpy.app.binary_path:
        return
    for cls in classes:
        getattr(cls, "__annotations__", {}).clear()
    gc.collect()
