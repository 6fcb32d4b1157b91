"""Fits the radius of settings to a mesh and to what is measured, where they ask for it. Never imports bpy."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from ..bridge import MeshArrays
from . import advice
from .color_maps import EDGES

# The types of job.py, which is built on this.
Settings, Results = TypeVar("Settings"), TypeVar("Results")

# At a radius that suits the rest of the mesh, edges of thin parts are wider than the parts. So the radius is halved, at
# most so many times, where a mask is brighter than half on more than this share of the surface.
HALVINGS, MOST_BRIGHT, WORTH_HALVING = 3, 0.4, 0.05
NARROWED = ("fine", "medium")
# Settings whose radius has been fitted to a mesh have this word in place of a size.
FITTED = "fitted"


def fitted(settings: Settings, arrays: MeshArrays, largest: float = advice.LARGEST_MASK_RADIUS) -> Settings:
    """The settings with the radius that suits this mesh, if they ask for one, in their own unit."""
    if settings.radius_fit not in advice.SIZES or not np.isfinite(arrays.positions).all():
        return settings  # the library refuses this mesh, and names the invalid position
    radius, edge, diagonal = advice.fitted_radius(arrays, settings.descriptors, settings.radius_fit, largest)
    unit = {"diagonal": diagonal, "mean-edge": edge}.get(settings.options.radius_unit, 1.0)
    return replace(settings, options=replace(settings.options, radius=radius / unit), radius_fit=FITTED)


def narrowed(
    settings: Settings,
    compute: Callable[[Settings], Results],
    values_of: Callable[[Results], dict[str, np.ndarray]],
) -> Results:
    """Computes with the fitted radius, then with halves of it while that improves a mask that is bright on too much."""
    results = compute(settings)
    share = bright_share(results, values_of(results))
    for _ in range(HALVINGS):
        if share <= MOST_BRIGHT:
            break
        settings = replace(settings, options=replace(settings.options, radius=settings.options.radius / 2))
        other = compute(settings)
        less = bright_share(other, values_of(other))
        if less > share - WORTH_HALVING:
            break
        results, share = other, less
    return results


def bright_share(results: Results, values: dict[str, np.ndarray]) -> float:
    """The share of the surface on which a mask exceeds half of its range; the largest of several masks."""
    found = [0.0]
    for name in EDGES & values.keys():
        areas = results.areas if values is results.values else np.ones(values[name].shape)
        defined = np.isfinite(values[name])
        total = float(areas[defined].sum())
        found.append(float(areas[defined & (values[name] > 0.5)].sum()) / total if total > 0 else 0.0)
    return max(found)
