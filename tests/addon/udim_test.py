"""UDIM tiles: which a UV map lies in, how its triangles are cut, and that each tile shows its part of the surface."""

from dataclasses import replace

import numpy as np
import pytest
from image_test import bumpy, settings_of, uvs_of
from maps_test import decode16

from paradesc import bridge
from paradesc.bridge import ParadescError, abi, draw_uv_image
from paradesc.core import job, texel_centers, texel_tiles, transfer, udim
from paradesc.core.color_maps import Look
from paradesc.files import image_files, maps
from paradesc.files.results import Baked
from shapes import as_arrays, cube_sphere

SIX = (1001, 1002, 1003, 1011, 1012, 1013)
SIZE = 64
RIGHT = np.float32([[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]])
# Small enough that fewer centers are never worth it.
SMALL = bridge.Options(radius=0.08, samples=32)


def moved(arrays, scale=(3, 2), move=(0, 0)):
    """The mesh with another UV map; the sphere's six charts then have a tile each."""
    return replace(arrays, corner_uvs=(arrays.corner_uvs * np.float32(scale) + np.float32(move)).astype(np.float32))


def tiles_of(*triangles):
    return udim.tiling_of(np.float32(triangles)).tiles


def made(arrays, *names, size=SIZE, settings=None, **choice):
    """The textures of a mesh."""
    return image_files.run("x", arrays, settings or settings_of(*names), image_files.Choice(size, **choice))


def pixels(textures):
    """The pixels of each tile."""
    return {texture.tile: decode16(texture.content)[0].astype(float) for texture in textures.made}


@pytest.fixture(scope="module")
def six():
    return moved(bumpy(8))


# ---- Which tiles there are


@pytest.mark.parametrize(
    ("square", "tile"), [((0, 1), 1011), ((1, 0), 1002), ((9, 0), 1010), ((3, 2), 1024), ((9, 99), 2000)]
)
def test_a_tile_is_numbered_by_its_column_and_its_row(square, tile):
    assert tiles_of(RIGHT + np.float32(square)) == (tile,)
    assert udim.square_of(tile).tolist() == list(square)


def test_a_map_in_the_first_square_has_no_tiles_and_one_beside_it_has():
    assert tiles_of(RIGHT) == ()
    assert tiles_of(RIGHT, RIGHT + np.float32([1, 0])) == (1001, 1002)
    assert udim.tiling_of(np.zeros((0, 3, 2), np.float32)) == udim.Tiling()


def test_what_only_touches_a_border_or_rounds_over_it_makes_no_tile():
    whole = np.float32([[0, 0], [1, 0], [0, 1]])
    assert tiles_of(whole) == ()
    assert tiles_of(whole * np.float32(1.0006)) == ()
    assert tiles_of(whole, whole * np.float32(1.0006) + np.float32([0, 1])) == (1001, 1011)
    assert tiles_of(whole + np.float32([2, 0])) == (1003,)


def test_a_triangle_lies_in_the_tiles_that_it_covers_and_not_in_all_of_its_box():
    slanted = np.float32([[0.1, 0.1], [2.9, 0.1], [0.1, 1.5]])
    whole = np.float32([[0, 0], [1, 0], [0, 1]])  # most of the map crosses nothing
    tiling = udim.tiling_of(np.stack([slanted, *[whole] * 6]))
    assert tiling.tiles == (1001, 1002, 1003, 1011, 1012)
    assert tiling.crossing == 1
    assert "1 triangle crosses the borders of UDIM tiles" in tiling.notes[0]
    assert udim.tiling_of(np.stack([RIGHT, RIGHT + 1])).notes == []


@pytest.mark.parametrize("move", [(-1, 0), (0, -1), (9, 0), (0, 99)])
def test_what_lies_beside_all_tiles_makes_a_single_image_and_a_sentence(move):
    tiling = udim.tiling_of(np.stack([RIGHT, RIGHT + 1, RIGHT + np.float32(move), RIGHT + np.float32(move) + 1]))
    assert tiling.tiles == ()
    assert tiling.warnings == [udim.OUTSIDE + " All of it was drawn into a single image."]


def test_a_map_in_meters_is_told_without_looking_at_all_of_its_squares(monkeypatch):
    low = 9.0 * np.stack(np.meshgrid(np.arange(40), np.arange(40)), axis=-1).reshape(-1, 1, 2)
    uvs = np.concatenate([low + [[0, 0], [9, 0], [9, 9]], low + [[0, 0], [9, 9], [0, 9]]]).astype(np.float32)
    expected = udim.Tiling(why=udim.OUTSIDE)
    monkeypatch.setattr(udim, "middles", lambda uvs: np.zeros((0, 2), np.int64))
    assert udim.tiling_of(uvs[::40]) == expected, "by all squares"
    monkeypatch.undo()
    monkeypatch.setattr(udim, "meetings", None)
    assert udim.tiling_of(uvs) == expected


