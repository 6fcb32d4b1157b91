"""Surfaces that were made of voxels are known by their vertices, and small radii on them are warned of."""

import numpy as np
import pytest

import paradesc
from paradesc.core import voxels
from python_api_test import torus

SIZE = 0.05


def crossings(radii, halfway):
    """The points (n, 3) at which a grid's edges cross an ellipsoid: exact, or halfway along the edges."""
    inside = np.arange(-1.2, 1.2, SIZE) + 0.013
    places = np.stack(np.meshgrid(inside, inside, inside, indexing="ij"), -1)
    values = 1 - ((places / radii) ** 2).sum(-1)
    found = []
    for axis in range(3):
        here, there = (np.take(values, part, axis) for part in (range(len(inside) - 1), range(1, len(inside))))
        crossed = (here > 0) != (there > 0)
        start = np.take(places, range(len(inside) - 1), axis)[crossed]
        start[:, axis] += SIZE * (0.5 if halfway else (here / (here - there))[crossed])
        found.append(start)
    return np.concatenate(found)


@pytest.mark.parametrize("radii", [(1, 1, 1), (1, 0.7, 0.4), (1.1, 0.3, 0.3)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("halfway", [True, False])
def test_voxels_are_found_with_their_size(radii, dtype, halfway):
    points = crossings(np.array(radii), halfway).astype(dtype)
    size, has_steps = voxels.made_of(points)
    assert size == pytest.approx(SIZE, rel=1e-3)
    assert has_steps == halfway
    assert voxels.made_of(points * [1, 1, 3])[0] == pytest.approx(3 * SIZE, rel=1e-3)


def test_other_surfaces_are_not_of_voxels():
    grid = np.stack(np.meshgrid(np.arange(60.0), np.arange(50.0), indexing="ij"), -1).reshape(-1, 2)
    blocks = np.stack(np.meshgrid(*3 * [np.arange(12.0)], indexing="ij"), -1).reshape(-1, 3)
    plane, heights = (np.column_stack([grid, height]) for height in (0 * grid[:, 0], np.sin(grid[:, 0] / 9)))
    for points in (torus(96, 40)[0], plane, heights, blocks, np.zeros((0, 3)), np.zeros((50, 3))):
        assert voxels.made_of(points) is None
    turned = crossings(np.ones(3), True) @ np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    assert voxels.made_of(turned) is None


@pytest.fixture
def surfaces(pyvista):
    """Marching cubes of a torus 16 voxels thick: of labels, and of labels that were smoothed."""
    ways = np.arange(-1.7, 1.7, SIZE), np.arange(-1.7, 1.7, SIZE), np.arange(-0.7, 0.7, SIZE)
    x, y, z = np.meshgrid(*ways, indexing="ij")
    image = pyvista.ImageData(dimensions=x.shape, spacing=3 * [SIZE])
    image["labels"] = ((np.hypot(x, y) - 1) ** 2 + z**2 < 0.16).astype(np.float32).ravel(order="F")
    smooth = image.gaussian_smooth(std_dev=1.0, radius_factor=4)
    return [part.contour([0.5], method="marching_cubes").clean().triangulate() for part in (image, smooth)]


@pytest.mark.filterwarnings("ignore:The surface has the steps")
def test_radii_that_show_steps_are_warned_of(surfaces):
    def notes(surface, radius):
        found = paradesc.compute(surface.points, surface.regular_faces, radius=radius, radius_unit="absolute")
        return [line for line in found.warnings if "voxels" in line]

    steps, smooth = surfaces
    (line,) = notes(steps, 4 * SIZE)
    assert line == (
        "The surface has the steps of voxels of 0.05, and values at radii below 6 voxels show them; choose a radius of 0.5, "
        "ten voxels."
    )
    assert notes(steps, 10 * SIZE) == []
    assert notes(smooth, 4 * SIZE) == []  # detail of this size may be real


def test_auto_says_what_it_cannot_know(surfaces):
    _, smooth = surfaces
    with pytest.warns(paradesc.ParadescWarning, match="if these were labels"):
        found = paradesc.compute(smooth.points, smooth.regular_faces, radius="auto")
    assert found.radius < voxels.STEPS * SIZE
