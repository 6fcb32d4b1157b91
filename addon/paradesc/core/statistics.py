"""Sums values up for reports. Never imports bpy."""

import numpy as np


def statistics(values: np.ndarray) -> dict[str, float | int | None]:
    """The range of (n,) or (n, 3) values, and the number of vertices without a value."""
    finite = values[np.isfinite(values)]
    return {
        "minimum": float(finite.min()) if finite.size else None,
        "maximum": float(finite.max()) if finite.size else None,
        "undefined": int(np.isnan(values.reshape(len(values), -1)).any(axis=1).sum()),
    }
