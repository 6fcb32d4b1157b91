"""Levels change textures as they change vertex colors, and each packed channel has the radius of its own mask."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from image_test import bumpy, settings_of
from maps_test import decode16

from paradesc.core import advice, texel_centers
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
    assert radii[1] <= radii[0] < radii[2]  # openness looks at the space around; thin edges have a smaller one
    assert radii[2] / radii[0] == pytest.approx(advice.MASKS["ambient_openness"], rel=0.01)  # of three digits


def test_a_radius_that_was_typed_is_that_of_all_channels():
    fit = partial(texel_centers.fitted, bumpy(8))
    (one,) = image_files.Choice(64, packed=True).runs(settings_of("mean_curvature"), fit)
    assert one.descriptors == image_files.PACKED
    assert one.options.radius == settings_of("mean_curvature").options.radius


def test_several_computations_report_as_one():
    arrays = bumpy(8)
    settings = replace(settings_of("cavity"), radius_fit="medium")
    results = image_files.run("x", arrays, settings, image_files.Choice(32, packed=True)).results
    alone = image_files.run("x", arrays, replace(settings, descriptors=("cavity",)), image_files.Choice(32)).results
    assert results.radius == alone.radius
    assert results.field_report["seconds_total"] > 0
    assert len(results.notes) == len(set(results.notes))


# ---- One scale


def test_several_meshes_have_one_range_on_request(registered, tmp_path):
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    from scene import add_sphere, saved_scene, small_bake

    for name, height in (("smooth", 0.05), ("rough", 0.3)):
        mesh = add_sphere(name, steps=8).data
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        points = points.reshape(-1, 3)
        mesh.vertices.foreach_set("co", (points * (1 + height * np.sin(4 * points[:, :1]))).ravel())
    settings = small_bake("cpu")
    settings.descriptors, settings.texels = {"cavity"}, 64
    saved_scene(tmp_path / "scene.blend")
    for item in bpy.data.objects:
        item.select_set(True)

    def said():
        assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
        files = [tmp_path / f"{name}_cavity.png" for name in ("smooth", "rough")]
        return [decode16(path.read_bytes())[1]["Description"] for path in files]

    one, other = said()
    assert one != other
    bpy.context.scene.paradesc_looks.same_scale = True
    one, other = said()
    assert one == other
    assert image_results_of("rough").seconds > 0


def test_a_mesh_that_fails_leaves_the_others_their_one_range(registered, tmp_path):
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    from scene import add_sphere, saved_scene, small_bake

    for name in ("one", "other", "damaged"):
        add_sphere(name, steps=4)
    bpy.data.meshes["damaged"].clear_geometry()
    settings = small_bake("cpu")
    settings.texels, bpy.context.scene.paradesc_looks.same_scale = 64, True
    saved_scene(tmp_path / "scene.blend")
    for item in bpy.data.objects:
        item.select_set(True)
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    assert sorted(path.name for path in tmp_path.glob("*.png")) == ["one_curvature.png", "other_curvature.png"]


def image_results_of(name):
    import bpy

    from paradesc_blender.scene import image_results

    return image_results.found(bpy.data.objects[name])
