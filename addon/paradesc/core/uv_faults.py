"""Finds faults that make a UV map unusable for computing. Never imports bpy."""

import numpy as np

# A map is unusable if a smaller share of the triangles than this has an area in it.
LEAST_SHARE_WITH_AREA = 0.01


def fault(uvs: np.ndarray | None, triangle_corners: np.ndarray) -> str:
    """The fault that makes the (corner_count, 2) UV map unusable, worded as "has …", or "" if there is none."""
    if uvs is None:
        return "has no UV map"
    if not np.isfinite(uvs).all():
        return "has a UV map with coordinates that are not finite"
    if len(triangle_corners) and not has_uv_area(uvs, triangle_corners):
        return "has a UV map without area"
    return ""


def with_others(reason: str, sound: list[str]) -> str:
    """The fault, with the names of the mesh's other UV maps if those are usable."""
    if not sound:
        return reason
    names = " and ".join(f'"{name}"' for name in sound)
    return f"{reason} (its other {names} can be used: make it the active one)"


def has_uv_area(uvs: np.ndarray, triangle_corners: np.ndarray) -> bool:
    """Whether enough triangles have an area in the UV map; usually a part of them suffices to tell."""
    needed = LEAST_SHARE_WITH_AREA * len(triangle_corners)
    parts = (triangle_corners[::16], triangle_corners)
    return any(np.count_nonzero(uv_areas(uvs, part)) >= needed for part in parts)


def uv_areas(uvs: np.ndarray, triangle_corners: np.ndarray) -> np.ndarray:
    """(triangle_count,) float64 twice the signed areas in the UV map."""
    first, second, third = (uvs[triangle_corners[:, k]].astype(np.float64) for k in range(3))
    one, other = second - first, third - first
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
