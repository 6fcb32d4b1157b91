"""Says what a legend shows: title, unit and numbers of a range of colors, for pictures and the viewport. No bpy."""

from .. import bridge
from . import color_maps
from .job import registry_name, registry_row

# The line under the title of directions, whose colors have no scale.
DIRECTIONS = "sizes of x, y, z as red, green, blue"


def title(name: str, unit: str) -> str:
    """The descriptor in words with its unit: "Mean Curvature (1/length)"."""
    return label(name) + in_unit(unit)


def in_unit(unit: str) -> str:
    """The unit as the end of a label: " (1/length)", or "" for values without a unit."""
    return f" ({unit})" if unit else ""


def label(name: str) -> str:
    """The descriptor as menus show it."""
    return registry_row(name).label + label_ending(name)


def label_ending(name: str) -> str:
    """The variant of values as the end of a label: ", radius 0.02"; labels of the registry say if it is a change."""
    rest = name.removeprefix(registry_name(name))
    words = [f"radius {part[1:]}" if part[0] == "r" and part[1:2].isdigit() else part for part in rest.split("_")[1:]]
    return "".join(f", {word}" for word in words).removesuffix(", change")


def unit_of(name: str, map_descriptor: str) -> str:
    """The unit of a descriptor's values; that of an operator depends on its map."""
    stem = registry_name(name)
    return next((row.unit_on(map_descriptor) for row in bridge.descriptors() if row.name == stem), "")


def ticks(name: str, shown: color_maps.ValueRange) -> list[tuple[float, str]]:
    """The places along the bar, in [0, 1], and their numbers: both ends, and the neutral value or the middle.

    A grey mask is read from 0 to 1, or back if it is inverted.
    """
    if shown.map_name == color_maps.GREY and shown.minimum >= 0 and registry_name(name) in color_maps.MASKS:
        return [(0.0, "1"), (1.0, "0")] if shown.levels.invert else [(0.0, "0"), (1.0, "1")]
    span = shown.maximum - shown.minimum
    middle = shown.neutral
    if middle is None or not (0.15 <= (middle - shown.minimum) / span <= 0.85):
        middle = shown.minimum + span / 2
    values = (shown.minimum, middle, shown.maximum)
    texts = ["0" if abs(value) < 1e-6 * span else f"{value:.3g}" for value in values]  # 0 if it is negligible
    return [((value - shown.minimum) / span, text) for value, text in zip(values, texts, strict=True)]
