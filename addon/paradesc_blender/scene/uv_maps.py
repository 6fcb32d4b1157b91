"""Finds the UV map for an image, and makes one for a mesh that has none an image could use."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import numpy as np

from paradesc import bridge
from paradesc.bridge import InputError
from paradesc.core import job, source_kinds, texel_centers, udim
from paradesc.files.reading import Read, ReadRequest

from . import mesh_io, modes, targets, unwrap

NAME = "Paradesc"
# Charts lie so far apart, as a share of the square's side: eight texels of 1024.
GUTTER = 8 / 1024
# An image is useless if so many faces, by area, share each place on average. Mirrored halves share each place by two.
MOST_STACKED = 3.0
# The side of the image that measures how much of the square is covered.
PROBE = 256


@dataclass
class Over:
    """The mesh's own UV map over which an image is baked."""

    name: str  # "" if modifiers make the map
    repeats: bool  # whether the map reaches beyond the image or tiles
    made: bool = False  # whether it was made for this bake
    note: str = ""


def read_over(
    target: bpy.types.Object, settings: job.Settings, request: ReadRequest
) -> tuple[Read, Over]:
    """Reads a mesh over its active UV map, or over one of ours if that is unusable; makes one if there is none.

    Raises one sentence if the mesh cannot get a map, or if its user has several maps to choose from.
    """
    layers, reason, read, said = target.data.uv_layers, "has no UV map", None, ""
    if len(layers) or request.source not in (source_kinds.ORIGINAL, "deformed"):  # other modifiers may add a map
        read = targets.read(target, settings, request)
        reason = fault(read.measured)
        why = udim.of_mesh(read.measured).why
        said = f" {why}" if reason and why else ""
    if not reason:
        return over(read, layers.active.name if layers.active is not None else "")
    if not may_make(target):
        if read is None or read.measured.map_fault:
            raise InputError(f'The mesh "{target.data.name}" {reason}; unwrap it (U in edit mode).')
        return over(read, layers.active.name)
    reason = reason.split(" (")[0]  # what others can be used is our own affair here
    name = own(target.data)
    if name:
        with active(target, name):
            read = targets.read(target, settings, request)
        if not fault(read.measured):
            return over(read, name, note=f'Over the UV map "{name}": the mesh {reason}.{said}')
    name = make(target)
    try:
        with active(target, name):
            read = targets.read(target, settings, request)
    except bridge.ParadescError:
        remove(target, name)
        raise
    return over(read, name, True, f'New UV map "{name}": the mesh {reason}.{said}')


def over(read: Read, name: str, made: bool = False, note: str = "") -> tuple[Read, Over]:
    """The mesh that was read, and the facts about its map."""
    tiling = udim.of_mesh(read.measured)
    return read, Over(name, not tiling.first and not tiling.tiles, made, note)


def fault(arrays: bridge.MeshArrays) -> str:
    """The reason why no image should lie over the mesh's own UV map, worded as "has …", or ""."""
    if arrays.map_fault or udim.of_mesh(arrays).tiles:
        return arrays.map_fault
    corners = arrays.corner_uvs[arrays.triangle_corners]
    ones = np.ones(len(arrays.positions), np.float32)
    covered = np.isfinite(bridge.draw_uv_image(corners, arrays.triangle_vertices, ones, PROBE)).mean()
    stacked = texel_centers.uv_area(arrays) > MOST_STACKED * covered
    return "has a UV map with most faces over each other" if stacked else ""


def own(mesh: bpy.types.Mesh) -> str:
    """The name of the newest map that this module made, or ""."""
    return next((layer.name for layer in reversed(mesh.uv_layers) if layer.name.startswith(NAME)), "")


def may_make(target: bpy.types.Object) -> bool:
    """Returns whether the mesh may get a map. With several maps, the user has to choose among them."""
    others = [layer for layer in target.data.uv_layers if not layer.name.startswith(NAME)]
    return len(others) < 2 and not mesh_io.unwritable(target)


def make(target: bpy.types.Object) -> str:
    """Unwraps a copy of the mesh and adds the layout to the mesh as a new UV map; returns its name."""
    mesh = target.data
    arrays = mesh_io.read_object(target, False, False)
    with modes.object_mode(target):
        uvs = unwrap.lay_out(arrays, unwrap.face_starts(mesh), GUTTER)
        layer = mesh.uv_layers.new(name=NAME, do_init=False)
        if layer is None:
            raise InputError(f'The mesh "{mesh.name}" has as many UV maps as Blender allows; remove one.')
        unwrap.write_uvs(layer, uvs)
        return layer.name


def remove(target: bpy.types.Object, name: str) -> None:
    """Removes a map that was made for a failed bake."""
    with modes.object_mode(target):
        layer = target.data.uv_layers.get(name)
        if layer is not None:
            target.data.uv_layers.remove(layer)


@contextmanager
def active(target: bpy.types.Object, name: str) -> Iterator[None]:
    """Temporarily makes this map the active one; "" changes nothing."""
    layers = target.data.uv_layers
    former = layers.active_index
    if not name or layers.active == layers.get(name):
        yield
        return
    layers.active = layers[name]
    try:
        yield
    finally:
        layers.active_index = former
