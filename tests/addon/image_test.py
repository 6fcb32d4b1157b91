"""Textures: what their pixels mean, that no seam shows when they are halved, and where fewer centers are enough."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from maps_test import decode16

from conftest import real_mesh
from paradesc import bridge
from paradesc.core import color_maps, job, texel_centers
from paradesc.core.color_maps import Look, ValueRange
from paradesc.files import image_files, maps, mask_image, png
from paradesc.files.results import Baked
from shapes import ROOT, as_arrays, cube_sphere

if str(ROOT / "tests" / "bench") not in sys.path:
    sys.path.insert(0, str(ROOT / "tests" / "bench"))

from sampling_choices import read_obj

NONE = np.float32(np.nan)
QUICK = bridge.Options(radius=0.08, samples=32)


def settings_of(*names, options=QUICK, backend="cpu"):
    """Settings with which textures take a moment."""
    return job.Settings(names, options, backend)


def bumpy(steps=16):
    """The sphere of six charts with hollows and bumps."""
    points, quads, uvs = cube_sphere(steps)
    return as_arrays(points * (1 + 0.12 * np.sin(3 * points[:, :1]) * np.cos(2 * points[:, 1:2])), quads, uvs)


def uvs_of(arrays):
    """(triangle_count, 3, 2) of the mesh's UV map."""
    return arrays.corner_uvs[arrays.triangle_corners]


def looked_up(image, uvs):
    """Bilinear (n,) values of an image (N, N) with rows from v = 0 up, at (n, 2)."""
    size = len(image)
    place = np.clip(uvs * size - 0.5, 0, size - 1)
    low = np.minimum(np.floor(place).astype(int), size - 2)
    (x, y), (a, b) = low.T, (place - low).T
    below = image[y, x] * (1 - a) + image[y, x + 1] * a
    return below * (1 - b) + (image[y + 1, x] * (1 - a) + image[y + 1, x + 1] * a) * b


def decoded(pixels, scale):
    """The values that pixels stand for."""
    return scale.low + (scale.high - scale.low) * pixels / 65535.0


# ---- Pixels


@pytest.mark.parametrize("neutral", [0.0, 0.5, -3.0])
@pytest.mark.parametrize("ends", [(-1.0, 1.0), (-0.25, 2.0), (-40.0, 7.0)])
def test_neutral_is_one_half_to_the_bit_and_both_sides_have_the_same_steps(neutral, ends):
    shown = ValueRange(neutral + ends[0], neutral + ends[1], True, neutral)
    scale = mask_image.scale_of(shown, neutral)
    half = max(-ends[0], ends[1])
    values = np.float32([neutral, neutral + half, neutral - half, neutral + 2 * half, neutral + half / 2])
    image = np.repeat(values[:, None, None], 40, axis=1).repeat(8, axis=0)
    found = mask_image.pixels_of(image, scale).values[::8, 0, 0]
    assert found[:4].tolist() == [32768, 65535, 1, 65535]
    assert scale.outside == 32768
    assert decoded(32768, scale) == pytest.approx(neutral, abs=1e-12)
    assert decoded(found[4], scale) == pytest.approx(neutral + half / 2, abs=half / 32767)


def test_values_without_sign_go_from_their_minimum_to_their_maximum():
    scale = mask_image.scale_of(ValueRange(0.0, 2.0, False, None), 0.0)
    image = np.float32([[0.0, 2.0, 1.0, -1.0, 3.0, 0.5]] * 6)[:, :, None]
    assert mask_image.pixels_of(image, scale).values[0, :, 0].tolist() == [0, 65535, 32768, 0, 65535, 16384]
    assert (scale.low, scale.high, scale.outside) == (0.0, 2.0, 0)
    assert mask_image.scale_of(ValueRange(1.0, 2.0, False, None), 0.0).outside == 0
    assert mask_image.scale_of(ValueRange(1.0, 2.0, False, None), NONE).outside == 0


@pytest.mark.parametrize("name", ["mean_curvature", "cavity", "ambient_openness", "shape_index", "curvedness"])
@pytest.mark.parametrize("look", [Look(), Look(ranges={"": (-0.5, 3.0)}), Look(percentile=10.0)], ids=str)
def test_pixels_span_the_range_of_the_colors(name, look):
    row, values = job.registry_row(name), np.random.default_rng(1).normal(0.4, 0.3, 500)
    shown = color_maps.value_range(values, row, 0.1, look)
    scale = mask_image.scale_of(shown, row.neutral_value)
    if row.is_signed:
        assert (scale.low + scale.high) / 2 == pytest.approx(shown.neutral, abs=1e-4 * (scale.high - scale.low))
        assert max(shown.maximum - shown.neutral, shown.neutral - shown.minimum) == scale.high - shown.neutral
    else:
        assert (scale.low, scale.high) == (shown.minimum, shown.maximum)


