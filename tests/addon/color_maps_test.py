"""Colors: where they start, where they are neutral, and what range they span."""

import math

import numpy as np
import pytest

from paradesc import color_maps
from paradesc.bridge import Descriptor

SIGNED = Descriptor("h", "H", "", -1, True, 0.0, math.nan, math.nan)
UNSIGNED = Descriptor("c", "C", "", -1, False, 0.0, math.nan, math.nan)
FIXED = Descriptor("s", "S", "", 0, True, math.nan, -1.0, 1.0)
AROUND_HALF = Descriptor("v", "V", "", 0, True, 0.5, math.nan, math.nan)


def lightness(display):
    """OKLab's L of (n, 3) display colors."""
    linear = color_maps.srgb_to_linear(display)
    to_cones = np.array(
        [
            [0.4122214708, 0.5363325363, 0.0514459929],
            [0.2119034982, 0.6806995451, 0.1073969566],
            [0.0883024619, 0.2817188376, 0.6299787005],
        ]
    )
    return np.cbrt(linear @ to_cones.T) @ np.array([0.2104542553, 0.7936177850, -0.0040720468])


def test_diverging_map_is_blue_white_red():
    blue, white, red = color_maps.diverging(np.array([0.0, 0.5, 1.0]))
    assert blue[2] > blue[0] + 0.3
    assert red[0] > red[2] + 0.3
    assert white.min() > 0.94
    assert np.ptp(white) < 0.01


def test_diverging_map_darkens_evenly_to_both_sides():
    light = lightness(color_maps.diverging(np.linspace(0, 1, 101)))
    np.testing.assert_allclose(light, light[::-1], atol=0.01)
    np.testing.assert_allclose(np.diff(light[:51]), np.diff(light[:51]).mean(), atol=1e-3)


def test_sequential_map_grows_lighter_throughout():
    steps = np.diff(lightness(color_maps.sequential(np.linspace(0, 1, 101))))
    assert (steps > 0).all()
    assert steps.max() < 2 * steps.min() + 0.005


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
    assert color_maps.value_range(np.array([0.1, 0.2]), FIXED, 0.1) == color_maps.ValueRange(-1.0, 1.0, True)


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
