"""Keeps changes without a key if animated values are evaluated again at the same frame.

Blender evaluates animation only at a new frame, so a pose or a setting without a key stays until then. Renders and
exporters with live values cause an earlier evaluation, in the windows, too. Afterwards, this module restores the pose.
"""

from collections.abc import Iterable

import bpy

from ..scene.source_meshes import curves_of

Value = tuple[str, int, object]  # the path of an animated property, the index in an array or else 0, and the value
_kept: dict[bpy.types.ID, list[Value]] = {}


def keep(datablocks: Iterable[bpy.types.ID]) -> None:
    """Remembers the present values of animated properties, unless they are remembered already."""
    for datablock in datablocks:
        if datablock in _kept:
            continue
        kept = _kept[datablock] = []
        keyed = ((curve.data_path, curve.array_index) for curve in curves_of(datablock.animation_data))
        for path, index in dict.fromkeys(keyed):
            try:
                kept.append((path, index, value_at(datablock, path, index)))
            except (LookupError, ValueError):
                continue  # keys may outlive their property


def restore() -> None:
    """Restores the remembered values that have changed since, and forgets all."""
    while _kept:
        datablock, values = _kept.popitem()
        for path, index, value in values:
            try:
                if value_at(datablock, path, index) != value:
                    set_value(datablock, path, index, value)
            except (ReferenceError, LookupError, ValueError, AttributeError, TypeError):
                continue  # the property is gone, or cannot be set


def forget() -> None:
    """Drops the remembered values, because the frame changed, a step was undone, or another file was opened."""
    _kept.clear()


def value_at(datablock: bpy.types.ID, path: str, index: int) -> object:
    """The value of a property or of one member of an array."""
    found = datablock.path_resolve(path)
    return found[index] if hasattr(found, "__len__") and not isinstance(found, str) else found


def set_value(datablock: bpy.types.ID, path: str, index: int, value: object) -> None:
    """Sets a property or one member of an array."""
    found = datablock.path_resolve(path)
    if hasattr(found, "__len__") and not isinstance(found, str):
        found[index] = value
        return
    custom = path.endswith('"]')
    owner, _, name = path[:-2].rpartition('["') if custom else path.rpartition(".")
    holder = datablock.path_resolve(owner) if owner else datablock
    if custom:
        holder[bpy.utils.unescape_identifier(name)] = value
        datablock.update_tag()
    else:
        setattr(holder, name, value)
