"""Charts are packed into the unit square, apart from each other and unchanged in shape."""

import numpy as np
import pytest

from paradesc.core import packing


def quads_apart(sizes):
    """Quads (n,) of widths and heights (n, 2) that share no vertex, all at the origin of the layout."""
    unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    uvs = (unit[None] * np.asarray(sizes, np.float32)[:, None]).reshape(-1, 2)
    return uvs, np.arange(len(uvs), dtype=np.int32), np.full(len(sizes), 4)


def strip(count):
    """A row of quads that hang together: uvs, corner vertices, sizes."""
    vertices = np.array([[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(count)], np.int32).ravel()
    places = np.array([[k // 2, k % 2] for k in range(2 * count + 2)], np.float32)
    return places[vertices], vertices, np.full(count, 4)


def test_faces_that_share_corners_are_one_chart():
    uvs, vertices, sizes = strip(1000)
    assert set(packing.charts(uvs, vertices, sizes)) == {0}


def test_faces_are_apart_where_the_layout_cuts_between_them():
    uvs, vertices, sizes = strip(10)
    uvs[20:, 0] += 0.5
    chart = packing.charts(uvs, vertices, sizes)
    assert len(set(chart[:20])) == len(set(chart[20:])) == 1
    assert chart[0] != chart[20]


def test_faces_of_different_sizes_are_read_in_a_row():
    uvs = np.array([[0, 0], [1, 0], [0, 1], [1, 0], [1, 1], [0, 1], [0, 2], [9, 9], [8, 9], [9, 8]], np.float32)
    vertices = np.array([0, 1, 2, 1, 3, 2, 4, 0, 3, 4], np.int32)
    chart = packing.charts(uvs, vertices, np.array([3, 4, 3]))
    assert chart.tolist() == [0] * 7 + [1] * 3


@pytest.mark.parametrize("count", [1, 2, 7, 100, 2000, 60000])
def test_boxes_keep_their_gutters_in_the_unit_square(count):
    extent = np.random.default_rng(count).uniform(0.1, 3.0, (count, 2))
    gutter = min(packing.GUTTER, packing.LARGEST_GUTTER_SHARE / np.sqrt(count))
    low, scale = packing.place(extent, gutter)
    high = low + scale * extent
    assert low.min() >= gutter - 1e-9
    assert high.max() <= 1 - gutter + 1e-9
    assert (scale * extent).prod(axis=1).sum() > 0.25  # of the square is surface
    for start in range(0, count, max(1, count // 50)):
        gap = np.maximum(low - high[start], low[start] - high).max(axis=1)
        gap[start] = gutter
        assert gap.min() >= gutter - 1e-9


def test_charts_keep_their_shapes_and_common_scale():
    sizes = [(1, 2), (3, 1), (0.5, 0.5), (2, 2)]
    uvs, vertices, counts = quads_apart(sizes)
    packed = packing.pack(uvs, vertices, counts).reshape(-1, 4, 2)
    assert packed.dtype == np.float32
    extent = packed[:, 2] - packed[:, 0]
    np.testing.assert_allclose(extent / sizes, np.full((4, 2), extent[0, 0]), rtol=1e-4)
    np.testing.assert_allclose(packed[:, 1, 1], packed[:, 0, 1])


def test_long_chart_and_chart_without_area_are_packed():
    uvs, vertices, counts = quads_apart([(1000, 0.001), (0, 0), (1, 1)])
    packed = packing.pack(uvs, vertices, counts)
    assert np.isfinite(packed).all()
    assert packed.min() >= 0
    assert packed.max() <= 1


def test_layout_of_a_single_point_is_packed():
    uvs, vertices, counts = quads_apart([(0, 0)])
    assert np.isfinite(packing.pack(uvs, vertices, counts)).all()