@pytest.mark.parametrize("size", [64, 250, 256, 1024])
def test_the_gutter_is_filled_and_ends(size):
    image = np.full((size, size, 1), NONE)
    chart = slice(size // 2, size // 2 + 5)
    image[chart, chart] = 1.0
    scale = mask_image.signed_scale(0.0, 2.0)
    pixels = mask_image.pixels_of(image, scale)
    steps = np.maximum(size // 2 - np.arange(size), np.arange(size) - size // 2 - 4)
    away = np.maximum(steps[:, None], steps[None])
    gutter = mask_image.gutter_of(size)
    assert gutter == max(8, size // 128)
    assert pixels.filled[away <= 2 * gutter].all()
    assert not pixels.filled[away > 2 * gutter + 32].any()
    assert set(np.unique(pixels.values[pixels.filled])) == {round(32768 + 32767 * 0.5)}
    assert set(np.unique(pixels.values[~pixels.filled])) <= {32768}


# ---- Seams


def halved(image):
    """The next level of a mipmap."""
    return image.reshape(len(image) // 2, 2, len(image) // 2, 2).mean(axis=(1, 3))


def levels(pixels):
    """The texture, and its halves down to the one in which the gutter is one texel."""
    found, gutter = [pixels[:, :, 0].astype(np.float64)], mask_image.gutter_of(len(pixels))
    while gutter > 1:
        found.append(halved(found[-1]))
        gutter //= 2
    return found


def inside(arrays, count=4):
    """(triangle_count, k, 3) weights and the UVs there, the triangles' borders included: all of the charts."""
    steps = np.array([(a, b) for a in range(count + 1) for b in range(count + 1 - a)]) / count
    weights = np.column_stack([steps, 1 - steps.sum(axis=1)])
    return weights, np.einsum("kc,tcd->tkd", weights, uvs_of(arrays).astype(np.float64))


@pytest.mark.parametrize("size", [256, 512, 2048])
def test_what_is_level_on_all_charts_is_level_on_every_level_of_the_mipmap(size):
    arrays = bumpy(6)
    values = np.ones(len(arrays.positions), np.float32)
    scale = mask_image.signed_scale(0.0, 1.25)
    drawn = bridge.draw_uv_image(uvs_of(arrays), arrays.triangle_vertices, values, size)
    pixels = mask_image.pixels_of(drawn, scale)
    expected = round(32768 + 32767 * 0.8)
    _, places = inside(arrays)
    found = levels(pixels.values)
    assert len(found) == 1 + int(np.log2(mask_image.gutter_of(size)))
    for level in found:
        np.testing.assert_allclose(looked_up(level, places.reshape(-1, 2)), expected, atol=1e-6)


def test_both_sides_of_a_seam_look_alike_on_every_level_of_the_mipmap():
    arrays, size = bumpy(16), 1024
    arrays.corner_uvs = 0.6 * arrays.corner_uvs + np.float32(0.05)
    wave = np.sin(0.5 * arrays.positions @ np.float32([1.0, 0.7, 0.4])).astype(np.float32) + 3
    drawn = bridge.draw_uv_image(uvs_of(arrays), arrays.triangle_vertices, wave, size)
    scale = mask_image.signed_scale(0.0, 4.0)
    pixels = mask_image.pixels_of(drawn, scale).values
    vertices, uvs = arrays.corner_vertices, arrays.corner_uvs.astype(np.float64)
    for number, level in enumerate(levels(pixels)):
        at_corners = decoded(looked_up(level, uvs), scale)
        least, most = np.full(len(wave), np.inf), np.full(len(wave), -np.inf)
        np.minimum.at(least, vertices, at_corners)
        np.maximum.at(most, vertices, at_corners)
        # A texel of this level is 2^number of the 184 along a chart, in which the wave changes by up to 2.
        change = 0.01 + 2.0 * 2**number / 184
        assert (most - least).max() < change
        np.testing.assert_allclose(at_corners, wave[vertices], atol=change)


# ---- Files


@pytest.fixture(scope="module")
def made():
    """The bumpy sphere with all that is packed, and mean curvature."""
    arrays = bumpy()
    arrays.corner_uvs = 0.6 * arrays.corner_uvs + np.float32(0.05)  # which leaves room around the gutters
    results = job.run(arrays, texel_centers.with_texels(settings_of("mean_curvature", *image_files.PACKED), 96))
    return Baked("x", results, arrays, np.eye(4))


def test_a_texture_says_what_its_pixels_stand_for(made):
    encoded = image_files.encoded([(made, "mean_curvature")], 96)
    (scale,) = encoded.scales
    pixels, texts = decode16(encoded.content)
    assert texts == {"Description": scale.meaning("mean_curvature", "1/length")}
    image = maps.drawn(maps.user_uvs(made), 96, made, "mean_curvature")[::-1]
    surface = np.isfinite(image)
    kept = np.clip(image[surface], scale.low, scale.high)
    np.testing.assert_allclose(decoded(pixels[surface], scale), kept, atol=(scale.high - scale.low) / 65535)


def test_packed_channels_are_those_of_textures_of_their_own(made):
    together, _ = decode16(image_files.encoded([(made, name) for name in image_files.PACKED], 96).content)
    assert together.shape == (96, 96, 3)
    for channel, name in enumerate(image_files.PACKED):
        alone, _ = decode16(image_files.encoded([(made, name)], 96).content)
        assert np.array_equal(together[:, :, channel], alone[:, :, 0])
    four, texts = decode16(
        image_files.encoded([(made, name) for name in (*image_files.PACKED, "mean_curvature")], 96, True).content
    )
    assert np.array_equal(four[:, :, :3], together)
    assert [part.split(":")[0] for part in texts["Description"].split("; ")] == ["R", "G", "B", "A"]


@pytest.mark.parametrize("names", [["mean_curvature"], list(image_files.PACKED)], ids=len)
def test_outside_is_neutral_or_transparent(made, names):
    size = 512
    solid, _ = decode16(image_files.encoded([(made, name) for name in names], size).content)
    clear, _ = decode16(image_files.encoded([(made, name) for name in names], size, transparent=True).content)
    assert np.array_equal(clear[:, :, :-1], solid)
    assert set(np.unique(clear[:, :, -1])) == {0, 65535}
    outside = clear[:, :, -1] == 0
    assert 0.3 < outside.mean() < 0.6
    neutral = {"mean_curvature": 32768, "cavity": 0, "convexity": 0, "ambient_openness": 32768}
    for channel, name in enumerate(names):
        assert set(np.unique(solid[:, :, channel][outside])) == {neutral[name]}


def test_what_has_no_value_on_the_surface_is_neutral(made):
    values = made.results.values["mean_curvature"].copy()
    values[:40] = NONE
    results = replace(made.results, values={"mean_curvature": values}, maps={})
    pixels = image_files.drawn(replace(made, results=results), "mean_curvature", 96)
    lonely = np.isin(made.arrays.triangle_vertices, np.arange(40)).all(axis=1)
    center = uvs_of(made.arrays)[lonely].mean(axis=1)
    assert lonely.any()
    places = (center * 96).astype(int)
    assert (pixels.values[places[:, 1], places[:, 0], 0] == 32768).all()


@pytest.mark.parametrize("shape", [(1, 1, 1), (700, 30, 1), (513, 20, 4), (256, 3, 3), (300, 40, 2)])
def test_a_texture_that_is_packed_quickly_holds_the_same(shape):
    image = np.random.default_rng(3).integers(0, 65536, shape).astype(np.uint16)
    read, texts = decode16(png.encode_png(image, {"Title": "x"}, quick=True))
    assert np.array_equal(read, image)
    assert texts == {"Title": "x"}


def test_names_are_those_of_substance_and_engines():
    names = ("mean_curvature", "cavity", "convexity", "ambient_openness", "curvedness", "mean_curvature_r0.02")
    words = ["curvature", "cavity", "edges", "openness", "curvedness", "curvature_r0.02"]
    assert [image_files.word_of(name) for name in names] == words


# ---- Centers


def test_charts_lie_apart_in_the_map_of_centers_and_triangles_stay_in_order():
    arrays = bumpy(8)
    apart = texel_centers.with_charts_apart(arrays)
    assert np.array_equal(apart.triangle_vertices, arrays.triangle_vertices)
    uvs = uvs_of(apart)
    chart = np.tile(np.repeat(np.arange(6), 64), 2)
    boxes = [(uvs[chart == k].min(axis=(0, 1)), uvs[chart == k].max(axis=(0, 1))) for k in range(6)]
    for k, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[k + 1 :]:
            assert np.maximum(other_low - high, low - other_high).max() > 2.4 / texel_centers.LEAST_SIDE


def test_a_small_image_is_evaluated_at_its_own_texels():
    arrays = bumpy(8)
    found, side = texel_centers.centers_for(arrays, settings_of("cavity"), 64)
    assert found is arrays
    assert side == 64


def test_a_large_image_of_a_large_radius_has_fewer_centers():
    arrays = bumpy(8)
    found, side = texel_centers.centers_for(arrays, settings_of("cavity"), 4096)
    assert found is not arrays
    assert side < 1024
    smaller = job.Settings(("cavity",), bridge.Options(radius=0.02), more_radii=(0.01,))
    assert texel_centers.centers_for(arrays, smaller, 8192)[1] > 2 * side
    length = texel_centers.least_radius(arrays, settings_of("cavity"))
    same = bridge.Options(radius=length, radius_unit="absolute")
    assert texel_centers.centers_for(arrays, settings_of("cavity", options=same), 4096)[1] == side


def test_each_texel_is_evaluated_on_request():
    arrays = bumpy(8)
    options = replace(QUICK, evaluate="texel")
    few = texel_centers.run(arrays, settings_of("cavity"), 768)
    each = texel_centers.run(arrays, settings_of("cavity", options=options), 768)
    assert few.maps["cavity"].shape < each.maps["cavity"].shape == (768, 768)


def test_values_at_vertices_and_so_the_colors_are_those_of_a_bake():
    arrays, settings = bumpy(8), settings_of("mean_curvature")
    baked, found = job.run(arrays, settings), texel_centers.run(arrays, settings, 64)
    assert np.array_equal(found.values["mean_curvature"], baked.values["mean_curvature"])
    assert found.field_report["seconds_total"] > 0
    assert found.field_report["places"] > 2000


def test_the_reference_and_texture_space_make_textures_too():
    arrays = bumpy(4)
    options = bridge.Options(radius=0.2, samples=16, buffer_size=128)
    expected, _ = decode16(image_of(arrays, settings_of("mean_curvature", options=options)))
    for backend in ("reference", "software"):
        found, _ = decode16(image_of(arrays, settings_of("mean_curvature", options=options, backend=backend)))
        assert np.abs(found - expected.astype(float)).mean() < 0.05 * 65535


@pytest.mark.parametrize("stacked", [False, True])
def test_stacked_charts_get_a_note(stacked):
    arrays = bumpy(4)
    if stacked:
        arrays.corner_uvs = np.mod(3 * arrays.corner_uvs, [1, 3]).astype(np.float32) / 3
    found = image_files.run("x", arrays, settings_of("cavity"), image_files.Choice(256))
    assert (maps.STACKED in found.results.warnings) == stacked


def image_of(arrays, settings):
    """The bytes of a small texture over a fixed range."""
    choice = image_files.Choice(32, look=Look(ranges={"": (-1.0, 2.0)}))
    (texture,) = image_files.run("x", arrays, settings, choice).made
    return texture.content


def error_of(arrays, settings, size):
    """Mean difference of the pixels from those of evaluating each texel, in percent of white, by descriptor."""
    few = Baked("few", texel_centers.run(arrays, settings, size), arrays, np.eye(4))
    each = Baked("each", job.run(arrays, texel_centers.with_texels(settings, size)), arrays, np.eye(4))
    assert few.results.field_report["places"] < 0.7 * each.results.field_report["places"]
    errors = {}
    for name in settings.descriptors:
        one, other = (maps.drawn(maps.user_uvs(baked), size, baked, name) for baked in (few, each))
        assert np.array_equal(np.isnan(one), np.isnan(other))
        scale = mask_image.scale_of(each.results.shown(name), job.registry_row(name).neutral_value)
        one, other = (np.clip(image, scale.low, scale.high) for image in (one, other))
        errors[name] = 100 * float(np.nanmean(np.abs(one - other))) / (scale.high - scale.low)
    return errors


@pytest.mark.slow
@pytest.mark.parametrize(("name", "radius"), [("human.obj", 0.02), ("spot.obj", 0.05), ("bob.obj", 0.04)])
def test_fewer_centers_make_the_same_image_of_a_real_mesh(name, radius):
    arrays = read_obj(real_mesh(name))
    names = ("mean_curvature", *image_files.PACKED)
    errors = error_of(arrays, settings_of(*names, options=bridge.Options(radius=radius, samples=64)), 1536)
    assert max(errors.values()) < 0.1, errors
