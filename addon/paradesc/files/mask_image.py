"""Turns values over a UV map into the pixels of a texture: 16 bits over a range of values, with a gutter. No bpy.

A descriptor with a sign has its neutral value at pixel 32768 exactly, which stands for 0.5, and the same steps on both
sides of it: engines read such a texture as 2 x - 1. All others go from their minimum at 0 to their maximum at 65535.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from .. import bridge
from ..core import threads
from ..core.color_maps import BRIGHT, DARK, Levels, ValueRange
from ..core.threads import Result

WHOLE, MIDDLE = 65535, 32768
# A texture of this side keeps a gutter of a texel when it is halved again and again down to it.
SMALLEST_CLEAN = 128
LEAST_GUTTER = 8
# Every texel beside a chart is filled; further out, squares with this side in texels are filled as a whole.
SQUARE = 8
# Rows of pixels that are worked on together, so that they stay in the processor's cache.
BAND = 8 * SQUARE


@dataclass(frozen=True)
class Scale:
    """The meaning of pixels: value = low + (high - low) * pixel / 65535."""

    low: float
    high: float
    outside: int  # the pixel where there is no surface
    levels: Levels = field(default_factory=Levels)  # which have changed the pixels since

    def meaning(self, name: str, unit: str) -> str:
        """The scale as a formula, which is written into the file for programs and people."""
        formula = f"{name} = {self.low!r} + ({self.high!r} - {self.low!r}) * pixel / {WHOLE}"
        formula += f" [{unit}]" if unit else ""
        numbers = {"brightness": self.levels.brightness, "contrast": self.levels.contrast}
        changes = [f"{word} {number:g}" for word, number in numbers.items() if number]
        changes += ["inversion"] if self.levels.invert else []
        return formula + (f" before {', '.join(changes)}" if changes else "")


@dataclass(frozen=True)
class Pixels:
    """One descriptor as pixels, rows from v = 0 up."""

    values: np.ndarray  # (N, N, 1 or 3) uint16
    filled: np.ndarray  # (N, N) bool: on the surface or in the gutter
    covered: float  # the share of texels on the surface
    dark: float  # the share of those that are nearly black
    bright: float  # and nearly white
    scale: Scale


def scale_of(shown: ValueRange, neutral: float) -> Scale:
    """The scale of a range of colors; neutral: the descriptor's own, NaN if it has none."""
    if is_signed(shown):
        return signed_scale(shown.neutral, max(shown.maximum - shown.neutral, shown.neutral - shown.minimum))
    share = (neutral - shown.minimum) / (shown.maximum - shown.minimum) if np.isfinite(neutral) else 0.0
    return Scale(shown.minimum, shown.maximum, round(WHOLE * min(max(share, 0.0), 1.0)))


def is_signed(shown: ValueRange) -> bool:
    """Returns whether a range puts its neutral value at the middle of the pixels."""
    return shown.diverging and shown.neutral is not None


def signed_scale(neutral: float, half: float) -> Scale:
    """The scale with the neutral value at the middle pixel, and neutral + half at the last one."""
    return Scale(neutral - half * MIDDLE / (WHOLE - MIDDLE), neutral + half, MIDDLE)


def leveled(image: np.ndarray, scale: Scale, shown: ValueRange) -> Pixels:
    """Pixels of (N, N, 1) values, changed by brightness, contrast and inversion as colors are."""
    levels = shown.levels
    if levels == Levels():
        return pixels_of(image, scale)
    signed = is_signed(shown)
    low = scale.low + (scale.high - scale.low) / WHOLE if signed else scale.low  # the same steps on both sides

    def change(rows: slice) -> None:
        share = np.clip((image[rows] - np.float32(low)) / np.float32(scale.high - low), 0, 1)
        image[rows] = low + (scale.high - low) * levels.applied(share, signed)

    in_bands(change, len(image))
    outside = MIDDLE if signed else round(WHOLE * float(levels.applied(np.array([scale.outside / WHOLE]), False)[0]))
    return pixels_of(image, replace(scale, outside=outside, levels=levels))


