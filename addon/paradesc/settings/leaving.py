"""What Blender's Python module needs before Python ends: it crashes where properties with callbacks are still there."""

import atexit
import gc

import bpy


def clear_at_end(classes: list[type]) -> None:
    """Clears these classes when Python ends; a Blender that runs by itself needs no such thing."""
    if not bpy.app.binary_path:
        atexit.unregister(clear)
        atexit.register(clear, classes)


def clear(classes: list[type]) -> None:
    """Takes the properties from classes that are not registered any more."""
    for cls in classes:
        getattr(cls, "__annotations__", {}).clear()
    gc.collect()
