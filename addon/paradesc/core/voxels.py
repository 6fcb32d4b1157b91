"""Tells whether a surface was made of voxels, and warns of radii at which values show their steps. Never imports bpy.

Marching cubes put each vertex on an edge of the voxels' grid, so two of its coordinates are those of grid planes. If
the voxels are labels, the third coordinate is halfway between two planes, unless the labels were smoothed first.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

# So many vertices suffice, taken at equal steps from all of them.
ENOUGH = 4096
# The fullest values of a coordinate, with this share of the vertices, are planes; each is that of at least so many.
OF_FULLEST, OF_PLANE = 0.3, 3
# Nearly all vertices lie on edges of the grid.
NEARLY_ALL = 0.95
# Rounding of a coordinate, as a share of a voxel.
ROUNDING = 1e-3
# At radii below so many voxels the values show steps; so many voxels are a good radius.
STEPS, GOOD = 6.0, 10.0


@dataclass(frozen=True)
class Grid:
    """A guess at the grid's planes along an axis: their distance, and which coordinates lie on one or halfway."""

    size: float
    on_plane: NDArray[np.bool_]
    halfway: NDArray[np.bool_]

    @cached_property
    def share(self) -> float:
        """The share of the vertices on planes."""
        return float(self.on_plane.mean())


def notes(positions: np.ndarray, radius: float, is_chosen: bool) -> list[str]:
    """A note if values at the radius, a length, show the steps of voxels.

    is_chosen: whether the radius was fitted to the mesh. Detail of a few voxels may be real where steps are smoothed,
    so that nobody is warned of an own radius there.
    """
    size, has_steps = made_of(positions) or (0.0, False)
    if radius >= STEPS * size or not (has_steps or is_chosen):
        return []
    if has_steps:
        return [
            f"The surface has the steps of voxels of {size:.3g}, and values at radii below {STEPS:g} voxels show them; "
            f"choose a radius of {GOOD * size:.3g}, ten voxels."
        ]
    return [
        f"The surface was made of voxels of {size:.3g}: if these were labels and not gray values, it has smoothed steps, "
        f"and values at radii below {STEPS:g} voxels show them; choose a radius of {GOOD * size:.3g}, ten voxels."
    ]


def made_of(positions: np.ndarray) -> tuple[float, bool] | None:
    """The size of the voxels that (n, 3) positions come from, and whether these have steps; None if there are none."""
    some = positions[:: 1 + len(positions) // ENOUGH].astype(np.float64)
    best, most, of_axes = None, NEARLY_ALL, []
    for axis in range(3):
        if not (found := guesses(some[:, axis])):
            return None
        of_axes.append(found)
    for grids in product(*of_axes):
        if not 2 * NEARLY_ALL <= sum(grid.share for grid in grids) <= 3 - NEARLY_ALL:  # as on edges
            continue
        on_plane = np.stack([grid.on_plane for grid in grids])
        on_edge = on_plane.sum(axis=0) == 2
        along = (~on_plane & on_edge).mean(axis=1) > 1 - NEARLY_ALL  # a height field has edges along one axis alone
        if on_edge.mean() > most and along.sum() >= 2:
            best, most = grids, float(on_edge.mean())
    if best is None:
        return None
    has_steps = np.all([grid.on_plane | grid.halfway for grid in best], axis=0).mean() > NEARLY_ALL
    return max(grid.size for grid in best), bool(has_steps)


def guesses(values: np.ndarray) -> list[Grid]:
    """Grids whose planes hold many of (n,) coordinates: all planes that are found, or every second one."""
    distinct, counts = np.unique(values, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    fullest = order[: 1 + np.searchsorted(np.cumsum(counts[order]), OF_FULLEST * len(values))]
    if len(fullest) < 2 or counts[fullest[-1]] < OF_PLANE:
        return []
    gap = float(np.diff(np.sort(distinct[fullest])).min())
    steps = (values - distinct[order[0]]) / gap
    nearest = np.round(steps)
    near, odd = np.abs(steps - nearest) < ROUNDING, nearest % 2 != 0
    halfway = np.abs(steps - np.floor(steps) - 0.5) < ROUNDING
    return [Grid(gap, near, halfway), Grid(gap, halfway, near)] + [
        Grid(2 * gap, near & (odd == on_odd), near & (odd != on_odd)) for on_odd in (False, True)
    ]
