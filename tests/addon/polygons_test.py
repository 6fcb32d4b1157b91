"""Polygons are cut into triangles that cover them once, and leave no vertex on the side of a triangle."""

import numpy as np
import pytest

import paradesc
from paradesc.core import polygons

ARROW = [(0, 0), (2, 2), (0, 1), (-2, 2)]  # concave at the third corner
COMB = [(0, 0), (7, 0), (7, 3), (6, 1), (5, 3), (4, 1), (3, 3), (2, 1), (1, 3)]
NOTCHED = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 1), (0, 2), (0, 1)]  # with corners on straight sides
SPIRAL = [
    (0, 0),
    (6, 0),
    (6, 6),
    (1, 6),
    (1, 2),
    (4, 2),
    (4, 4),
    (3, 4),
    (3, 3),
    (2, 3),
    (2, 5),
    (5, 5),
    (5, 1),
    (0, 1),
]


def area_of(outline):
    """The area of a polygon (k, 2)."""
    x, y = np.array(outline, float).T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


@pytest.mark.parametrize("outline", [ARROW, COMB, NOTCHED, SPIRAL], ids=["arrow", "comb", "notched", "spiral"])
@pytest.mark.parametrize("turned", range(3))
def test_triangles_cover_a_polygon_once_wherever_it_begins_and_lies(outline, turned):
    random = np.random.default_rng(turned)
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    for start in range(len(outline)):
        flat = np.roll(np.array(outline, float), start, axis=0)
        points = flat @ axes[:2] * 1e-3 + axes[2]
        faces = polygons.Polygons(np.arange(len(flat), dtype=np.int32), np.array([len(flat)]))
        found = polygons.triangle_corners(faces, points)
        areas = polygons.turn(*(flat[found[:, k]] for k in range(3))) / 2
        assert len(found) == len(flat) - 2
        assert areas.min() > 1e-6  # none is turned over, and none is a line that would cut a neighbor off
        assert areas.sum() == pytest.approx(area_of(outline))


def test_random_star_shaped_polygons_keep_their_area():
    random = np.random.default_rng(1)
    for size in (5, 6, 9, 40, 200):
        angle = np.sort(random.random((30, size)), axis=1) * 2 * np.pi
        flat = random.uniform(0.2, 1, (30, size, 1)) * np.stack([np.cos(angle), np.sin(angle)], axis=2)
        found = polygons.cut(np.concatenate([flat, np.zeros((30, size, 1))], axis=2))
        areas = np.stack(
            [polygons.turn(*(one[cut[:, k]] for k in range(3))) for one, cut in zip(flat, found, strict=True)]
        )
        exact = [area_of(one) for one in flat]
        star = np.diff(angle, axis=1, append=angle[:, :1] + 2 * np.pi).max(axis=1) < np.pi  # holds the middle
        assert np.abs(areas.sum(axis=1) / 2 - exact)[star].max() < 1e-9
        assert areas[star].min() > -1e-9


def test_a_prism_of_concave_polygons_is_closed():
    box = np.array([[x, y, z] for z in (0, 1) for x, y in SPIRAL], float)
    count = len(SPIRAL)
    sides = [[k, (k + 1) % count, (k + 1) % count + count, k + count] for k in range(count)]
    closed = paradesc.Mesh(box, [list(range(count))[::-1], [*range(count, 2 * count)], *sides])
    assert closed.report["boundary_edges"] == closed.report["nonmanifold_edges"] == 0
    assert closed.report["degenerate_triangles"] == 0
