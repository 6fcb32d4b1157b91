"""Levels change textures as they change vertex colors, and each packed channel has the radius of its own mask."""

from dataclasses import replace

import numpy as np
import pytest
from image_test import bumpy, settings_of
from maps_test import decode16

from paradesc.core import advice, job
from paradesc.core.color_maps import Levels, Look, ValueRange
from paradesc.files import image_files, mask_image

NONE = float("nan")
STRONG = Levels(contrast=0.4, brightness=-0.3, invert=True)


def a_row(*values):
    """A square image of values of which each has a column; the last column is off the surface."""
    image = np.empty((len(values) + 1, len(values) + 1, 1), np.float32)
    image[:, :, 0] = [*values, NONE]
    return image


@pytest.mark.parametrize(
    "levels", [Levels(), Levels(contrast=0.5), Levels(brightness=0.7), Levels(invert=True), STRONG]
)
def test_pixels_of_a_mask_are_the_places_of_its_colors(levels):
    shown = ValueRange(0.1, 0.6, False, map_name="grey", levels=levels)
    values = np.linspace(0.0, 0.7, 15)
    scale = mask_image.scale_of(shown, NONE)
    pixels = mask_image.leveled(a_row(*values), scale, shown)
    np.testing.assert_allclose(pixels.values[0, :-1, 0] / 65535, shown.shares(values), atol=1e-4)  # of 32-bit floats


@pytest.mark.parametrize("levels", [Levels(contrast=0.5), Levels(invert=True), STRONG])
def test_what_has_a_sign_keeps_its_neutral_pixel(levels):
    shown = ValueRange(-2.0, 2.0, True, 0.0, levels=levels)
    values = np.linspace(-3.0, 3.0, 13)
    pixels = mask_image.leveled(a_row(*values), mask_image.scale_of(shown, 0.0), shown)
    np.testing.assert_allclose(pixels.values[0, :-1, 0] / 65535, shown.shares(values), atol=1e-4)
    assert pixels.values[0, 6, 0] == pixels.scale.outside == 32768


def test_outside_has_the_levels_too():
    shown = ValueRange(0.0, 1.0, False, map_name="grey", levels=Levels(invert=True))
    image = np.full((512, 512, 1), NONE, np.float32)
    image[:4, :4] = 0.25
    pixels = mask_image.leveled(image, mask_image.scale_of(shown, 0.0), shown)
    assert (pixels.values[0, 0, 0], pixels.values[-1, -1, 0]) == (round(0.75 * 65535), 65535)


def test_the_file_says_the_range_and_what_changed_the_pixels():
    arrays, choice = bumpy(8), image_files.Choice(64, look=Look(levels=STRONG))
    (plain,) = image_files.run("x", arrays, settings_of("cavity"), image_files.Choice(64)).made
    (changed,) = image_files.run("x", arrays, settings_of("cavity"), choice).made
    said = decode16(plain.content)[1]["Description"]
    assert "before" not in said
    assert decode16(changed.content)[1]["Description"] == f"{said} before brightness -0.3, contrast 0.4, inversion"


# ---- Packed channels


def fitted_alone(arrays, name, size):
    """A texture of one mask at the radius that suits it, and that radius in units of the mesh."""
    settings = replace(settings_of(name), radius_fit="medium")
    made = image_files.run("x", arrays, settings, image_files.Choice(size))
    return decode16(made.made[0].content), made.results.radius


def test_each_packed_channel_has_the_radius_of_its_mask():
    arrays, size = bumpy(8), 64
    settings = replace(settings_of("mean_curvature"), radius_fit="medium")
    (made,) = image_files.run("x", arrays, settings, image_files.Choice(size, packed=True)).made
    pixels, texts = decode16(made.content)
    said, radii = texts["Description"].split("; "), []
    for channel, name in enumerate(image_files.PACKED):
        (alone, about), radius = fitted_alone(arrays, name, size)
        radii.append(radius)
        scale = about["Description"]
        assert said[channel].split(" = ")[0] == f"{'RGB'[channel]}: {name}"
        # Masks of one radius share their samples, of which several descriptors take more.
        np.testing.assert_allclose(pixels[:, :, channel] / 65535, alone[:, :, 0] / 65535, atol=0.02, err_msg=scale)
    assert radii[0] == radii[1] < radii[2]
    assert radii[2] / radii[0] == pytest.approx(advice.MASKS["ambient_openness"], rel=0.01)  # of three digits


def test_a_radius_that_was_typed_is_that_of_all_channels():
    runs = image_files.Choice(64, packed=True).runs(settings_of("mean_curvature"), bumpy(8))
    (one,) = runs
    assert one.descriptors == image_files.PACKED
    assert one.options.radius == settings_of("mean_curvature").options.radius


def test_several_computations_report_as_one():
    arrays = bumpy(8)
    settings = replace(settings_of("cavity"), radius_fit="medium")
    results = image_files.run("x", arrays, settings, image_files.Choice(32, packed=True)).results
    first = job.run(arrays, replace(settings, descriptors=("cavity", "convexity")))
    assert results.radius == first.radius
    assert results.field_report["seconds_total"] > 0
    assert len(results.notes) == len(set(results.notes))