def test_a_map_about_the_origin_expects_no_tiles_and_gets_no_sentence():
    assert udim.tiling_of(np.stack([RIGHT - 0.5, RIGHT - 1])) == udim.Tiling()
    assert udim.tiling_of(np.stack([RIGHT, RIGHT * 1e9])) == udim.Tiling()
    assert udim.tiling_of(np.stack([RIGHT, RIGHT * np.float32(np.nan)])) == udim.Tiling(first=True)


def test_a_texture_that_repeats_makes_a_single_image_and_a_sentence():
    assert "more than 100" in udim.tiling_of(RIGHT[None] * 30).why
    grid = np.stack([RIGHT + np.float32([x, y]) for x in range(10) for y in range(11)])
    assert "lies over 110 UDIM tiles" in udim.tiling_of(grid).why
    assert len(udim.tiling_of(grid[:100]).tiles) == 100
    wall = np.float32([[[0, 0], [4, 0], [4, 3]], [[0, 0], [4, 3], [0, 3]]])
    assert udim.tiling_of(wall) == udim.Tiling(why=udim.REPEATS)


# ---- Cutting


def test_the_parts_of_triangles_cover_what_they_covered_with_the_same_values():
    rng = np.random.default_rng(4)
    uvs = rng.uniform(0, 3, (60, 3, 2)).astype(np.float32)
    values = rng.normal(size=180).astype(np.float32)
    corners = np.arange(180, dtype=np.int32).reshape(-1, 3)
    side = 40
    # On one image of 3 x 3 tiles, texels have the same centers.
    expected = draw_uv_image(uvs / 3, corners, values, 3 * side)[:, :, 0]
    for column, row in np.ndindex(3, 3):
        shown = udim.cut(uvs, udim.FIRST + column + 10 * row)
        assert shown.uvs.min() >= 0
        assert shown.uvs.max() <= 1
        found = draw_uv_image(shown.uvs, *shown.values(corners, values), side)[:, :, 0]
        part = expected[row * side : (row + 1) * side, column * side : (column + 1) * side]
        # Rounding decides on which side of a triangle's border a texel's center lies.
        assert np.mean(np.isnan(found) != np.isnan(part)) < 0.002
        close = np.isclose(found, part, atol=1e-4) | np.isnan(found) | np.isnan(part)
        assert np.mean(~close) < 0.002


def test_parts_of_directions_have_no_sign_and_parts_without_a_value_leave_it_to_the_others():
    uvs = np.float32([[[0.5, 0.2], [1.5, 0.2], [0.5, 0.8]]])
    corners = np.int32([[0, 1, 2]])
    shown = udim.cut(uvs, 1002)
    directions = np.float32([[0, 0, 1], [0, 0.6, -0.8], [0, 0, -1]])
    image = draw_uv_image(shown.uvs, *shown.values(corners, directions), 8)
    there = image[np.isfinite(image[:, :, 0])]
    assert len(there) > 3
    np.testing.assert_allclose(np.linalg.norm(there, axis=1), 1, atol=1e-6)
    assert (np.abs(there[:, 2]) > 0.8 - 1e-6).all()  # between the given ones
    lacking = np.float32([np.nan, 5, 5])
    image = draw_uv_image(shown.uvs, *shown.values(corners, lacking), 8)
    assert set(np.unique(image[np.isfinite(image)])) == {5.0}


# ---- Images


def test_the_sphere_has_its_curvature_on_every_tile():
    arrays = moved(as_arrays(*cube_sphere(12)))
    found = made(arrays, "mean_curvature", look=Look(ranges={"": (-1.0, 1.0)}))
    assert [texture.file_name for texture in found.made] == [f"x_curvature.{tile}.png" for tile in SIX]
    for image in pixels(found).values():
        surface = image[4:-4, 4:-4]
        np.testing.assert_allclose(surface, 32768 + 32767 * 0.5, rtol=0.01)  # radius 2, at 32 samples
    assert found.results.warnings == []
    assert found.results.notes == []


