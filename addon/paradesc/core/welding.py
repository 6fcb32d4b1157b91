"""The distance within which corners of loose triangles are one vertex: rounding moves them that far. Never imports bpy.

The native library goes by the same rule beside open edges (native/src/mesh/weld.h), so that readers need not.
"""

import numpy as np

# Units in the last place at the largest coordinate: about the seventh digit of a decimal.
UNITS = 16
# The largest reach as a part of the shortest edge, so that no edge is welded to a point.
SHARE_OF_EDGE = 0.01


def reach(positions: np.ndarray, triangles: np.ndarray) -> float:
    """The distance up to which positions (n, 3) float32 of triangles (m, 3) are one place."""
    if not len(positions) or not len(triangles):
        return 0.0
    corners = positions[triangles].astype(np.float64)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    shortest = edges.min(where=edges > 0, initial=np.inf)
    return float(min(UNITS * np.finfo(np.float32).eps * np.abs(positions).max(), SHARE_OF_EDGE * shortest))
