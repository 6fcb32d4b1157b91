"""Brings a mesh from object space into world space, to measure it there. Never imports bpy."""

from dataclasses import replace

import numpy as np

from ..bridge import MeshArrays, origin, unusable

# Scales along the axes count as equal if they differ by less than this share.
EVEN = 1e-4


def scales(matrix: np.ndarray) -> np.ndarray:
    """(3,) lengths that the unit ball's longest to shortest axes get by a (4, 4) or (3, 3) matrix."""
    return np.linalg.svd(np.asarray(matrix, np.float64)[:3, :3], compute_uv=False)


def is_even(matrix: np.ndarray) -> bool:
    """Returns whether a matrix scales all directions alike; it may mirror."""
    found = scales(matrix)
    return bool(found[0] - found[2] <= EVEN * found[0])


def check_scale(matrix: np.ndarray, name: str) -> None:
    """Refuses a matrix that is not finite or that flattens the object of this name."""
    linear = np.asarray(matrix, np.float64)[:3, :3]
    if np.isfinite(linear).all():
        found = scales(linear)
        if found[2] > 1e-7 * found[0]:
            return
    raise unusable(f'The object "{name}" is scaled to nothing along an axis; it has no shape in the world to measure.')


def measured(
    arrays: MeshArrays, matrix: np.ndarray, name: str, space: str, remedy: str
) -> tuple[MeshArrays, list[str]]:
    """The arrays in the space that is measured; a sentence if the object's uneven scale is ignored."""
    found = replace(arrays)
    if space == "world":
        if arrays.maps is not None:
            found.maps = replace(arrays.maps)
        to_world(found, matrix, name)
    elif not is_even(matrix):
        sentence = (
            f'The object "{name}" is scaled differently along its axes, but was measured without its scale; {remedy}, '
            "or apply the scale."
        )
        return found, [sentence]
    return found, []


def to_world(arrays: MeshArrays, matrix: np.ndarray, name: str) -> None:
    """Brings the arrays of an object of that name into world space, except for its location.

    A mirroring matrix is taken as its negative: the surface comes out as its own mirror image, which has the same
    curvatures, areas and volumes, while the inside stays the inside. Directions become those of the world.
    """
    check_scale(matrix, name)
    linear = np.asarray(matrix, np.float64)[:3, :3]
    if np.linalg.det(linear) < 0:
        linear = -linear
    positions = arrays.positions @ linear.T
    near = arrays.positions.dtype == np.float32
    arrays.positions = np.ascontiguousarray(positions, np.float32) if near else origin.stored(positions)
    if arrays.corner_normals is not None:
        arrays.corner_normals = unit(arrays.corner_normals @ np.linalg.inv(linear))
    if arrays.maps is not None:
        maps_to_world(arrays, linear, name)


def maps_to_world(arrays: MeshArrays, linear: np.ndarray, name: str) -> None:
    """Converts displacement and normal maps to world space, which needs an even scale."""
    if not is_even(linear):
        sentence = (
            f'The object "{name}" is scaled differently along its axes, which displacement and normal maps cannot '
            "follow; apply the scale, or measure in object space."
        )
        raise unusable(sentence)
    maps = arrays.maps
    maps.scale *= float(scales(linear).mean())
    if maps.corner_tangents is not None:
        maps.corner_tangents = maps.corner_tangents.copy()
        maps.corner_tangents[:, :3] = unit(maps.corner_tangents[:, :3] @ linear.T)


def turned(directions: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """(n, 3) float32 unit vectors of directions (n, 3) that a (3, 3) matrix turns; NaN where there are none."""
    found = directions.astype(np.float64) @ linear.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return (found / np.linalg.norm(found, axis=1, keepdims=True)).astype(np.float32)


def unit(vectors: np.ndarray) -> np.ndarray:
    """(n, 3) float32 unit vectors; zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.ascontiguousarray(vectors / np.where(lengths > 0, lengths, 1.0), np.float32)
