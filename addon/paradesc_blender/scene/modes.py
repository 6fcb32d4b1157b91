"""Switches to object mode for a while, as attributes can be read and written only there."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import bpy


@contextmanager
def object_mode(target: bpy.types.Object | None = None) -> Iterator[None]:
    """Puts an object, or the active one, and all that share its mode into object mode.

    If the object is in object mode but its mesh is edited through another one, that one counts. Afterwards the mode,
    the objects in it, the selection and the active object are as before.
    """
    objects = bpy.context.view_layer.objects
    active = objects.active
    leader = target or active
    if leader is not None:
        sharing = (item for item in (leader, *objects) if item.data == leader.data and item.mode != "OBJECT")
        leader = next(sharing, leader)
    mode = "OBJECT" if leader is None else leader.mode
    if mode == "OBJECT":
        yield
        return
    inside = [item for item in objects if item.mode == mode]
    selected = list(objects.selected)
    objects.active = leader
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        objects.active = leader
        select_only(objects, inside)  # edit mode takes all that are selected
        bpy.ops.object.mode_set(mode=mode)
        objects.active = active
        select_only(objects, selected)


def select_only(objects: bpy.types.LayerObjects, wanted: list[bpy.types.Object]) -> None:
    """Selects exactly these objects."""
    for item in objects:
        if item.select_get() != (item in wanted):
            with suppress(RuntimeError):  # hidden objects cannot be selected
                item.select_set(item in wanted)
