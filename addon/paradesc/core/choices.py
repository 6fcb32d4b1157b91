"""Turns what was chosen, in the panel or by a preset, into the settings of a computation and the look of its colors.

A group has the members of members.py as attributes, be it one of Blender's or made of a preset. Never imports bpy.
"""

import math
from decimal import Decimal

from .. import bridge
from ..bridge import ParadescError, unusable
from .color_maps import Levels, Look
from .job import Settings

# The digits of a percentage that a person may have typed. A 32-bit float with more digits is not rounded.
WRITTEN = 9


def radius_member(group: object) -> str:
    """The name of the setting that holds the radius in the chosen unit."""
    return {"diagonal": "radius_percent", "absolute": "radius_absolute"}.get(group.radius_unit, "radius_edges")


def share(percent: float) -> float:
    """A percentage as a fraction, rounded as decimals are: 1.1 gives the float 0.011, which 1.1 / 100 does not."""
    written = Decimal(f"{percent:.{WRITTEN}g}")
    return float(written.scaleb(-2)) if float(written) == percent else percent / 100


def scaled_radius(group: object, radius: float) -> float:
    """A radius of the panel in the unit of the computation, where a share of the diagonal replaces percent."""
    return share(radius) if group.radius_unit == "diagonal" else radius


def more_radii(group: object) -> tuple[float, ...]:
    """The further radii in the unit of the computation; raises one sentence about a part that is not a number."""
    radii = []
    for word in group.more_radii.replace(";", ",").split(","):
        try:
            radius = float(word) if word.strip() else None
        except ValueError:
            radius = math.nan
        if radius is None:
            continue
        if not (math.isfinite(radius) and radius > 0):
            raise unusable(f'"{word.strip()}" in More Radii is not a positive number; separate numbers by commas.')
        radii.append(scaled_radius(group, radius))
    return tuple(radii)


def settings_fault(group: object) -> str:
    """One sentence about a fault that the limits of single settings do not rule out, or ""."""
    try:
        more_radii(group)
    except ParadescError as error:
        return error.sentence
    return ""


def settings_of(group: object, memory_limit: int = 0) -> Settings:
    """The settings as the computation takes them, descriptors in the registry's order."""
    chosen = group.descriptors
    return Settings(
        descriptors=tuple(row.name for row in bridge.descriptors() if row.name in chosen),
        options=bridge.Options(
            radius=scaled_radius(group, getattr(group, radius_member(group))),
            **{row.name: getattr(group, row.name) for row in bridge.TABLE},
        ),
        backend=group.backend,
        device_index=group.device_index,
        more_radii=more_radii(group),
        corner_threshold=share(group.corner_threshold),
        space=group.space,
        radius_fit=group.radius_fit,
        memory_limit=memory_limit,
    )


def look_fault(group: object) -> str:
    """One sentence about a fault that the limits of single color settings do not rule out, or ""."""
    if group.span == "fixed" and not group.maximum > group.minimum:
        return f"The range ends at {group.maximum:g}, which is not above {group.minimum:g}; set a larger maximum."
    return ""


def look_of(group: object) -> Look:
    """The colors as the color maps take them; an invalid range counts as automatic."""
    fixed = group.span == "fixed" and not look_fault(group)
    return Look(
        color_map=group.color_map,
        percentile=group.percentile if group.span == "percentile" else None,
        ranges={"": (group.minimum, group.maximum)} if fixed else {},
        symmetric=group.symmetric,
        neutral=group.neutral if group.use_neutral else None,
        levels=Levels(group.contrast, group.brightness, group.invert),
    )
