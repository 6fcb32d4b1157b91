"""Cleans up before Python exits, as Blender's Python module would crash if properties with callbacks remained."""

import atexit
import gc

import bpy


def clear_at_end(classes: list[type]) -> None:
    """Makes the properties of these classes be cleared when Python exits."""
    atexit.unregister(clear)
    atexit.register(clear, classes)


def clear(classes: list[type]) -> None:
    """Removes the properties from classes that are no longer registered, unless this is the Blender executable."""
    if bpy.app.binary_path:
        return
    for cls in classes:
        getattr(cls, "__annotations__", {}).clear()
    gc.collect()
