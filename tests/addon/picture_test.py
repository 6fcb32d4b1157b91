"""Pictures: the PNG file, the rasterizer, and a sphere that is where it should be."""

import struct
import sys
import zlib

import numpy as np
import pytest

from paradesc.core import color_maps
from paradesc.files import png
from shapes import ADDON, as_arrays, cube_sphere

sys.path.append(str(ADDON / "manual" / "pictures"))
import draw  # noqa: E402
import lettering  # noqa: E402
import picture  # noqa: E402

SHOWN = color_maps.ValueRange(-1.0, 1.0, True)


def decode(content):
    """(height, width, 3) of a PNG file whose rows are differences from the row above; every checksum is verified."""
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    place, chunks = 8, []
    while place < len(content):
        (length,) = struct.unpack(">I", content[place : place + 4])
        kind, body = content[place + 4 : place + 8], content[place + 8 : place + 8 + length]
        (checksum,) = struct.unpack(">I", content[place + 8 + length : place + 12 + length])
        assert checksum == zlib.crc32(kind + body)
        chunks.append((kind, body))
        place += 12 + length
    assert [kind for kind, _ in chunks] == [b"IHDR", b"IDAT", b"IEND"]
    width, height, depth, color, *rest = struct.unpack(">IIBBBBB", chunks[0][1])
    assert (depth, color, rest) == (8, 2, [0, 0, 0])
    rows = np.frombuffer(zlib.decompress(chunks[1][1]), np.uint8).reshape(height, 1 + 3 * width)
    assert (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height, width, 3)


