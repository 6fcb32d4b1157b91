"""Images over a UV map equal, byte for byte, those of a few lines of numpy that define an image."""

import threading

import numpy as np
import pytest

from conftest import real_mesh
from paradesc import bridge
from paradesc.bridge import ParadescError, TexelMap, draw_uv_image, fill_gutter, uv_images


@np.errstate(all="ignore")
def expected_image(uvs, numbers, values, size, texels=None):
    """Draws as draw_uv_image does: triangle after triangle, each over the earlier ones."""
    values = values.reshape(len(values), -1)
    image = np.full((size, size, values.shape[1]), np.nan, np.float32)
    for triangle, corners in enumerate(np.nan_to_num(uvs.astype(np.float64))):
        low = np.floor(corners.min(axis=0))
        tiles = np.clip(np.ceil(corners.max(axis=0)) - low, 1, 16).astype(int)
        for v in range(tiles[1]):
            for u in range(tiles[0]):
                rows, columns, weights = texels_in((corners - (low + np.array([u, v]))) * size, size)
                found = mean(values[numbers[triangle]][None], weights)
                if texels is not None:
                    looked_up = expected_lookup(texels, triangle, weights)
                    found = np.where(np.isfinite(looked_up), looked_up, found)
                image[rows, columns] = found
    return image


def texels_in(corners, size):
    """Rows (k,), columns (k,) and weights (k, 3) of the texels whose centers lie in a triangle, in units of texels."""
    first = np.clip(np.ceil(corners.min(axis=0) - 0.5), 0, size).astype(int)
    last = np.clip(np.floor(corners.max(axis=0) - 0.5), -1, size - 1).astype(int)
    rows, columns = (grid.ravel() for grid in np.mgrid[first[1] : last[1] + 1, first[0] : last[0] + 1])
    (ax, ay), (bx, by), (cx, cy) = ((x - (columns + 0.5), y - (rows + 0.5)) for x, y in corners)
    parts = np.stack([bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx], axis=1)
    weights = parts / (parts[:, :1] + parts[:, 1:2] + parts[:, 2:])
    inside = (weights >= 0).all(axis=1) & (weights > 0).any(axis=1)
    return rows[inside], columns[inside], weights[inside]


def mean(values, weights):
    """(k, c) means of the defined values (k or 1, m, c) by weights (k, m); directions have no sign."""
    values = np.broadcast_to(values, (*weights.shape, values.shape[2])).astype(np.float64)
    defined = np.isfinite(values).all(axis=2)
    values, weights = np.where(defined[:, :, None], values, 0), np.where(defined, weights, 0)
    length = weights.sum(axis=1)
    if values.shape[2] == 3:
        leader = values[np.arange(len(values)), weights.argmax(axis=1)]
        weights = np.where((values * leader[:, None]).sum(axis=2) < 0, -weights, weights)
    total = (values * weights[:, :, None]).sum(axis=1)
    if values.shape[2] == 3:
        length = np.sqrt((total**2).sum(axis=1))
    return np.where(length[:, None] > 1e-9, total / length[:, None], np.nan)


