"""Turns values into colors: perceptually uniform color maps, and the range of values that they span.

viridis is the map of Stéfan van der Walt and Nathaniel Smith (CC0), at 17 of its 256 places. All others are formulas in
Björn Ottosson's OKLab space (public domain): lightness changes evenly, and in diverging maps equally to both sides.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..bridge import Descriptor

# The color of a value that does not exist.
UNDEFINED_COLOR = (0.5, 0.5, 0.5)
# Share of the values, in percent, that is left outside the range on either side.
CLIPPED_PERCENT = 2.5
# Curvatures below this share of 1/radius (squared for 1/length^2) are rounding, so that a plane stays neutral.
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

# The color of a value that does not exist, in maps that contain grey.
UNDEFINED_IN_GREY = (0.55, 0.38, 0.72)
# AUTOMATIC stands for the map that suits the descriptor, and for the range of the registry or of percentiles.
AUTOMATIC = "auto"
SEQUENTIAL, DIVERGING, GREY = "viridis", "blue-red", "grey"
# Masks, which artists multiply with other colors. They are grey unless another map is chosen.
MASKS = {"cavity", "convexity", "ambient_openness"}
# The masks that are black on a plane.
EDGES = {"cavity", "convexity"}
# White in a mask is the 98th percentile of the values that are not black, but low enough that this percentage of the
# surface is brighter than half of white. It is not below the smallest share of the mask's range, so that nearly flat
# areas stay nearly black.
NOT_BLACK, WHITE_PERCENTILE, BRIGHT_PERCENT, LEAST_WHITE = 0.002, 98.0, 4.0, 0.05
# Limbs and bodies bend everywhere. So black in a mask of EDGES is the value that this percentage of the surface has at
# most, up to the value of a tube that is twice as thick as the ball that measures it.
USUAL_PERCENT, MOST_USUAL = 60.0, 0.25

# The shares of a color map up to which it counts as nearly black, and from which on as nearly white. A mask shows
# little if more than MOST_EXTREME of it is one of the two.
DARK, BRIGHT, MOST_EXTREME = 0.05, 0.95, 0.8
# A mask of which more than this share is nearly black gives way to another mask of the same bake with a smaller share.
TELLING = 0.6
# (n,) values, and how much of the surface each stands for; None: the same.
Weighted = tuple[np.ndarray, np.ndarray | None]


@dataclass(frozen=True)
class ColorMap:
    """Turns shares in [0, 1] into colors."""

    name: str
    label: str
    description: str
    diverging: bool
    function: Callable[[np.ndarray], np.ndarray]  # (n,) positions in [0, 1] to (n, 3) display colors
    undefined: tuple[float, float, float] = UNDEFINED_COLOR


@dataclass(frozen=True)
class Levels:
    """Changes places in a color map, as image editors do: to (n,) shares in [0, 1]."""

    contrast: float = 0.0  # from -1, all is the middle, to 1, all is black or white
    brightness: float = 0.0  # from -1 to 1: the exponent of a sequential map is 4 to 1/4
    invert: bool = False

    def applied(self, shares: np.ndarray, diverging: bool) -> np.ndarray:
        """(n,) shares; the middle of a diverging map stays where it is."""
        if self.brightness and not diverging:
            shares = shares ** 4.0**-self.brightness
        if self.contrast:
            gain = math.tan(math.pi / 4 * (1 + min(max(self.contrast, -1.0), 0.999)))
            shares = np.clip(0.5 + gain * (shares - 0.5), 0.0, 1.0)
        return 1.0 - shares if self.invert else shares


@dataclass(frozen=True)
class ValueRange:
    """The values at the two ends of a color map, and which map it is."""

    minimum: float
    maximum: float
    diverging: bool
    neutral: float | None = None  # the middle of a diverging map shows it; without one, halfway
    map_name: str = AUTOMATIC
    levels: Levels = Levels()

    @property
    def color_map(self) -> ColorMap:
        """The color map of this name, or the default one for a range of this kind."""
        return MAPS.get(self.map_name) or MAPS[DIVERGING if self.diverging else SEQUENTIAL]

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Turns (n,) finite values into places in the color map: a diverging one changes equally fast on both sides."""
        held = np.clip(values, self.minimum, self.maximum)
        if not self.color_map.diverging or self.neutral is None:
            return self.levels.applied((held - self.minimum) / (self.maximum - self.minimum), False)
        half = max(self.maximum - self.neutral, self.neutral - self.minimum)
        return self.levels.applied(0.5 + 0.5 * (held - self.neutral) / half, True)


