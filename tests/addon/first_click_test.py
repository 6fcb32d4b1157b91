"""The measures of the first click's masks: white, bright and dark shares by area, and the values of flat faces."""

import sys

import numpy as np
import pytest

from shapes import ROOT

pytest.importorskip("bpy", reason="needs Blender")
sys.path.insert(0, str(ROOT / "tests" / "first_click"))
import measures  # noqa: E402

STEPS = 20


def floor_and_wall(steps=STEPS, bend=90.0):
    """Two squares of side 1 that meet at x = 0 by an angle (degrees), in steps x steps quads each."""
    along = np.linspace(0, 1, steps + 1)
    x, y = np.meshgrid(np.linspace(-1, 1, 2 * steps + 1), along)
    turn = np.radians(bend)
    points = np.stack([np.where(x < 0, x, x * np.cos(turn)), y, np.where(x < 0, 0, x * np.sin(turn))], axis=2)
    corner = (np.arange(steps)[:, None] * (2 * steps + 1) + np.arange(2 * steps)).ravel()
    quads = np.stack([corner, corner + 1, corner + 2 * steps + 2, corner + 2 * steps + 1], axis=1)
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    return measures.Surface(points.reshape(-1, 3), triangles, triangles)


def test_points_stand_for_all_of_the_area():
    surface = floor_and_wall()
    for points in (measures.at_corners(surface), measures.evenly(surface, 5000)):
        assert points.areas.sum() == pytest.approx(2.0)  # the sum of thousands of rounded areas
        assert points.weights.min() >= 0
        np.testing.assert_allclose(points.weights.sum(axis=1), 1.0)


def test_points_on_one_large_face_lie_evenly():
    surface = floor_and_wall(steps=1)
    points = measures.evenly(surface, 4000)
    y = points.places(surface)[:, 1]
    # Each tenth of the length has a tenth of the points, up to the discrepancy of some hundred points of a sequence.
    np.testing.assert_allclose(np.histogram(y, 10, (0, 1))[0] / len(y), 0.1, atol=0.01)


def test_shares_are_of_the_area_and_not_of_the_vertices():
    surface = floor_and_wall(steps=1)
    large = measures.Surface(surface.positions * [3, 1, 1], surface.triangles, surface.corners)
    points = measures.at_corners(large)
    on_floor = large.positions[large.triangles].mean(axis=1)[points.triangles, 2] == 0
    found = measures.measured(np.where(on_floor, 0.0, 1.0), points)
    assert (found.bright, found.dark) == (pytest.approx(0.25), pytest.approx(0.75))  # 3 of 4 lie on the floor
    assert found.white == 1.0


def test_white_is_sought_among_what_is_not_black():
    points = measures.at_corners(floor_and_wall())
    values = np.zeros(len(points.areas))
    values[:100] = 0.7
    assert measures.measured(values, points).white == 0.7
    assert "no white" in measures.measured(values, points).faults()


def test_flat_is_what_lies_farther_than_the_radius_from_creases_and_from_open_edges():
    surface = floor_and_wall()
    points = measures.at_corners(surface)
    faces = measures.flat_faces(surface, points, 0.2)
    places = points.places(surface)
    far = np.minimum(np.abs(np.where(places[:, 2] > 0, places[:, 2], places[:, 0])), 1)
    inside = np.minimum.reduce([far, 1 - far, places[:, 1], 1 - places[:, 1]])
    assert (faces[inside > 0.22] >= 0).all()
    assert (faces[inside < 0.2] < 0).all()
    assert len(np.unique(faces[faces >= 0])) == 2


def test_two_planes_that_hardly_bend_are_one_face_and_a_cylinder_has_none():
    assert len(np.unique(measures.flat_faces(floor_and_wall(bend=0.5), measures.at_corners(floor_and_wall()), 0.2))) == 2
    surface = floor_and_wall()
    bent = np.radians(0.9) * STEPS * surface.positions[:, 0]  # 0.9 degree at each of its lines
    rolled = np.stack([np.sin(bent), surface.positions[:, 1], np.cos(bent)], axis=1)
    round_one = measures.Surface(rolled, surface.triangles, surface.corners)
    assert (measures.flat_faces(round_one, measures.at_corners(round_one), 0.05) == -1).all()


def tube(sides, steps=8):
    """The sides of a prism around a circle of radius 1, from y = 0 to 1, in steps x steps quads each."""
    turns = np.repeat(np.arange(sides), steps) + np.tile(np.arange(steps) / steps, sides)
    low, share = np.floor(turns), turns % 1
    corners = [np.stack([np.sin(2 * np.pi * side / sides), np.cos(2 * np.pi * side / sides)]) for side in (low, low + 1)]
    outline = corners[0] * (1 - share) + corners[1] * share
    count = sides * steps
    points = np.stack([np.tile(outline[0], steps + 1), np.repeat(np.arange(steps + 1) / steps, count), np.tile(outline[1], steps + 1)], axis=1)
    here = np.arange(count * steps).reshape(steps, count)
    quads = np.stack([here, np.roll(here, -1, axis=1), np.roll(here, -1, axis=1) + count, here + count], axis=2).reshape(-1, 4)
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    return measures.Surface(points, triangles, triangles)


@pytest.mark.parametrize(("sides", "flat"), [(4, 4), (6, 6), (8, 0), (12, 0)])
def test_sides_of_a_cylinder_are_no_flat_faces_and_those_of_a_box_are(sides, flat):
    surface = tube(sides)
    faces = measures.flat_faces(surface, measures.evenly(surface, 4000), 0.05)
    assert len(np.unique(faces[faces >= 0])) == flat


def test_a_face_between_two_that_bend_back_and_forth_is_flat():
    surface = floor_and_wall(bend=30.0)
    far = surface.positions[:, 0].max()
    given = surface.positions[surface.triangles]
    turned = given[:, ::-1] * [-1, 1, -1] + [2 * far, 0, 2 * surface.positions[:, 2].max()]  # by half a turn about the wall's end
    corners = np.concatenate([given, turned]).reshape(-1, 3)
    whole = measures.Surface(corners, *(2 * [np.arange(len(corners)).reshape(-1, 3)]))
    faces = measures.flat_faces(whole, measures.at_corners(whole), 0.1)
    assert len(np.unique(faces[faces >= 0])) == 3


def test_a_face_that_is_seen_at_one_vertex_alone_tells_nothing():
    surface = floor_and_wall(steps=2)  # of each square, one vertex lies in the middle, where six triangles meet
    assert (measures.flat_faces(surface, measures.at_corners(surface), 0.2) == -1).all()


def test_the_brightest_flat_face_counts():
    surface = floor_and_wall()
    points = measures.at_corners(surface)
    faces = measures.flat_faces(surface, points, 0.2)
    values = np.where(points.places(surface)[:, 2] > 0, 0.3, 0.01)
    found = measures.measured(values, points, faces)
    assert found.on_flat == pytest.approx(0.3)
    assert "flat faces are not black" in found.faults()
