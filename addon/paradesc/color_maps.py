"""Values to colors: a sequential and a diverging color map, both perceptually uniform, and the range to show.

Sequential: viridis by Stéfan van der Walt and Nathaniel Smith (CC0), at 17 of its 256 places.
Diverging: blue, white, red on straight lines in Björn Ottosson's OKLab space (public domain), both ends equally dark.
"""

import math
from dataclasses import dataclass

import numpy as np

from .bridge import Descriptor

# Shown where a value does not exist.
UNDEFINED_COLOR = (0.5, 0.5, 0.5)
# Share of the values, in percent, that is left outside the range on either side.
CLIPPED_PERCENT = 2.5
# Curvatures below this share of 1/radius (squared for 1/length^2) are rounding: a plane stays neutral.
FLATNESS = 1e-4

VIRIDIS = np.array(
    [
        [0.267, 0.005, 0.329], [0.282, 0.095, 0.417], [0.279, 0.175, 0.483], [0.259, 0.251, 0.524],
        [0.230, 0.321, 0.545], [0.200, 0.386, 0.555], [0.173, 0.447, 0.558], [0.150, 0.506, 0.557],
        [0.128, 0.565, 0.551], [0.120, 0.624, 0.534], [0.155, 0.682, 0.503], [0.241, 0.737, 0.455],
        [0.363, 0.787, 0.387], [0.508, 0.829, 0.299], [0.669, 0.862, 0.195], [0.836, 0.886, 0.102],
        [0.993, 0.906, 0.144],
    ]
)  # fmt: skip

# Lightness, chroma and hue (degrees) of the diverging map's ends, and the lightness of its middle.
DARK_LIGHTNESS, CHROMA, BLUE_HUE, RED_HUE, WHITE_LIGHTNESS = 0.45, 0.175, 262.0, 25.0, 0.97


@dataclass(frozen=True)
class ValueRange:
    """The values at the two ends of a color map."""

    minimum: float
    maximum: float
    diverging: bool


def linear_to_srgb(linear: np.ndarray) -> np.ndarray:
    """Scene-linear to display values, elementwise in [0, 1]."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)


def srgb_to_linear(display: np.ndarray) -> np.ndarray:
    """Display values to scene-linear, elementwise in [0, 1]."""
    display = np.clip(display, 0.0, 1.0)
    return np.where(display <= 0.04045, display / 12.92, np.power((display + 0.055) / 1.055, 2.4))


def oklab_to_linear(lab: np.ndarray) -> np.ndarray:
    """(n, 3) OKLab to (n, 3) linear sRGB."""
    lightness, a, b = lab[:, 0], lab[:, 1], lab[:, 2]
    long = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3
    middle = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3
    short = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3
    return np.stack(
        [
            4.0767416621 * long - 3.3077115913 * middle + 0.2309699292 * short,
            -1.2684380046 * long + 2.6097574011 * middle - 0.3413193965 * short,
            -0.0041960863 * long - 0.7034186147 * middle + 1.7076147010 * short,
        ],
        axis=1,
    )


def sequential(share: np.ndarray) -> np.ndarray:
    """(n,) in [0, 1] to (n, 3) display colors, dark to light."""
    places = np.linspace(0.0, 1.0, len(VIRIDIS))
    return np.stack([np.interp(share, places, VIRIDIS[:, channel]) for channel in range(3)], axis=1)


def diverging(share: np.ndarray) -> np.ndarray:
    """(n,) in [0, 1] to (n, 3) display colors: blue, white at 0.5, red."""
    signed = 2.0 * np.asarray(share, np.float64) - 1.0
    strength = np.abs(signed)
    hue = np.radians(np.where(signed < 0, BLUE_HUE, RED_HUE))
    lightness = WHITE_LIGHTNESS + (DARK_LIGHTNESS - WHITE_LIGHTNESS) * strength
    lab = np.stack([lightness, CHROMA * strength * np.cos(hue), CHROMA * strength * np.sin(hue)], axis=1)
    return linear_to_srgb(oklab_to_linear(lab))


def value_range(values: np.ndarray, descriptor: Descriptor, radius: float) -> ValueRange:
    """The range to show for (n,) values: the registry's where it is fixed, else by the values' percentiles."""
    if math.isfinite(descriptor.display_minimum) and math.isfinite(descriptor.display_maximum):
        return ValueRange(descriptor.display_minimum, descriptor.display_maximum, descriptor.is_signed)
    finite = np.asarray(values, np.float64)[np.isfinite(values)]
    low, high = (0.0, 0.0) if finite.size == 0 else np.percentile(finite, [CLIPPED_PERCENT, 100 - CLIPPED_PERCENT])
    if descriptor.is_signed:
        neutral = descriptor.neutral_value if math.isfinite(descriptor.neutral_value) else 0.0
        half = max(abs(low - neutral), abs(high - neutral), smallest_half(descriptor, radius))
        return ValueRange(float(neutral - half), float(neutral + half), True)
    if not high > low:
        high = low + (abs(low) or 1.0)
    return ValueRange(float(low), float(high), False)


def smallest_half(descriptor: Descriptor, radius: float) -> float:
    """Half the smallest range worth showing around a neutral value; below it everything is neutral."""
    if descriptor.map_degree > 0 and radius > 0:  # differences of a map without unit, to a power
        return FLATNESS**descriptor.map_degree * radius**descriptor.length_power
    if descriptor.length_power >= 0 or not radius > 0:
        return FLATNESS
    return (FLATNESS / radius) ** -descriptor.length_power


def colors(values: np.ndarray, shown: ValueRange) -> np.ndarray:
    """(n,) values to (n, 3) float32 display colors; mid-grey where undefined.

    Of (n, 3) directions, which have two signs, the components' sizes are red, green and blue.
    """
    values = np.asarray(values, np.float64)
    if values.ndim == 2:
        return np.where(np.isfinite(values), np.abs(values), UNDEFINED_COLOR).astype(np.float32)
    defined = np.isfinite(values)
    share = np.clip((np.where(defined, values, 0.0) - shown.minimum) / (shown.maximum - shown.minimum), 0.0, 1.0)
    result = diverging(share) if shown.diverging else sequential(share)
    result[~defined] = UNDEFINED_COLOR
    return result.astype(np.float32)


def linear_rgba(display: np.ndarray) -> np.ndarray:
    """(n, 3) display colors to (n, 4) float32 scene-linear ones, opaque: what Blender's FLOAT_COLOR holds."""
    rgba = np.ones((len(display), 4), np.float32)
    rgba[:, :3] = srgb_to_linear(display)
    return rgba
