"""Appends node groups and materials from the add-on's .blend of assets to the open file."""

import bpy

from paradesc.bridge import InputError

from ..scene.node_groups import MARK
from ..settings.asset_library import FILE


def found_group(mark: str) -> bpy.types.NodeTree | None:
    """The local group with this mark, if there is one."""
    return next((one for one in bpy.data.node_groups if one.get(MARK) == mark and one.library is None), None)


def shared_group(mark: str) -> bpy.types.NodeTree:
    """The group with this mark in the open file, as it is now; else it is appended from the assets."""
    return found_group(mark) or append("node_groups", mark)


def append(kind: str, name: str) -> bpy.types.ID:
    """Appends a group or material of the assets. Groups that it uses are shared with those in the file already."""
    if not FILE.is_file():
        raise InputError(f"The add-on's file of materials is missing: {FILE}; install the add-on again.")
    groups, libraries = set(bpy.data.node_groups), set(bpy.data.libraries)
    with bpy.data.libraries.load(str(FILE), link=False) as (_there, wanted):
        setattr(wanted, kind, [name])
    made = getattr(wanted, kind)[0]
    for group in set(bpy.data.node_groups) - groups - {made}:
        former = next((one for one in groups if one.get(MARK) == group[MARK] and one.library is None), None)
        if former is not None:
            group.user_remap(former)
            bpy.data.node_groups.remove(group)
        else:
            group.asset_clear()
    made.asset_clear()
    for library in set(bpy.data.libraries) - libraries:
        bpy.data.libraries.remove(library)
    return made