def test_a_tile_has_the_bits_of_the_first_tile_of_a_map_in_which_the_others_are_points(six):
    together = made(six, "mean_curvature", "cavity")
    for tile in SIX:
        _, alone = udim.alone(six, tile)
        assert udim.of_mesh(alone).tiles == ()
        single = made(alone, "mean_curvature", "cavity")
        assert [one.content for one in together.made if one.tile == tile] == [one.content for one in single.made]


def test_a_map_in_the_first_tile_makes_the_file_that_it_made():
    arrays = bumpy(8)
    (texture,) = made(arrays, "mean_curvature").made
    results = texel_centers.run(arrays, settings_of("mean_curvature"), SIZE)
    expected = image_files.encoded([(Baked("x", results, arrays, np.eye(4)), "mean_curvature")], SIZE)
    assert texture.content == expected.content
    assert texture.file_name == "x_curvature.png"


def test_tiles_shifted_by_whole_squares_are_the_same_images(six):
    six = replace(six, corner_uvs=np.round(1024 * six.corner_uvs) / np.float32(1024))  # which shifts do not round
    one, other = made(six, "cavity"), made(moved(six, (1, 1), (4, 7)), "cavity")
    assert [texture.tile for texture in other.made] == [tile + 74 for tile in SIX]
    assert [texture.content for texture in other.made] == [texture.content for texture in one.made]


