"""Colors: where they start, where they are neutral, and what range they span."""

import math

import numpy as np
import pytest

from paradesc.bridge import Descriptor
from paradesc.core import color_maps
from paradesc.core.color_maps import Look

SIGNED = Descriptor("h", "H", "", -1, True, 0.0, math.nan, math.nan)
UNSIGNED = Descriptor("c", "C", "", -1, False, 0.0, math.nan, math.nan)
FIXED = Descriptor("s", "S", "", 0, True, math.nan, -1.0, 1.0)
AROUND_HALF = Descriptor("v", "V", "", 0, True, 0.5, math.nan, math.nan)


EVERY_MAP = pytest.mark.parametrize("row", color_maps.MAPS.values(), ids=lambda row: row.name)


def oklab(display):
    """(n, 3) OKLab of (n, 3) display colors."""
    linear = color_maps.srgb_to_linear(display)
    to_cones = np.array(
        [
            [0.4122214708, 0.5363325363, 0.0514459929],
            [0.2119034982, 0.6806995451, 0.1073969566],
            [0.0883024619, 0.2817188376, 0.6299787005],
        ]
    )
    to_lab = np.array(
        [
            [0.2104542553, 0.7936177850, -0.0040720468],
            [1.9779984951, -2.4285922050, 0.4505937099],
            [0.0259040371, 0.7827717662, -0.8086757660],
        ]
    )
    return np.cbrt(linear @ to_cones.T) @ to_lab.T


EVEN_MAPS = pytest.mark.parametrize(
    "row", [row for row in color_maps.MAPS.values() if row.name != "grey"], ids=lambda row: row.name
)


def test_grey_is_the_value_itself_to_shaders():
    shares = np.linspace(0, 1, 101)
    found = color_maps.linear_rgba(color_maps.MAPS["grey"].function(shares))
    np.testing.assert_allclose(found[:, :3], np.repeat(shares[:, None], 3, axis=1), atol=1e-6)  # 32-bit floats


@EVEN_MAPS
def test_equal_steps_of_values_are_equal_steps_to_the_eye(row):
    """viridis is uniform in another space (CAM02-UCS), from which OKLab differs by a quarter. The formulas differ only
    by rounding at the edge of what screens can show.
    """
    lab = oklab(row.function(np.linspace(0, 1, 201)))
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    assert steps.max() / steps.min() < (1.4 if row.name == "viridis" else 1.15)
    assert 201 * steps.mean() > 0.5  # and the whole way is long


@EVEN_MAPS
def test_lightness_changes_evenly_and_never_turns_but_in_the_middle(row):
    light = oklab(row.function(np.linspace(0, 1, 201)))[:, 0]
    for half in (light[:101], light[100:]):
        steps = np.diff(half)
        assert (np.sign(steps) == np.sign(steps[0])).all()
        assert np.abs(steps).max() / np.abs(steps).min() < (1.5 if row.name == "viridis" else 1.15)
    if not row.diverging:
        assert light[-1] > light[0] + 0.5


@EVERY_MAP
def test_two_sides_of_a_diverging_map_are_equally_far_from_its_middle(row):
    if row.diverging:
        lab = oklab(row.function(np.linspace(0, 1, 101)))
        away = np.linalg.norm(lab - lab[50], axis=1)
        np.testing.assert_allclose(away, away[::-1], atol=0.01)


@EVERY_MAP
def test_undefined_is_no_color_of_the_map(row):
    colors = row.function(np.linspace(0, 1, 201))
    assert np.linalg.norm(oklab(colors) - oklab(np.array([row.undefined])), axis=1).min() > 0.05


def test_default_maps_are_viridis_and_blue_white_red():
    blue, white, red = color_maps.colors(np.array([-1.0, 0.0, 1.0]), color_maps.ValueRange(-1, 1, True))
    assert blue[2] > blue[0] + 0.3
    assert red[0] > red[2] + 0.3
    assert white.min() > 0.94
    assert np.ptp(white) < 0.01
    first, last = color_maps.colors(np.array([0.0, 1.0]), color_maps.ValueRange(0, 1, False))
    np.testing.assert_allclose([first, last], [color_maps.VIRIDIS[0], color_maps.VIRIDIS[-1]], atol=1e-6)


def test_named_map_is_taken_whatever_the_sign():
    shown = color_maps.value_range(np.linspace(-1, 1, 100), SIGNED, 0.1, Look(color_map="grey"))
    colors = color_maps.colors(np.linspace(-1, 1, 50), shown)
    assert np.ptp(colors, axis=1).max() < 1e-3  # no hue
    assert (np.diff(colors[:, 0]) >= 0).all()


def test_fixed_range_comes_before_everything_else():
    look = Look(ranges={"": (0.0, 4.0), "h": (-3.0, 1.0)}, percentile=10)
    values = np.linspace(-100, 100, 1000)
    assert color_maps.value_range(values, SIGNED, 0.1, look).minimum == -3.0
    for row in (UNSIGNED, FIXED):
        shown = color_maps.value_range(values, row, 0.1, look)
        assert (shown.minimum, shown.maximum) == (0.0, 4.0)


def test_neutral_value_keeps_the_middle_color_in_a_lopsided_range():
    shown = color_maps.value_range(np.zeros(3), SIGNED, 0.1, Look(ranges={"": (-1.0, 3.0)}))
    low, neutral, up, high = color_maps.colors(np.array([-1.0, 0.0, 1.0, 3.0]), shown)
    assert neutral.min() > 0.94  # white
    assert low[2] > low[0]  # blue
    assert up[0] > up[2]  # red
    lab = oklab(np.array([low, neutral, up, high]))
    distance = np.linalg.norm(lab - lab[1], axis=1)
    np.testing.assert_allclose(distance[[0, 2]], distance[3] / 3, rtol=0.03)  # as far by color as by value