def test_png_holds_the_image(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    png.write_png(tmp_path / "a.png", image)
    assert np.array_equal(decode((tmp_path / "a.png").read_bytes()), image)


@pytest.mark.parametrize("image", [np.zeros((2, 2, 3)), np.zeros((2, 2), np.uint8), np.zeros((2, 2, 5), np.uint8)])
def test_png_refuses_what_is_no_image(image):
    with pytest.raises(ValueError, match="uint8"):
        png.encode_png(image)


def test_pixel_belongs_to_the_triangle_around_its_center():
    screen = np.array([[1.0, 1.0, 1.0], [7.0, 1.0, 1.0], [1.0, 7.0, 1.0]])
    shown = picture.rasterize(screen, np.array([[0, 1, 2]]), 8).reshape(8, 8)
    x, y = np.meshgrid(np.arange(8) + 0.5, np.arange(8) + 0.5)
    assert np.array_equal(shown == 0, (x >= 1) & (y >= 1) & (x + y <= 8))


def test_nearest_triangle_is_shown_whatever_the_order():
    screen = np.array([[0, 0, 0.5], [8, 0, 0.5], [0, 8, 0.5], [0, 0, 0.9], [8, 0, 0.9], [0, 8, 0.9]], float)
    for triangles, nearest in (([[0, 1, 2], [3, 4, 5]], 1), ([[3, 4, 5], [0, 1, 2]], 0)):
        shown = picture.rasterize(screen, np.array(triangles), 8)
        assert set(shown) == {-1, nearest}


def test_degenerate_and_outside_triangles_draw_nothing():
    screen = np.array([[1, 1, 1], [5, 5, 1], [3, 3, 1], [100, 100, 1], [110, 100, 1], [100, 110, 1]], float)
    assert (picture.rasterize(screen, np.array([[0, 1, 2], [3, 4, 5]]), 8) == -1).all()


def test_many_chunks_show_the_same_as_one(monkeypatch):
    arrays = as_arrays(*cube_sphere(6))
    _, screen = picture.project(arrays.positions, arrays.triangle_vertices, 64)
    whole = picture.rasterize(screen, arrays.triangle_vertices, 64)
    monkeypatch.setattr(picture, "PAIRS_AT_ONCE", 50)
    assert np.array_equal(picture.rasterize(screen, arrays.triangle_vertices, 64), whole)


def test_sphere_fills_a_disk_without_holes():
    arrays = as_arrays(*cube_sphere(20))
    _, screen = picture.project(arrays.positions, arrays.triangle_vertices, 200)
    shown = (picture.rasterize(screen, arrays.triangle_vertices, 200) >= 0).reshape(200, 200)
    rows, columns = np.nonzero(shown)
    assert 0.85 * 200 < np.ptp(rows) <= 200
    assert abs(rows.mean() - 99.5) < 2
    assert abs(columns.mean() - 99.5) < 2
    for row in shown[rows.min() : rows.max()]:
        inside = np.flatnonzero(row)
        assert len(inside) == np.ptp(inside) + 1


def test_camera_stands_in_front_right_and_above():
    right, up, back = picture.camera_axes()
    np.testing.assert_allclose(np.stack([right, up, back]) @ np.stack([right, up, back]).T, np.eye(3), atol=1e-12)
    assert back[1] < 0 < back[0]
    assert back[2] > 0
    assert up[2] > 0.5


@pytest.mark.slow
def test_picture_shows_red_above_and_blue_below():
    arrays = as_arrays(*cube_sphere(20))
    colors = color_maps.colors(np.sign(arrays.positions[:, 2]), SHOWN)
    image = picture.compose(arrays.positions, arrays.triangle_vertices, [picture.View(colors, "sign", SHOWN)])
    assert image.shape == (picture.PANEL + picture.LEGEND, picture.PANEL, 3)
    top, bottom = (
        image[picture.PANEL // 4, picture.PANEL // 2].astype(int),
        image[3 * picture.PANEL // 4, picture.PANEL // 2],
    )
    assert top[0] > top[2] + 50
    assert bottom[2] > bottom[0] + 50


def test_light_does_not_turn_over_at_the_silhouette():
    # On a coarse sphere, smooth normals of faces at the rim that are seen point away from the viewer.
    arrays = as_arrays(*cube_sphere(3))
    drawn = picture.Drawing(arrays.positions, arrays.triangle_vertices, 100)
    shown = np.zeros((200, 200))
    shown.flat[drawn.pixels] = drawn.shading
    lit = shown[:100, :100]  # the quarter that the light comes from
    assert lit[lit > 0].min() > 0.7
    turned = picture.Drawing(arrays.positions, arrays.triangle_vertices[:, ::-1], 100)
    np.testing.assert_allclose(turned.shading, drawn.shading, atol=1e-6)


@pytest.mark.slow
def test_views_stand_side_by_side():
    arrays = as_arrays(*cube_sphere(4))
    colors = np.full((len(arrays.positions), 3), 0.5)
    views = [picture.View(colors, f"view {number}", SHOWN) for number in range(4)]
    image = picture.compose(arrays.positions, arrays.triangle_vertices, views)
    assert image.shape == (2 * (picture.PANEL + picture.LEGEND), 3 * picture.PANEL, 3)


@pytest.mark.slow
def test_bad_coordinates_do_not_stop_the_picture():
    arrays = as_arrays(*cube_sphere(4))
    arrays.positions[0] = np.nan
    colors = np.full((len(arrays.positions), 3), 0.5)
    image = picture.compose(arrays.positions, arrays.triangle_vertices, [picture.View(colors, "", SHOWN)])
    assert image.min() < 200


@pytest.mark.slow
def test_hundred_thousand_triangles_are_all_drawn():
    arrays = as_arrays(*cube_sphere(92))
    assert len(arrays.triangle_corners) > 100_000
    drawn = picture.Drawing(arrays.positions, arrays.triangle_vertices, picture.PANEL)
    share = len(drawn.pixels) / (picture.PANEL * picture.SUPERSAMPLING) ** 2
    assert 0.6 < share < np.pi / 4


def test_bake_draws_a_view_of_each_descriptor(sphere_obj, tmp_path, monkeypatch):
    monkeypatch.setattr(draw.outputs, "WRITERS", dict(draw.outputs.WRITERS))
    words = ["--descriptors", "mean_curvature,principal_direction_max", "--radius", "0.1", "--samples", "32", "--quiet"]
    assert draw.run(["bake", str(sphere_obj), "--reader", "files", *words, "-o", str(tmp_path / "a.png")]) == 0
    image = decode((tmp_path / "a.png").read_bytes())
    assert image.shape == (picture.PANEL + picture.LEGEND, 2 * picture.PANEL, 3)
    assert image.std() > 10


def test_numbers_are_written_with_ink():
    image = np.full((20, 60, 3), 255, np.uint8)
    lettering.draw_text(image, "-1.5", 2, 2, 2, (0, 0, 0))
    assert (image == 0).any()
    lettering.draw_text(image, "far outside", 500, 500, 2, (0, 0, 0))
    assert lettering.text_width("ab", 2) == 22


def test_legend_of_directions_has_words_and_no_bar():
    area = np.full((picture.LEGEND, picture.PANEL, 3), 237, np.uint8)
    picture.draw_legend(area, picture.View(np.zeros((3, 3)), "principal direction max", None))
    colors = {tuple(color) for color in area.reshape(-1, 3).tolist()}
    assert colors == {(237, 237, 237), picture.INK}


def test_bar_has_the_neutral_color_where_its_number_stands():
    area = np.full((picture.LEGEND, picture.PANEL, 3), 237, np.uint8)
    picture.draw_legend(area, picture.View(np.zeros((3, 3)), "h", color_maps.ValueRange(-1.0, 3.0, True, 0.0)))
    left = (picture.PANEL - 420) // 2
    bar = area[8, left : left + 420].astype(int)
    assert abs(int(bar.min(axis=1).argmax()) - 105) <= 1  # a quarter of the way
    ink = np.flatnonzero((area[22:42] == picture.INK).all(axis=2).any(axis=0))
    assert np.abs(ink - (left + 105)).min() <= 4