def gutter_of(size: int) -> int:
    """The width in texels of the gutter around charts in a texture of this side."""
    return max(LEAST_GUTTER, size // SMALLEST_CLEAN)


def pixels_of(image: np.ndarray, scale: Scale) -> Pixels:
    """Pixels of (N, N, 1 or 3) float32 values, NaN off the surface. The image is overwritten."""
    counts = np.sum(in_bands(lambda rows: to_places(image[rows], scale), len(image)), axis=0)
    covered = counts[0] / image[:, :, 0].size
    dark, bright = (float(count) for count in counts[1:] / max(counts[0], 1))
    image = filled_around(image, gutter_of(len(image)))
    known = np.empty(image.shape[:2], bool)
    values = np.empty(image.shape, np.uint16)

    def finish(rows: slice) -> None:
        part = image[rows]
        known[rows] = part[:, :, 0] > 0
        rounded = np.rint(part - 1)
        rounded[~known[rows]] = scale.outside
        values[rows] = rounded

    in_bands(finish, len(image))
    return Pixels(values, known, float(covered), dark, bright, scale)


def to_places(part: np.ndarray, scale: Scale) -> tuple[int, int, int]:
    """Replaces values by their pixel plus 1, so that 0 is nothing; counts those there, nearly black and white."""
    part -= np.float32(scale.low)
    part *= np.float32(WHOLE / (scale.high - scale.low))
    np.clip(part, 0, WHOLE, out=part)
    part += 1
    first = part[:, :, 0]
    there = np.count_nonzero(first > 0)
    dark = there - np.count_nonzero(first > 1 + DARK * WHOLE)
    return there, dark, np.count_nonzero(first > 1 + BRIGHT * WHOLE)


def filled_around(image: np.ndarray, gutter: int) -> np.ndarray:
    """The image with its gutter filled, and with 0 further out.

    When a texture is halved until the gutter is one texel wide, interpolation reads two texels around each. So twice
    the gutter is filled: the first texels one by one, the others in squares, which takes a fraction of the time.
    """
    near = bridge.fill_gutter(image, SQUARE)
    squares = mean_squares(near)
    wide = bridge.fill_gutter(squares, -(-2 * gutter // SQUARE))
    size = len(near)

    def fill(rows: slice) -> None:
        part = near[rows]
        of_squares = wide[rows.start // SQUARE : -(-rows.stop // SQUARE)]
        large = of_squares.repeat(SQUARE, axis=0).repeat(SQUARE, axis=1)[: len(part), :size]
        np.copyto(part, large, where=part == 0)

    in_bands(fill, size)
    return near


def mean_squares(image: np.ndarray) -> np.ndarray:
    """The mean of every square of texels over those that are not 0, NaN without any: (ceil(N / 8), ceil(N / 8), c)."""
    size, width = len(image), image.shape[2]
    count = -(-size // SQUARE)
    means = np.empty((count, count, width), np.float32)

    def reduce(rows: slice) -> None:
        part = image[rows]
        room = (-len(part) % SQUARE, count * SQUARE - size)
        if any(room):
            part = np.pad(part, ((0, room[0]), (0, room[1]), (0, 0)))
        squares = part.reshape(-1, SQUARE, count, SQUARE, width)
        total = squares.sum(axis=1).sum(axis=2)
        found = np.count_nonzero(squares, axis=1).sum(axis=2).astype(np.float32)
        with np.errstate(invalid="ignore"):
            means[rows.start // SQUARE : rows.start // SQUARE + len(total)] = total / found

    in_bands(reduce, size)
    return means


def in_bands(work: Callable[[slice], Result], size: int) -> list[Result]:
    """The results of work for bands of rows, computed on several threads."""
    return threads.side_by_side(work, [slice(start, min(start + BAND, size)) for start in range(0, size, BAND)])
