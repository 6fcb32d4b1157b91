"""Presets, ours and the user's own; and what every field of the settings says of itself."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc import bridge  # noqa: E402
from paradesc.core import devices, members  # noqa: E402
from paradesc.files import preset_rules  # noqa: E402
from paradesc_blender.settings import presets, properties  # noqa: E402
from paradesc_blender.ui import settings_panel  # noqa: E402
from scene import add_sphere, attribute_values, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def settings():
    return bpy.context.scene.paradesc


@pytest.mark.parametrize("name", presets.PRESETS)
def test_a_preset_bakes_what_it_is_for(settings, name):
    target = add_sphere()
    assert bpy.ops.paradesc.preset(name=name) == {"FINISHED"}
    settings.backend, settings.samples, settings.buffer_size = "software", 64, 512
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    for descriptor in presets.PRESETS[name].settings["descriptors"]:
        assert np.isfinite(attribute_values(target.data, descriptor)).all()
    assert presets.PARADESC_MT_presets.bl_label == presets.PRESETS[name].name


def test_a_preset_takes_back_all_others_but_leaves_device_object_and_output(settings):
    settings.estimator, settings.more_radii, settings.samples = "integral", "3, 4", 777
    settings.backend, settings.space, settings.image_path = "reference", "world", "//mine.exr"
    bpy.ops.paradesc.preset(name="curvature")
    assert (settings.estimator, settings.more_radii, settings.samples) == ("shape-operator", "", 256)
    assert (settings.backend, settings.space, settings.image_path) == ("reference", "world", "//mine.exr")
    assert settings.descriptors == {"mean_curvature", "gaussian_curvature"}


def test_every_preset_says_what_it_is_for_and_names_only_settings_there_are():
    for preset in presets.PRESETS.values():
        assert len(preset.purpose) > 30
        assert set(preset.settings) <= set(preset_rules.rules()["settings"])


# ---- Fields


def test_every_field_has_a_name_and_says_what_it_is(settings):
    for group in members.GROUPS:
        for name in group():
            field = settings.bl_rna.properties[name]
            assert field.name, name
            assert len(field.description) > 8, name
            assert not field.description.endswith("."), name
            for item in getattr(field, "enum_items", []):
                assert item.description, (name, item.identifier)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("radius_percent", "percent"),
        ("radius_absolute", "length"),
        ("radius_edges", "mean edge length"),
        ("map_sigma", "multiples of the radius"),
        ("harris_k", "without unit"),
        ("corner_threshold", "percent"),
        ("buffer_size", "Texels"),
        ("adaptive", "angle"),
    ],
)
def test_numbers_say_their_unit(settings, name, unit):
    assert unit in settings.bl_rna.properties[name].description


def test_options_of_operators_and_further_radii_reach_the_computation(settings):
    settings.descriptors = {"harris"}
    settings.map_descriptor, settings.map_sigma, settings.harris_k = "curvedness", 0.5, 0.06
    settings.corner_threshold, settings.radius_percent, settings.more_radii = 10.0, 2.0, " 3 , 4.5 "
    made = properties.job_settings(settings)
    assert (made.options.map_descriptor, made.options.map_sigma) == ("curvedness", 0.5)
    np.testing.assert_allclose([made.options.harris_k, made.corner_threshold], [0.06, 0.1], rtol=1e-6)
    np.testing.assert_allclose(made.more_radii, [0.03, 0.045])
    assert made.value_names() == ["harris_r0.02", "harris_r0.03", "harris_r0.045"]
    settings.radius_unit = "mean-edge"
    assert properties.job_settings(settings).more_radii == (3.0, 4.5)


@pytest.mark.parametrize("words", ["wide", "3, -1", "0", "nan", "3 4"])
def test_further_radii_that_are_none_are_one_sentence(settings, words):
    settings.more_radii = words
    with pytest.raises(bridge.ParadescError, match="More Radii is not a positive number"):
        properties.job_settings(settings)


def test_further_radii_become_attributes_of_their_own(settings):
    target = add_sphere()
    small_bake()
    settings.more_radii = "12"
    bpy.ops.paradesc.bake()
    assert {"mean_curvature_r0.08", "mean_curvature_r0.12"} <= set(target.data.attributes.keys())


def test_maps_to_choose_from_are_descriptors_of_the_surface_with_one_component(settings):
    items = {item.identifier for item in settings.bl_rna.properties["map_descriptor"].enum_items}
    assert "sphere_volume_normalized" in items
    assert not items & {"harris", "laplacian", "principal_direction_max"}


def test_groups_of_the_panel_hold_the_whole_registry_once():
    shown = [row.name for _, rows in settings_panel.descriptor_groups() for row in rows]
    assert sorted(shown) == sorted(row.name for row in bridge.descriptors())


def test_a_radius_is_shown_as_a_length_of_the_scene(settings):
    target = add_sphere()
    scene = bpy.context.scene
    scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", 1.0
    target.scale = (3.0, 3.0, 3.0)
    bpy.context.view_layer.update()
    settings.radius_unit, settings.radius_absolute = "absolute", 0.1
    assert settings_panel.radius_words(scene, settings, target) == "= 30 cm"
    scene.unit_settings.scale_length = 0.1
    assert settings_panel.radius_words(scene, settings, target) == "= 3 cm"
    settings.space = "world"
    assert settings_panel.radius_words(scene, settings, target) == ""
    settings.radius_unit, settings.radius_percent = "diagonal", 10.0
    scene.unit_settings.system = "NONE"
    np.testing.assert_allclose(
        float(settings_panel.radius_words(scene, settings, target)[2:]), 1.2 * np.sqrt(3), rtol=1e-3
    )
    target.scale = (3.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    assert settings_panel.radius_words(scene, settings, target) == ""


# ---- Devices


def test_devices_there_are_can_be_chosen_and_missing_ones_say_why(settings):
    rows = devices.found()
    assert {row.backend for row in rows} == {"gpu", "software", "reference", "cpu"}
    assert all(row.name or row.missing for row in rows)
    for row in rows:
        bpy.ops.paradesc.choose_device(backend=row.backend, index=row.index)
        assert (settings.backend, settings.device_index) == (row.backend, row.index)
        assert devices.label_of(row.backend, row.index) == row.label
        assert row.missing.rstrip(".") in devices.about(row.backend)
    assert devices.label_of("auto", -1) == "Automatic"
    assert devices.label_of("gpu", 12) == "Graphics Card 12"
