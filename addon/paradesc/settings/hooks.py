"""Hangs functions into Blender's lists of handlers, each once, however often the add-on is enabled."""

from collections.abc import Callable

import bpy

Handlers = dict[str, Callable[..., None]]


def hang(handlers: Handlers) -> None:
    """Adds each function to the list of that name; one from an earlier import of the add-on makes room."""
    for name, function in handlers.items():
        hooks = getattr(bpy.app.handlers, name)
        for hook in [hook for hook in hooks if is_same(hook, function)]:
            hooks.remove(hook)
        hooks.append(function)


def take_down(handlers: Handlers) -> None:
    """Removes the functions."""
    for name, function in handlers.items():
        hooks = getattr(bpy.app.handlers, name)
        if function in hooks:
            hooks.remove(function)


def is_same(hook: object, function: object) -> bool:
    """Whether this is that function, even from an earlier import."""
    return (getattr(hook, "__module__", ""), getattr(hook, "__name__", "")) == (function.__module__, function.__name__)
