"""Rays from points along normals against a surface, by the native library: numpy arrays in and out, no context."""

from ctypes import byref
from dataclasses import dataclass

import numpy as np

from . import abi
from .arrays import address, shaped
from .library import check, load_library, new_struct
from .session import Call, ProgressFunction


@dataclass(frozen=True)
class Hits:
    """The hits of rays on a surface, one for each ray."""

    triangle_vertices: np.ndarray  # (triangle_count, 3) int32 of the surface
    triangles: np.ndarray  # (n,) int32, -1 for none
    weights: np.ndarray  # (n, 3) float32 of the triangle's corners

    @property
    def missed(self) -> np.ndarray:
        """(n,) bool"""
        return self.triangles < 0

    def apart(self, count: int) -> tuple["Hits", "Hits"]:
        """Splits the hits into those of the first rays, as many as count, and those of the others."""
        first, others = slice(0, count), slice(count, None)
        return tuple(Hits(self.triangle_vertices, self.triangles[i], self.weights[i]) for i in (first, others))

    def values(self, values: np.ndarray) -> np.ndarray:
        """(n,) or (n, 3) float32 at the hits, of values (vertex_count,) or directions (vertex_count, 3)."""
        width = 3 if values.ndim == 2 else 1
        given = shaped(values, np.float32, "values", (-1, 3) if width == 3 else (-1,))
        native = new_struct(abi.RaysInput)
        native.vertex_count, native.triangle_count = len(given), len(self.triangle_vertices)
        native.ray_count = len(self.triangles)
        native.triangle_vertices = address(self.triangle_vertices)
        met = np.empty((len(self.triangles), 3) if width == 3 else len(self.triangles), np.float32)
        triangles, weights = address(self.triangles), address(self.weights)
        source, out = address(given), address(met)
        check(load_library().pdesc_rays_values(byref(native), triangles, weights, source, width, out, met.size))
        return met


def cast_rays(
    positions: np.ndarray,
    triangle_vertices: np.ndarray,
    rays: np.ndarray,
    reach: float,
    progress: ProgressFunction | None = None,
) -> Hits:
    """Each ray's nearest hit, at most reach away, on triangles facing along it; rays: (n, 6) points and directions."""
    points = shaped(positions, np.float32, "positions", (-1, 3))
    numbers = shaped(triangle_vertices, np.int32, "triangle_vertices", (-1, 3))
    given = shaped(rays, np.float32, "rays", (-1, 6))
    native = new_struct(abi.RaysInput)
    native.vertex_count, native.triangle_count, native.ray_count = len(points), len(numbers), len(given)
    native.positions, native.rays = address(points), address(given)
    native.triangle_vertices, native.reach = address(numbers), reach
    hits = Hits(numbers, np.empty(len(given), np.int32), np.empty((len(given), 3), np.float32))
    triangles, weights = address(hits.triangles), address(hits.weights)
    with Call(progress) as native.progress:
        status = load_library().pdesc_rays_cast(byref(native), triangles, weights, len(given))
    check(status)
    return hits
