"""A mesh as it stands in the world: scaled, sheared, mirrored. No Blender needed."""

import numpy as np
import pytest

from paradesc import bridge
from paradesc.core import job, spaces
from shapes import RADIUS, as_arrays, cube_sphere

AXES = np.array([1.3, 1.0, 0.7])
SETTINGS = job.Settings(
    ("mean_curvature", "gaussian_curvature", "shape_index", "principal_direction_max"),
    bridge.Options(radius=0.05, buffer_size=256, samples=128),
    "software",
)


def matrix_of(linear, place=(5.0, -3.0, 2.0)):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, place
    return matrix


def rotation(seed=3):
    turned = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return turned * np.sign(np.linalg.det(turned))


def arrays_of_sphere():
    points, quads, uvs = cube_sphere(24)
    arrays = as_arrays(points, quads, uvs)
    arrays.corner_normals = (points[quads.ravel()] / RADIUS).astype(np.float32)
    return arrays


def ellipsoid_curvatures(points, axes):
    """H and K of x²/a² + y²/b² + z²/c² = 1 at (n, 3) points, convex positive."""
    gradient = (points**2 / axes**4).sum(axis=1)
    product = np.prod(axes**2)
    mean = ((axes**2).sum() - (points**2).sum(axis=1)) / (2 * product * gradient**1.5)
    return mean, 1 / (product * gradient**2)


@pytest.mark.parametrize("mirror", [1.0, -1.0], ids=["scaled", "mirrored"])
def test_a_sphere_scaled_unevenly_has_the_curvatures_of_an_ellipsoid(mirror):
    arrays = arrays_of_sphere()
    points = arrays.positions.astype(np.float64)
    axes = AXES * [1, 1, mirror]
    spaces.to_world(arrays, matrix_of(rotation() @ np.diag(axes)), "egg")
    results = job.run(arrays, SETTINGS)
    mean, gaussian = ellipsoid_curvatures(points * axes, RADIUS * AXES)
    # The error of a second-order fit over 5 % of the diagonal to a mesh of 24 steps; a wrong sign or scale errs by 30.
    np.testing.assert_allclose(results.values["mean_curvature"], mean, rtol=0.06)
    np.testing.assert_allclose(results.values["gaussian_curvature"], gaussian, rtol=0.12)
    assert results.values["shape_index"].min() > 0.6
    assert results.mesh_report["flipped_triangles"] == 0


def test_own_normals_stay_on_the_outside_of_what_is_scaled_and_mirrored():
    arrays = arrays_of_sphere()
    linear = rotation() @ np.diag(AXES * [1, -1, 1])
    spaces.to_world(arrays, matrix_of(linear), "egg")
    places = arrays.positions[arrays.corner_vertices]
    normals = np.linalg.solve(linear @ linear.T, places.T).T
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(arrays.corner_normals, normals, atol=1e-5)


def test_the_place_of_an_object_does_not_count_so_that_far_away_loses_no_digits():
    near, far = arrays_of_sphere(), arrays_of_sphere()
    spaces.to_world(near, matrix_of(np.diag(AXES), (0, 0, 0)), "egg")
    spaces.to_world(far, matrix_of(np.diag(AXES), (1e6, 0, 0)), "egg")
    assert np.array_equal(near.positions, far.positions)


def test_directions_are_those_of_the_world():
    settings = job.Settings(("principal_direction_max",), SETTINGS.options, "software")
    turned, own = arrays_of_sphere(), arrays_of_sphere()
    turn = rotation()
    spaces.to_world(own, matrix_of(np.diag(AXES)), "egg")
    spaces.to_world(turned, matrix_of(turn @ np.diag(AXES)), "egg")
    first = job.run(own, settings).values["principal_direction_max"] @ turn.T
    second = job.run(turned, settings).values["principal_direction_max"]
    aligned = np.abs((first * second).sum(axis=1))
    assert np.nanmedian(aligned) > 0.999


def test_scaled_to_nothing_is_one_sentence():
    with pytest.raises(bridge.ParadescError, match='"flat" is scaled to nothing'):
        spaces.to_world(arrays_of_sphere(), matrix_of(np.diag([1.0, 1.0, 0.0])), "flat")


def test_displacement_grows_with_an_even_scale_and_refuses_an_uneven_one():
    arrays = arrays_of_sphere()
    tangents = np.tile(np.array([1, 0, 0, -1], np.float32), (len(arrays.corner_vertices), 1))
    arrays.maps = bridge.SurfaceMaps(np.zeros((4, 4), np.float32), scale=0.1, corner_tangents=tangents)
    turn = rotation()
    spaces.to_world(arrays, matrix_of(3 * turn), "ball")
    np.testing.assert_allclose(arrays.maps.scale, 0.3)
    np.testing.assert_allclose(arrays.maps.corner_tangents[0], [*turn[:, 0], -1], atol=1e-6)
    with pytest.raises(bridge.ParadescError, match="cannot follow"):
        spaces.to_world(arrays, matrix_of(np.diag(AXES)), "ball")


def test_mirrored_alike_is_even_and_sheared_is_not():
    assert spaces.is_even(matrix_of(2 * rotation() @ np.diag([1, 1, -1])))
    assert not spaces.is_even(matrix_of(np.eye(3) + 0.1 * np.eye(3, k=1)))
