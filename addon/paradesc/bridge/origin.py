"""Moves meshes near the origin, where 32-bit floats hold their shape, and refuses positions that are not finite.

Every descriptor is the same wherever the mesh is; 32-bit floats far from the origin are not.
"""

import numpy as np

from .library import InputError

LARGEST = float(np.finfo(np.float32).max)
# If rounding moves vertices by a larger share of the mean edge than this, the values show it.
ROUNDING_THAT_SHOWS = 1e-3
# Four bits of the 24 of a float.
VERY_FAR = 16.0


def far_center(points: np.ndarray) -> np.ndarray | None:
    """(3,) float64 middle of (n, 3) positions that lie farther from the origin than they span, else None.

    A few that lie elsewhere do not count if the others are very far: vertices without a face are often left at the
    origin. A sample shows of most meshes that they are not far, as this runs several times for each frame.
    """
    if len(points) == 0:
        return None
    some = np.sort(points[:: len(points) // 64 + 1].astype(np.float64), axis=0)
    few = len(some) // 16
    low, high = some[few], some[-1 - few]
    with np.errstate(over="ignore", invalid="ignore"):  # positions that are not finite are refused by the library
        if not is_far(low, high):
            return None
        ends = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
        if is_far(*ends):
            return ends[0] / 2 + ends[1] / 2
        return low / 2 + high / 2 if is_far(low, high, VERY_FAR) else None


def is_far(low: np.ndarray, high: np.ndarray, times: float = 1.0) -> bool:
    """Returns whether the middle of a box is farther from the origin, along an axis, than so many times its width."""
    return bool(np.abs(low / 2 + high / 2).max() > times * 2 * (high / 2 - low / 2).max())


def near_origin(points: np.ndarray) -> np.ndarray:
    """(n, 3) contiguous float32 positions for the library; those that lie far away are moved to the origin."""
    center = far_center(points)
    if center is not None:
        points = points - center
    with np.errstate(over="ignore", invalid="ignore"):
        if points.dtype != np.float32 and len(points) and np.abs(points).max() > LARGEST:
            raise InputError(f"The mesh reaches {np.abs(points).max():.3g} far, which is more than 32-bit floats hold.")
        return np.ascontiguousarray(points, np.float32)


def stored(points: np.ndarray) -> np.ndarray:
    """(n, 3) float64 positions as float32, unless they lie so far away that this would lose their shape."""
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = points.astype(np.float32)
        return rounded if far_center(points) is None or np.array_equal(rounded, points) else points


def check_finite(points: np.ndarray) -> None:
    """Refuses (n, 3) positions that are not finite."""
    unusable = ~np.isfinite(points).all(axis=1)
    if unusable.any():
        first = int(unusable.argmax())
        sentence = f"Vertex {first} is at ({', '.join(f'{value:g}' for value in points[first])})"
        raise InputError(f"{sentence}; positions have to be finite numbers.")


def rounding_note(points: np.ndarray, mean_edge: float) -> list[str]:
    """A note about precision lost where 32-bit positions (n, 3) lie too far from the origin for their mean edge."""
    if not mean_edge > 0:
        return []
    center = far_center(points)
    is_of_floats = np.array_equal(points.astype(np.float32), points)
    reach = reach_of(points if center is None or is_of_floats else points - center)
    step = float(np.spacing(np.float32(reach)))
    if not step > ROUNDING_THAT_SHOWS * mean_edge or (center is None and is_of_floats):
        return []
    share = f"{step / mean_edge:.2g}"
    if is_of_floats:
        return [
            f"The mesh lies {reach:.3g} from the origin, where 32-bit floats are {step:.2g} apart: its vertices are "
            f"rounded to {share} of the mean edge. Move it to the origin before it is saved so; text, and "
            "a .ply of doubles, keep their digits where --reader files reads them."
        ]
    return [
        f"Parts of the mesh lie {reach:.3g} apart, where 32-bit floats are {step:.2g} apart: vertices are rounded to "
        f"{share} of the mean edge. Compute the parts one by one."
    ]


def reach_of(points: np.ndarray) -> float:
    """The distance from the origin along an axis that few of (n, 3) positions exceed."""
    reaches = np.sort(np.abs(points[:: len(points) // 64 + 1]).max(axis=1))
    return float(reaches[-1 - len(reaches) // 16])


def columns_of(positions: np.ndarray) -> np.ndarray:
    """Turns (n, 3) into (3, n) float32 as the library gets them, each coordinate in a row."""
    return np.ascontiguousarray(near_origin(positions).T)


def place_keys(columns: np.ndarray) -> np.ndarray:
    """(n,) uint64 that are equal if (3, n) positions are, and otherwise only by chance, once in 2^64."""
    bits = (columns + np.float32(0)).view(np.uint32)  # adding zero makes -0 and 0 one
    keys = np.zeros(bits.shape[1], np.uint64)
    for axis in bits:
        keys = (keys ^ axis) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    return keys