def test_both_sides_of_a_mesh_edge_agree_across_two_tiles():
    side, options = 24, bridge.Options(radius=0.15, samples=64)
    x, y = np.meshgrid(np.linspace(-1, 1, side + 1), np.linspace(-1, 1, side // 2 + 1), indexing="ij")
    points = np.stack([x, y, 0.2 * np.cos(3 * x + 0.6) * np.cos(4 * y)], axis=-1).reshape(-1, 3)
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    cells = np.stack(np.meshgrid(np.arange(side), np.arange(side // 2), indexing="ij"), axis=-1)
    cells = cells.reshape(-1, 1, 2) + corner
    quads, uvs = cells[..., 0] * (side // 2 + 1) + cells[..., 1], cells / (side / 2)
    found = made(as_arrays(points, quads, uvs), settings=settings_of("mean_curvature", options=options), size=128)
    left, right = (image[:, :, 0] for image in pixels(found).values())
    assert [texture.tile for texture in found.made] == [1001, 1002]
    assert found.results.notes == []
    # They are a texel apart, so as alike as the texels beside them on either side.
    step = np.abs(np.diff(left[:, -3:], axis=1)).max() + np.abs(np.diff(right[:, :3], axis=1)).max()
    assert np.abs(left[:, -1] - right[:, 0]).max() < 1.5 * step + 8
    assert np.ptp(left[:, -1]) > 5 * step


def test_a_map_across_borders_shows_the_same_surface():
    arrays = bumpy(8)
    look = Look(ranges={"": (-1.0, 2.0)})
    whole = made(moved(arrays, (2, 2), (0.5, 0.5)), "mean_curvature", look=look)
    assert [texture.tile for texture in whole.made] == [1001, 1002, 1003, 1011, 1012, 1013, 1021, 1022, 1023]
    assert "cross the borders of UDIM tiles" in whole.results.notes[0]
    assert whole.results.warnings == []
    (single,) = made(moved(arrays, (2 / 3, 2 / 3), (1 / 6, 1 / 6)), "mean_curvature", look=look, size=3 * SIZE).made
    expected = decode16(single.content)[0].astype(float)[:, :, 0]
    image = pixels(whole)
    joined = np.block([[image[1001 + column + 10 * row][:, :, 0] for column in range(3)] for row in (2, 1, 0)])
    drawn = draw_uv_image(
        uvs_of(moved(arrays, (2 / 3, 2 / 3), (1 / 6, 1 / 6))),
        arrays.triangle_vertices,
        np.ones(len(arrays.positions), np.float32),
        3 * SIZE,
    )
    surface = np.isfinite(drawn[::-1, :, 0])
    # A tile is looked up in a map whose texels lie elsewhere, so values are those of half a texel away.
    assert np.abs(joined - expected)[surface].mean() < 0.003 * 65535
    assert np.abs(joined - expected)[surface].max() < 0.05 * 65535


def test_the_gutter_of_a_chart_at_a_border_stays_in_its_tile():
    arrays = bumpy(6)
    uvs = uvs_of(arrays)
    # All of it in one half of tile 1002, next to tile 1001, and one triangle in tile 1003.
    small = 0.4 * uvs + np.float32([1.0, 0.3])
    small[0] = 0.2 * RIGHT + np.float32([2.4, 0.4])
    found = made(udim.unshared(arrays, small.astype(np.float32)), "cavity", transparent=True, size=256)
    assert [texture.tile for texture in found.made] == [1002, 1003]
    alpha = pixels(found)[1003][:, :, -1]
    assert 0 < alpha.mean() < 0.3 * 65535


def test_the_range_and_what_is_neutral_are_those_of_all_tiles(six):
    found = made(six, "mean_curvature")
    texts = {decode16(texture.content)[1]["Description"] for texture in found.made}
    assert len(texts) == 1
    assert texts == {decode16(made(bumpy(8), "mean_curvature").made[0].content)[1]["Description"]}
    small = replace(six, corner_uvs=np.float32(0.7) * np.floor(six.corner_uvs) + np.float32(0.3) * six.corner_uvs)
    for image in pixels(made(small, "mean_curvature", size=256, transparent=True)).values():
        assert set(image[image[:, :, 1] == 0][:, 0]) == {32768.0}


def test_packed_channels_of_a_tile_are_those_of_textures_of_their_own(six):
    packed = pixels(made(six, packed=True))
    alone = made(six, *image_files.PACKED)
    for texture in alone.made:
        channel = [image_files.word_of(name) for name in image_files.PACKED].index(texture.name.removeprefix("x_"))
        assert np.array_equal(packed[texture.tile][:, :, channel], decode16(texture.content)[0][:, :, 0])


def test_charts_that_share_a_place_in_a_tile_get_a_note_and_mirrored_ones_none(six):
    stacked = replace(six, corner_uvs=np.mod(six.corner_uvs, [1, 2]).astype(np.float32) + np.float32([1, 0]))
    assert maps.STACKED in made(stacked, "cavity", size=256).results.warnings
    mirrored = replace(six, corner_uvs=np.float32([3, 0]) + six.corner_uvs * np.float32([-1, 1]))
    found = made(mirrored, "cavity", size=256)
    assert found.results.warnings == []
    one = pixels(made(six, "cavity", size=256))
    # A mirrored triangle has other texels on its border, where the value is that of half a texel away.
    assert np.abs(pixels(found)[1003][:, ::-1] - one[1001]).mean() < 0.002 * 65535


# ---- How it is computed


def test_one_map_of_centers_serves_all_tiles_if_it_is_no_larger_than_one(six):
    settings = settings_of("cavity")
    assert texel_tiles.one_by_one(six, settings, 64, exact=False)
    assert not texel_tiles.one_by_one(six, settings, 2048, exact=False)
    assert texel_tiles.one_by_one(six, settings, 2048, exact=True)
    shared = texel_tiles.run(six, settings, 1024, SIX)
    assert shared.tiles is None
    assert shared.maps["cavity"].shape[0] < 1024


@pytest.mark.parametrize("size", [64, 300])
def test_fewer_centers_make_the_same_tiles(six, size):
    assert texel_tiles.one_by_one(six, settings_of("mean_curvature"), size, exact=False) == (size == 64)
    few = made(six, "mean_curvature", size=size)
    exact = settings_of("mean_curvature", options=replace(SMALL, evaluate="texel"))
    each = made(six, settings=exact, size=size)
    for tile, image in pixels(few).items():
        assert np.abs(image - pixels(each)[tile]).mean() < 0.001 * 65535  # as for single images


def test_every_tile_has_centers_of_its_own_where_one_map_would_be_large(six):
    fine = settings_of("cavity", options=replace(SMALL, radius=0.02))
    assert texel_tiles.one_by_one(six, fine, 900, exact=False)
    results = texel_tiles.run(six, fine, 900, SIX)
    of_tile = results.of_tile(1012)
    assert 512 <= of_tile.maps["cavity"].shape[0] < 900
    assert results.maps == {}
    results.finish_tiles()
    assert results.field_report["places"] > of_tile.field_report["places"]


def test_faces_across_the_border_of_a_tile_are_evaluated_as_finely_as_the_others(six):
    across = moved(six, (1, 1), (0.4, 0.4))
    exact = settings_of("cavity", options=replace(SMALL, evaluate="texel"))
    results = texel_tiles.run(across, exact, SIZE, udim.of_mesh(across).tiles)
    _, alone = udim.alone(across, 1012)
    span = texel_tiles.extent(alone)
    assert 1.05 < span < 1.23  # faces are 0.1125 wide
    assert results.of_tile(1012).maps["cavity"].shape[0] == int(np.ceil(SIZE * span))


def test_texture_space_makes_one_map_for_all_tiles():
    arrays = moved(bumpy(4))
    options = bridge.Options(radius=0.2, samples=16, buffer_size=256)
    look = Look(ranges={"": (-1.0, 2.0)})
    settings = {name: settings_of("mean_curvature", options=options, backend=name) for name in ("cpu", "software")}
    one, other = (pixels(made(arrays, settings=settings[name], look=look, size=48)) for name in ("cpu", "software"))
    for tile in SIX:
        assert np.abs(one[tile] - other[tile]).mean() < 0.05 * 65535
    assert texel_tiles.side_for(48, arrays) == 140  # columns from 0.05 to 2.95
    assert texel_tiles.run(arrays, settings["software"], 48, SIX).maps["mean_curvature"].shape == (140, 140)
    where_asked = replace(settings["software"], options=replace(options, evaluate="texel", texels=48))
    assert texel_tiles.run_where_asked(arrays, where_asked, SIX).maps["mean_curvature"].shape == (140, 140)
    assert texel_tiles.coarser(140, 48, arrays) == []
    (note,) = texel_tiles.coarser(8192, 4096, arrays)
    assert "about 2825 along a side" in note


def test_tiles_of_a_coarse_mesh_take_the_detail_of_a_fine_one():
    low, high = moved(as_arrays(*cube_sphere(5))), as_arrays(*cube_sphere(24))
    parts = [transfer.Part(name, arrays, arrays, np.eye(4)) for name, arrays in (("low", low), ("high", high))]
    choice = image_files.Choice(48, look=Look(ranges={"": (-1.0, 1.0)}))
    found = image_files.run("x", image_files.Onto(parts[0], parts[1:], 0.0), settings_of("mean_curvature"), choice)
    assert [texture.tile for texture in found.made] == list(SIX)
    for image in pixels(found).values():
        np.testing.assert_allclose(image, 32768 + 32767 * 0.5, rtol=0.003)  # that of the fine sphere's vertices
    assert 6 * 42**2 < found.results.transfer.texels <= 6 * 44**2  # charts are 0.9 of 48 texels wide
    assert found.results.transfer.missed == 0
    assert found.results.notes[0].startswith('Measured on "high"')


def test_detail_comes_to_the_same_places_where_faces_cross_borders(monkeypatch):
    def known(arrays, settings, _progress=None, _with_buffers=False):
        found = measured(arrays, settings)
        found.values["mean_curvature"] = np.sin(2 * arrays.positions[:, 0]).astype(np.float32)
        return found

    measured = job.run
    monkeypatch.setattr(job, "run", known)
    low, high = as_arrays(*cube_sphere(5)), as_arrays(*cube_sphere(24))
    look, size = Look(ranges={"": (-1.0, 1.0)}), 48

    def image_of(arrays, side):
        parts = [transfer.Part(name, mesh, mesh, np.eye(4)) for name, mesh in (("low", arrays), ("high", high))]
        choice = image_files.Choice(side, look=look)
        return image_files.run("x", image_files.Onto(parts[0], parts[1:], 0.0), settings_of("mean_curvature"), choice)

    image = pixels(image_of(moved(low, (2, 2), (0.5, 0.5)), size))
    (expected,) = pixels(image_of(moved(low, (2 / 3, 2 / 3), (1 / 6, 1 / 6)), 3 * size)).values()
    joined = np.block([[image[1001 + column + 10 * row][:, :, 0] for column in range(3)] for row in (2, 1, 0)])
    middle = slice(size // 2 + 2, 5 * size // 2 - 2)
    # Texels have the same centers, but for those whose center rounds to another side of a chart's border.
    assert np.mean(np.abs(joined - expected[:, :, 0])[middle, middle] > 0.002 * 65535) < 0.01


def test_progress_never_goes_back_and_a_stop_between_tiles_ends_it(six):
    seen = []

    def note(_stage, fraction):
        seen.append(fraction)
        return True

    settings, choice = settings_of("cavity"), image_files.Choice(SIZE)
    image_files.run("x", six, settings, choice, note)
    assert seen == sorted(seen)
    assert seen[0] < 0.1
    assert seen[-1] > 0.9
    with pytest.raises(ParadescError) as caught:
        image_files.run("x", six, settings, choice, lambda _stage, fraction: fraction < 0.6)
    assert caught.value.status == abi.STATUS_CANCELLED


def test_values_at_vertices_are_those_of_a_bake(six):
    found = texel_tiles.run(six, settings_of("cavity"), SIZE, SIX)
    assert np.array_equal(found.values["cavity"], job.run(six, settings_of("cavity")).values["cavity"])