@dataclass(frozen=True)
class Look:
    """The way from values to colors: the choice of a map, and of the values at its ends."""

    color_map: str = AUTOMATIC
    percentile: float | None = None  # per cent of the values left outside on either side; None: as suits the descriptor
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)  # fixed ones by descriptor; "": of all others
    symmetric: bool = True  # of signed descriptors, by percentiles: about the neutral value
    neutral: float | None = None  # instead of the descriptor's own
    levels: Levels = Levels()

    def fixed(self, descriptor: Descriptor) -> tuple[float, float] | None:
        """The fixed range of a descriptor, or None."""
        return self.ranges.get(descriptor.name) or self.ranges.get("")

    def is_automatic(self, diverging: bool) -> bool:
        """Returns whether only the values decide: no range, percentile, other neutral value or asymmetry is set."""
        is_usual = not diverging or (self.symmetric and self.neutral is None)
        return is_usual and not self.ranges and self.percentile is None


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


def oklch_to_srgb(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """(n,) OKLab lightness, chroma and hue (degrees) to (n, 3) display colors."""
    angle = np.radians(hue)
    lab = np.stack(np.broadcast_arrays(lightness, chroma * np.cos(angle), chroma * np.sin(angle)), axis=1)
    return linear_to_srgb(oklab_to_linear(lab))


# ---- Maps


def viridis(share: np.ndarray) -> np.ndarray:
    """(n,) in [0, 1] to (n, 3) display colors, dark to light."""
    places = np.linspace(0.0, 1.0, len(VIRIDIS))
    return np.stack([np.interp(share, places, VIRIDIS[:, channel]) for channel in range(3)], axis=1)


def line(start: tuple[float, float, float], end: tuple[float, float, float]) -> Callable[[np.ndarray], np.ndarray]:
    """A straight line in OKLab between two colors given as lightness, chroma, hue: no map is more even."""

    def function(share: np.ndarray) -> np.ndarray:
        ends = [
            np.array([light, chroma * np.cos(np.radians(hue)), chroma * np.sin(np.radians(hue))])
            for light, chroma, hue in (start, end)
        ]
        share = np.asarray(share, np.float64)[:, None]
        return linear_to_srgb(oklab_to_linear((1 - share) * ends[0] + share * ends[1]))

    return function


def value_itself(share: np.ndarray) -> np.ndarray:
    """(n,) in [0, 1] to (n, 3) display colors whose scene-linear ones are the shares: shaders read the mask's value."""
    return np.repeat(linear_to_srgb(np.asarray(share, np.float64))[:, None], 3, axis=1)


def heat(share: np.ndarray) -> np.ndarray:
    """(n,) in [0, 1] to (n, 3) display colors: black, red, orange, yellow, white."""
    share = np.asarray(share, np.float64)
    chroma = 0.127 * np.sin(np.pi * np.clip(share, 0.0, 1.0))
    return oklch_to_srgb(0.14 + 0.85 * share, chroma, 18.0 + 90.0 * share)


def two_sided(
    middle: float, ends: float, chroma: float, hues: tuple[float, float]
) -> Callable[[np.ndarray], np.ndarray]:
    """Two straight lines in OKLab from a grey in the middle to two hues (degrees) of one lightness and chroma."""

    def function(share: np.ndarray) -> np.ndarray:
        signed = 2.0 * np.asarray(share, np.float64) - 1.0
        strength = np.abs(signed)
        return oklch_to_srgb(middle + (ends - middle) * strength, chroma * strength, np.where(signed < 0, *hues))

    return function


MAPS = {
    row.name: row
    for row in (
        ColorMap(SEQUENTIAL, "Viridis", "Violet, green, yellow: dark to light", False, viridis),
        ColorMap("heat", "Heat", "Black, red, yellow, white: dark to light", False, heat),
        ColorMap("blue-yellow", "Blue to Yellow", "From dark to light, readable with any color vision", False,
            line((0.25, 0.09, 262.0), (0.95, 0.11, 100.0)), UNDEFINED_IN_GREY),
        ColorMap(GREY, "Grey", "From black to white; shaders read the value itself", False, value_itself,
            UNDEFINED_IN_GREY),
        ColorMap(DIVERGING, "Blue, White, Red", "Light in the middle, dark ends", True,
            two_sided(0.97, 0.45, 0.175, (262.0, 25.0))),
        ColorMap("purple-green", "Purple, White, Green", "Light in the middle, dark ends", True,
            two_sided(0.97, 0.45, 0.13, (310.0, 145.0))),
        ColorMap("blue-black-orange", "Blue, Black, Orange", "Dark in the middle, light ends", True,
            two_sided(0.2, 0.76, 0.125, (245.0, 65.0))),
        ColorMap("cavity", "Cavity", "Black hollows, grey surface, white edges; for masks and overlays", True,
            line((0.2, 0, 0), (1, 0, 0)), UNDEFINED_IN_GREY),
    )
}  # fmt: skip


# ---- Range


def value_range(
    values: np.ndarray,
    descriptor: Descriptor,
    radius: float,
    look: Look | None = None,
    areas: np.ndarray | None = None,
) -> ValueRange:
    """The range to show for (n,) values: that of the look, else the registry's if it has one, else percentiles.

    areas: (n,) how much of the surface each value stands for; None: the same.
    """
    look = look or Look()
    neutral = neutral_value(descriptor, look)
    bounds = look.fixed(descriptor)
    if bounds is None and look.percentile is None and math.isfinite(descriptor.display_minimum):
        bounds = (descriptor.display_minimum, descriptor.display_maximum)
        if descriptor.name in MASKS:
            low = usual(values, areas, *bounds) if descriptor.name in EDGES else bounds[0]
            bounds = (low, strong(values, areas, low, bounds[1]))
    if bounds is None:
        percentile = CLIPPED_PERCENT if look.percentile is None else look.percentile
        finite = np.asarray(values, np.float64)[np.isfinite(values)]
        bounds = tuple(np.percentile(finite, [percentile, 100 - percentile])) if finite.size else (0.0, 0.0)
        if descriptor.is_signed:
            bounds = about_neutral(bounds, neutral, smallest_half(descriptor, radius), look.symmetric)
    low, high = map(float, bounds)
    if not high > low:
        high = low + (abs(low) or 1.0)
    return ValueRange(low, high, descriptor.is_signed, neutral, map_name(descriptor, look), look.levels)


def with_one_scale(look: Look, baked: list[tuple[Descriptor, float, list[Weighted]]]) -> Look:
    """The look with one range for each descriptor over the values of all meshes."""
    if look.ranges:
        return look
    ranges = {}
    for descriptor, radius, found in baked:
        every, parts = (list(part) for part in zip(*found, strict=True))
        areas = None if any(part is None for part in parts) else np.concatenate(parts)
        shown = value_range(np.concatenate(every), descriptor, radius, look, areas)
        ranges[descriptor.name] = (shown.minimum, shown.maximum)
    return replace(look, ranges=ranges)


def usual(values: np.ndarray, areas: np.ndarray | None, low: float, high: float) -> float:
    """The value up to which a mask of EDGES is black: that of most of the surface."""
    defined = np.isfinite(values)
    weights = np.ones(int(defined.sum())) if areas is None else areas[defined]
    most = low + MOST_USUAL * (high - low)
    return min(max(quantile(values[defined], weights, USUAL_PERCENT), low), most)


def strong(values: np.ndarray, areas: np.ndarray | None, low: float, high: float) -> float:
    """The value that is drawn white in a mask."""
    defined = np.isfinite(values)
    shares = (values[defined].astype(np.float64) - low) / (high - low)
    weights = np.ones(len(shares)) if areas is None else areas[defined]
    seen = shares > NOT_BLACK
    white = min(
        quantile(shares[seen], weights[seen], WHITE_PERCENTILE), 2 * quantile(shares, weights, 100 - BRIGHT_PERCENT)
    )
    return low + float(np.clip(white, LEAST_WHITE, 1.0)) * (high - low)


def quantile(values: np.ndarray, weights: np.ndarray, percent: float) -> float:
    """The percentile of (n,) values with weights; 0 if there is nothing."""
    total = float(weights.sum())
    if not total > 0:
        return 0.0
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return float(values[order][min(np.searchsorted(reached, percent / 100 * reached[-1]), len(values) - 1)])


def most_telling(dark: list[float]) -> int:
    """The index of the mask to show: the first, unless most of it is nearly black; then the least black one."""
    return 0 if dark[0] <= TELLING else dark.index(min(dark))


def map_name(descriptor: Descriptor, look: Look) -> str:
    """The map that the look asks for; AUTOMATIC stands for one of the two that suit values without and with a sign."""
    return GREY if look.color_map == AUTOMATIC and descriptor.name in MASKS else look.color_map


def neutral_value(descriptor: Descriptor, look: Look) -> float | None:
    """The value that the middle of a diverging map stands for; None for the middle of the range."""
    if look.neutral is not None:
        return look.neutral
    if not descriptor.is_signed:
        return None
    return descriptor.neutral_value if math.isfinite(descriptor.neutral_value) else 0.0


def about_neutral(bounds: tuple[float, float], neutral: float, smallest: float, symmetric: bool) -> tuple[float, float]:
    """Bounds that reach at least a smallest distance from the neutral value, the same on both sides if symmetric."""
    half = max(abs(bounds[0] - neutral), abs(bounds[1] - neutral), smallest)
    if symmetric or half == smallest:
        return neutral - half, neutral + half
    return bounds


def smallest_half(descriptor: Descriptor, radius: float) -> float:
    """Half the smallest range that is worth showing around a neutral value. Smaller differences count as neutral."""
    if descriptor.map_degree > 0 and radius > 0:  # differences of a map without unit, to a power
        return FLATNESS**descriptor.map_degree * radius**descriptor.length_power
    if descriptor.length_power >= 0 or not radius > 0:
        return FLATNESS
    return (FLATNESS / radius) ** -descriptor.length_power


def colors(values: np.ndarray, shown: ValueRange) -> np.ndarray:
    """Turns (n,) values into (n, 3) float32 display colors; undefined ones are grey, or violet in grey maps.

    For (n, 3) directions, which have no sign, the sizes of the components are red, green and blue.
    """
    values = np.asarray(values, np.float64)
    if values.ndim == 2:
        return np.where(np.isfinite(values), np.abs(values), UNDEFINED_COLOR).astype(np.float32)
    defined = np.isfinite(values)
    result = shown.color_map.function(shown.shares(np.where(defined, values, shown.minimum)))
    result[~defined] = shown.color_map.undefined
    return result.astype(np.float32)


def linear_rgba(display: np.ndarray) -> np.ndarray:
    """(n, 3) display colors to (n, 4) float32 scene-linear opaque ones, as in Blender's FLOAT_COLOR attributes."""
    rgba = np.ones((len(display), 4), np.float32)
    rgba[:, :3] = srgb_to_linear(display)
    return rgba
