"""Solids of cubes with corners and edges exactly on the rim of balls: rounding must not decide what a ball contains."""

import numpy as np
import pytest

import paradesc

STEPS = 4  # along an edge of a cube
CUBES = {
    "one": [(0, 0, 0)],
    "corner": [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
    "steps": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1), (2, 1, 1)],
}
TURN, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))


def solid(cubes):
    """Vertices and triangles of a solid of unit cubes."""
    numbers, faces = {}, []
    for cube in cubes:
        for axis in range(3):
            across, along = np.roll(np.eye(3, dtype=int), -1 - axis, axis=0)[:2]
            for side in (0, 1):
                step = np.eye(3, dtype=int)[axis]
                if tuple(np.add(cube, (2 * side - 1) * step)) in cubes:
                    continue
                for i, j in np.ndindex(STEPS, STEPS):
                    first = STEPS * (np.array(cube) + side * step) + i * across + j * along
                    quad = [tuple(first + a * across + b * along) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                    corners = [numbers.setdefault(place, len(numbers)) for place in quad[:: 2 * side - 1]]
                    faces += [corners[:3], [corners[0], *corners[2:]]]
    return np.array(list(numbers)) / STEPS, faces


@pytest.mark.parametrize("name", CUBES)
def test_curvature_does_not_jump_where_corners_lie_on_the_rim(name):
    vertices, faces = solid(CUBES[name])
    turned = vertices @ (TURN * np.linalg.det(TURN)).T
    for steps in ((3, 4, 0), (4, 0, 4), (4, 1, 4), (5, 0, 1), (6, 0, 3), (2, 5, 0), (5, 4, 1)):
        radius = np.linalg.norm(steps) / STEPS
        below, there, above = (
            radius * paradesc.compute(turned, faces, radius=radius * share, radius_unit="absolute")["mean_curvature"]
            for share in (1 - 1e-5, 1, 1 + 1e-5)
        )
        goes_on = np.abs(below - above) < 1e-3  # elsewhere, another part of the surface comes into the ball
        assert goes_on.mean() > 0.5
        assert np.abs(there - above)[goes_on].max() < 1e-3
