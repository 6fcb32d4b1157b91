"""Adds functions to Blender's lists of handlers, each only once, however often the add-on is enabled."""

from collections.abc import Callable

import bpy

Handlers = dict[str, Callable[..., None]]


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
    """Whether a handler is this function, even from an earlier import."""
    return (getattr(hook, "__module__", ""), getattr(hook, "__name__", "")) == (function.__module__, function.__name__)
