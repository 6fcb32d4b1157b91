"""Describes how values are distributed: range, moments, percentiles and a histogram. Never imports bpy."""

import numpy as np

PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
BINS = 64


def statistics(values: np.ndarray) -> dict[str, float | int | None]:
    """The range of (n,) or (n, 3) values, and the number of vertices without a value."""
    finite = values[np.isfinite(values)]
    return {
        "minimum": float(finite.min()) if finite.size else None,
        "maximum": float(finite.max()) if finite.size else None,
        "undefined": int(np.isnan(values.reshape(len(values), -1)).any(axis=1).sum()),
    }


def distribution(values: np.ndarray) -> dict[str, object]:
    """Describes those of (n,) values that are numbers, as plain Python.

    The histogram has equal bins from the first to the last of the percentiles, since a few corners of a mesh can have
    curvatures of any size; what lies outside is counted below and above it.
    """
    finite = values[np.isfinite(values)].astype(np.float64)
    if not finite.size:
        return {"mean": None, "deviation": None, "percentiles": {}, "histogram": None}
    percentiles = np.percentile(finite, PERCENTILES)
    return {
        "mean": float(finite.mean()),
        "deviation": float(finite.std()),
        "percentiles": {str(rank): float(value) for rank, value in zip(PERCENTILES, percentiles, strict=True)},
        "histogram": histogram(finite, float(percentiles[0]), float(percentiles[-1])),
    }


def histogram(values: np.ndarray, minimum: float, maximum: float) -> dict[str, object]:
    """Counts (n,) finite values in equal bins between two values, the last one included, and those outside."""
    inside = values[(values >= minimum) & (values <= maximum)]
    width = (maximum - minimum) / BINS
    place = np.zeros(inside.size, np.int64) if width <= 0 else ((inside - minimum) / width).astype(np.int64)
    counts = np.bincount(np.clip(place, 0, BINS - 1), minlength=BINS)
    below, above = int((values < minimum).sum()), int((values > maximum).sum())
    return {"minimum": minimum, "maximum": maximum, "counts": counts.tolist(), "below": below, "above": above}