def expected_lookup(texels, triangle, weights):
    """(k, c) bilinear values of the map at the places of the triangle in its layout."""
    side = len(texels.values)
    ringed = np.pad(texels.values.reshape(side, side, -1), ((2, 2), (2, 2), (0, 0)), constant_values=np.nan)
    x, y = (texels.layout[triangle].astype(np.float64) * weights[:, :, None]).sum(axis=1).T * side - 0.5
    left, bottom = np.floor(x + 1e-4), np.floor(y + 1e-4)
    a, b = np.clip(x - left, 0, 1), np.clip(y - bottom, 0, 1)
    shares = np.stack([(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b], axis=1)
    column, row = (np.clip(low, -2, side).astype(int) + 2 for low in (left, bottom))
    values = np.stack([ringed[row + up, column + right] for up in (0, 1) for right in (0, 1)], axis=1)
    return mean(values, np.where(shares > 1e-3, shares, 0))


def expected_gutter(image, steps):
    """Fills the gutter as fill_gutter does; every step looks at all texels."""
    image = image.copy()
    height, width = image.shape[:2]
    for _ in range(steps):
        defined = np.isfinite(image).all(axis=2, keepdims=True)
        padded = np.pad(np.where(defined, image, np.float32(0)), ((1, 1), (1, 1), (0, 0)))
        marked = np.pad(defined.astype(np.float32), ((1, 1), (1, 1), (0, 0)))
        total, count = np.zeros_like(image), np.zeros((height, width, 1), np.float32)
        for y, x in np.ndindex(3, 3):
            total += padded[y : y + height, x : x + width]
            count += marked[y : y + height, x : x + width]
        with np.errstate(all="ignore"):
            image = np.where(~defined & (count > 0), total / count, image)
    return np.where(np.isfinite(image), image, np.float32(0))


def assert_same_bytes(image, expected):
    """Checks that all bits are the same; NaN are equal whatever their bits."""
    assert image.dtype == expected.dtype == np.float32
    assert np.array_equal(np.isnan(image), np.isnan(expected))
    defined = ~np.isnan(expected)
    assert np.array_equal(image[defined].view(np.uint32), expected[defined].view(np.uint32))


def assert_as_expected(uvs, numbers, values, size, texels=None):
    """Checks image and gutter; gives the share of texels that show something."""
    image = draw_uv_image(uvs, numbers, values, size, texels)
    assert_same_bytes(image, expected_image(uvs, numbers, values, size, texels))
    for steps in (0, 1, 8):
        assert_same_bytes(fill_gutter(image, steps), expected_gutter(image, steps))
    return np.isfinite(image).mean()


def some_values(random, count, width):
    """Values of which a tenth are undefined, and some are zeros of either sign."""
    values = random.normal(size=(count, width) if width == 3 else count).astype(np.float32)
    values[random.random(count) < 0.1] = np.nan
    values[random.random(count) < 0.02] = np.inf
    values[random.random(count) < 0.1] = -0.0
    return values


@pytest.mark.parametrize("width", [1, 3])
@pytest.mark.parametrize("size", [1, 2, 33, 65])
def test_triangles_anywhere_are_drawn_to_the_bit(size, width):
    random = np.random.default_rng(size)
    shown = 0.0
    for spread in (0.2, 1.0, 3.0):
        uvs = random.normal(0.5, spread, (12, 3, 2)).astype(np.float32)
        numbers = random.integers(0, 9, (12, 3)).astype(np.int32)
        shown += assert_as_expected(uvs, numbers, some_values(random, 9, width), size)
    assert shown > 0.5


@pytest.mark.parametrize("width", [1, 3])
def test_corners_on_centers_and_triangles_without_area_are_drawn_to_the_bit(width):
    random = np.random.default_rng(3)
    for _ in range(10):
        uvs = (random.integers(0, 33, (20, 3, 2)) / 32).astype(np.float32)  # borders and corners of texels of 16
        uvs[5, 2] = uvs[5, 1]
        uvs[6] = uvs[6, :1]
        uvs[7, 2] = (uvs[7, 0] + uvs[7, 1]) / 2
        numbers = random.integers(0, 30, (20, 3)).astype(np.int32)
        assert assert_as_expected(uvs, numbers, some_values(random, 30, width), 16) > 0.2


def test_coordinates_that_are_none_or_huge_are_drawn_to_the_bit():
    random = np.random.default_rng(4)
    odd = np.float32([np.nan, np.inf, -np.inf, 3.4e38, -1e30, 16777217, 1e-40, -0.0])
    for _ in range(20):
        uvs = random.random((6, 3, 2)).astype(np.float32)
        where = random.random(uvs.shape) < 0.15
        uvs[where] = random.choice(odd, where.sum())
        numbers = random.integers(0, 9, (6, 3)).astype(np.int32)
        assert_as_expected(uvs, numbers, some_values(random, 9, 1), 16)


@pytest.mark.parametrize("width", [1, 3])
@pytest.mark.parametrize("side", [1, 16, 37])
def test_maps_are_looked_up_to_the_bit(side, width):
    random = np.random.default_rng(side)
    shape = (side, side) if width == 1 else (side, side, 3)
    for _ in range(5):
        uvs = random.random((20, 3, 2)).astype(np.float32)
        layout = (random.random((20, 3, 2)) * 1.2 - 0.1).astype(np.float32)
        layout[::2] = uvs[::2]  # centers of texels are centers of texels there
        texels = TexelMap(some_values(random, side * side, width).reshape(shape), layout)
        numbers = random.integers(0, 30, (20, 3)).astype(np.int32)
        assert assert_as_expected(uvs, numbers, some_values(random, 30, width), 16, texels) > 0.3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spot.obj", "fandisk.obj", "human.obj"])
def test_real_meshes_are_drawn_to_the_bit(name):
    uvs, numbers, count = read_obj(real_mesh(name))
    some = slice(0, len(uvs), len(uvs) // 3000 + 1)
    uvs, numbers = uvs[some], numbers[some]
    random = np.random.default_rng(5)
    assert assert_as_expected(uvs, numbers, some_values(random, count, 1), 300) > 0.05
    texels = TexelMap(some_values(random, 90 * 90, 3).reshape(90, 90, 3), np.mod(uvs, 1))
    assert assert_as_expected(3 * uvs - 1, numbers, some_values(random, count, 3), 100, texels) > 0.05


def read_obj(path):
    """UVs (n, 3, 2), vertices (n, 3) of the triangles and the number of vertices; a mesh without UVs takes x and y."""
    rows = [line.split() for line in path.read_text(errors="replace").splitlines()]
    points = np.array([row[1:4] for row in rows if row[:1] == ["v"]], np.float32)
    places = np.array([row[1:3] for row in rows if row[:1] == ["vt"]], np.float32)
    faces = [[corner.split("/") for corner in row[1:]] for row in rows if row[:1] == ["f"]]
    fans = [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]
    vertices = np.array([[int(corner[0]) - 1 for corner in fan] for fan in fans], np.int32)
    if not len(places):
        low, high = points.min(axis=0), points.max(axis=0)
        return ((points - low) / (high - low).max())[vertices][:, :, :2], vertices, len(points)
    return places[np.array([[int(corner[1]) - 1 for corner in fan] for fan in fans])], vertices, len(points)


def test_what_has_no_size_or_another_is_refused_in_one_sentence():
    uvs, numbers, values = np.zeros((2, 3, 2)), np.zeros((2, 3), np.int32), np.zeros(4, np.float32)
    square = np.zeros((2, 2), np.float32)
    for arguments, said in (
        ((uvs[:1], numbers, values, 4), "uvs"),
        ((uvs, numbers[:, :2], values, 4), "triangle_values"),
        ((uvs, numbers, np.zeros((4, 2)), 4), "values"),
        ((uvs, numbers + 4, values, 4), "value 4"),
        ((uvs, numbers, values, 0), "size"),
        ((uvs, numbers, values, -1), "size"),
        ((uvs, numbers, values, 2**40), "number of texels"),
        ((uvs, numbers, values, 4, TexelMap(square[:1], uvs)), "the map"),
        ((uvs, numbers, values, 4, TexelMap(square, uvs[:1])), "the layout"),
    ):
        with pytest.raises(ParadescError, match=said):
            draw_uv_image(*arguments)
    with pytest.raises(ParadescError, match="steps"):
        fill_gutter(np.zeros((2, 2, 1), np.float32), 65)


def test_an_image_without_progress_can_be_interrupted_too(monkeypatch):
    asked = []
    original = uv_images.Call

    def noted(progress):
        assert progress is None
        return original(lambda *_: asked.append(threading.current_thread()) or True)

    monkeypatch.setattr(uv_images, "Call", noted)
    draw_uv_image(np.zeros((1, 3, 2), np.float32), np.zeros((1, 3), np.int32), np.zeros(1, np.float32), 8)
    assert asked
    assert set(asked) == {threading.main_thread()}, "where Ctrl-C is caught"


def test_an_image_that_is_filled_is_another():
    image = np.full((3, 3, 1), np.nan, np.float32)
    image[1, 1] = 2
    assert (bridge.fill_gutter(image, 1) == 2).all()
    assert np.isnan(image).sum() == 8