def test_own_neutral_value_moves_the_middle_and_the_symmetry():
    shown = color_maps.value_range(np.linspace(0, 3, 1001), SIGNED, 0.1, Look(neutral=1.0, percentile=0))
    np.testing.assert_allclose([shown.minimum, shown.maximum], [-1.0, 3.0])
    assert color_maps.colors(np.array([1.0]), shown).min() > 0.94


def test_percentile_is_what_is_left_out_on_either_side():
    values = np.linspace(0, 100, 1001)
    shown = color_maps.value_range(values, UNSIGNED, 0.1, Look(percentile=10))
    np.testing.assert_allclose([shown.minimum, shown.maximum], [10, 90])
    shown = color_maps.value_range(values, UNSIGNED, 0.1, Look(percentile=0))
    np.testing.assert_allclose([shown.minimum, shown.maximum], [0, 100])
    shown = color_maps.value_range(np.linspace(-0.5, 0.1, 1001), FIXED, 0.1, Look(percentile=0))
    np.testing.assert_allclose([shown.minimum, shown.maximum], [-0.5, 0.5])  # not the registry's -1 to 1


def test_asymmetric_range_is_that_of_the_values():
    shown = color_maps.value_range(np.linspace(-1, 3, 1001), SIGNED, 0.1, Look(percentile=0, symmetric=False))
    np.testing.assert_allclose([shown.minimum, shown.maximum, shown.neutral], [-1, 3, 0])


@pytest.mark.parametrize("shown", [color_maps.ValueRange(-1, 1, True), color_maps.ValueRange(0, 1, False)])
def test_undefined_is_mid_grey_and_infinite_too(shown):
    colors = color_maps.colors(np.array([np.nan, np.inf, 0.0]), shown)
    np.testing.assert_allclose(colors[:2], 0.5)
    assert np.abs(colors[2] - 0.5).max() > 0.1


def test_colors_are_float32_in_the_unit_cube():
    values = np.linspace(-5, 5, 100, dtype=np.float32)
    for diverging in (True, False):
        colors = color_maps.colors(values, color_maps.ValueRange(-1, 1, diverging))
        assert colors.dtype == np.float32
        assert colors.shape == (100, 3)
        assert colors.min() >= 0
        assert colors.max() <= 1


def test_signed_range_is_symmetric_about_zero_and_leaves_outliers_out():
    values = np.concatenate([np.linspace(-1, 3, 1000), [1e6, -1e6, np.nan]])
    shown = color_maps.value_range(values, SIGNED, 0.1)
    assert shown.diverging
    assert shown.minimum == -shown.maximum
    assert 2.7 < shown.maximum < 3.0


def test_signed_range_is_symmetric_about_a_neutral_value_that_is_not_zero():
    shown = color_maps.value_range(np.linspace(0.4, 0.9, 1000), AROUND_HALF, 0.1)
    np.testing.assert_allclose(shown.minimum + shown.maximum, 1.0)
    np.testing.assert_allclose(shown.maximum, np.percentile(np.linspace(0.4, 0.9, 1000), 97.5))


def test_unsigned_range_is_the_percentiles():
    values = np.linspace(10, 20, 1001)
    shown = color_maps.value_range(values, UNSIGNED, 0.1)
    assert not shown.diverging
    np.testing.assert_allclose([shown.minimum, shown.maximum], [10.25, 19.75])


def test_fixed_range_ignores_the_values():
    assert color_maps.value_range(np.array([0.1, 0.2]), FIXED, 0.1) == color_maps.ValueRange(-1.0, 1.0, True, 0.0)


def test_rounding_on_a_plane_stays_neutral():
    noise = np.array([1e-7, -2e-7, 3e-8])
    colors = color_maps.colors(noise, color_maps.value_range(noise, SIGNED, 0.1))
    assert colors.min() > 0.94


@pytest.mark.parametrize("row", [SIGNED, UNSIGNED, FIXED, AROUND_HALF])
@pytest.mark.parametrize("values", [np.full(5, np.nan), np.zeros(5), np.full(5, 7.0), np.zeros(0)])
def test_range_never_is_empty(row, values):
    shown = color_maps.value_range(values, row, 0.1)
    assert shown.maximum > shown.minimum
    assert np.isfinite(color_maps.colors(values, shown)).all()


def test_linear_and_display_values_are_each_others_inverse():
    display = np.linspace(0, 1, 300).reshape(-1, 3)
    np.testing.assert_allclose(color_maps.linear_to_srgb(color_maps.srgb_to_linear(display)), display, atol=1e-7)
    rgba = color_maps.linear_rgba(display)
    assert rgba.shape == (100, 4)
    assert (rgba[:, 3] == 1).all()
    np.testing.assert_allclose(color_maps.srgb_to_linear(np.array([0.5])), 0.21404, atol=1e-5)


def test_colors_of_attributes_are_linear():
    rgba = color_maps.linear_rgba(np.array([[0.5, 0.0, 1.0], [0.04, 1.0, 0.5]]))
    np.testing.assert_allclose(rgba, [[0.21404, 0, 1, 1], [0.04 / 12.92, 1, 0.21404, 1]], atol=1e-5)
