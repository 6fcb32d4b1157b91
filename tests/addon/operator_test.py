"""The operator, the settings and the panel, inside Blender without a window."""

from functools import partial

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import paradesc_blender  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.core import job, members  # noqa: E402
from paradesc.core.threads import Worker  # noqa: E402
from paradesc_blender.scene import mesh_io, record, targets  # noqa: E402
from paradesc_blender.settings import properties  # noqa: E402
from paradesc_blender.ui import drawing, report_panel  # noqa: E402
from scene import add_sphere, attribute_values, fingerprint  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def sphere_object():
    made = add_sphere()
    settings = bpy.context.scene.paradesc
    settings.radius_percent, settings.samples, settings.buffer_size = 8.0, 64, 256
    settings.backend = "software"
    return made


def names_of(target):
    """The object's attributes."""
    return {attribute.name for attribute in target.data.attributes}


def test_last_run_says_that_a_radius_shows_facets(sphere_object):
    settings = bpy.context.scene.paradesc
    settings.radius_unit = "mean-edge"
    for radius, said in ((0.5, True), (1.5, False)):
        settings.radius_edges = radius
        assert bpy.ops.paradesc.bake() == {"FINISHED"}
        assert ("0.5 of the mean edge" in record.read(sphere_object.data)["warnings"]) == said


def test_registering_twice_leaves_nothing_behind():
    paradesc_blender.unregister()
    assert not hasattr(bpy.types.Scene, "paradesc")
    assert not hasattr(bpy.types, "PARADESC_OT_bake")
    paradesc_blender.register()
    assert hasattr(bpy.types, "PARADESC_OT_bake")


def test_menu_is_the_native_registry():
    items = bpy.context.scene.paradesc.bl_rna.properties["descriptors"].enum_items
    assert [item.identifier for item in items] == [row.name for row in bridge.descriptors()]
    assert [item.name for item in items] == [row.label for row in bridge.descriptors()]
    assert bpy.context.scene.paradesc.descriptors == {"mean_curvature"}


def test_settings_become_those_of_the_computation():
    group = bpy.context.scene.paradesc
    group.descriptors = {"curvedness", "gaussian_curvature"}
    group.radius_percent, group.samples, group.buffer_size, group.max_jumps = 3.0, 99, 333, 5
    settings = properties.job_settings(group)
    assert settings.descriptors == ("gaussian_curvature", "curvedness")
    np.testing.assert_allclose(settings.options.radius, 0.03, rtol=1e-6)
    assert (settings.options.samples, settings.options.buffer_size, settings.options.max_jumps) == (99, 333, 5)
    group.radius_unit, group.radius_absolute = "absolute", 0.7
    np.testing.assert_allclose(properties.job_settings(group).options.radius, 0.7, rtol=1e-6)
    group.radius_unit, group.radius_edges = "mean-edge", 6.0
    assert properties.job_settings(group).options.radius == 6.0


@pytest.mark.parametrize(
    ("member", "choices"),
    [("backend", bridge.BACKENDS), *((name, choices) for name, (choices, _) in bridge.CHOICES.items())],
)
def test_every_choice_is_known_to_the_bridge(member, choices):
    items = bpy.context.scene.paradesc.bl_rna.properties[member].enum_items
    assert [item.identifier for item in items] == list(choices)


def test_bake_writes_the_values_that_the_job_computes(sphere_object):
    bpy.context.scene.paradesc.descriptors = {"mean_curvature", "curvedness"}
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    expected = job.run(arrays, properties.job_settings(bpy.context.scene.paradesc))
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    for name, values in expected.values.items():
        assert np.array_equal(attribute_values(sphere_object.data, name), values, equal_nan=True)
    assert {"mean_curvature_color", "curvedness_color", "coverage"} <= names_of(sphere_object)


def test_invoking_without_a_window_runs_the_same_steps(sphere_object):
    assert bpy.ops.paradesc.bake("INVOKE_DEFAULT") == {"FINISHED"}
    assert "mean_curvature" in names_of(sphere_object)


def test_bake_in_edit_mode_stays_in_edit_mode(sphere_object):
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert sphere_object.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.isfinite(attribute_values(sphere_object.data, "mean_curvature")).all()


def test_own_normals_are_taken_on_request(sphere_object):
    bpy.context.scene.paradesc.normals = "mesh"
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    np.testing.assert_allclose(attribute_values(sphere_object.data, "mean_curvature"), 0.5, rtol=0.1)


def test_nothing_selected_cannot_be_baked():
    assert targets.obstacle(bpy.context)
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.bake()


def test_missing_library_is_said_before_anything_else(sphere_object, monkeypatch):
    monkeypatch.setattr(bridge, "missing_sentence", lambda: "native library missing – somewhere.")
    assert targets.obstacle(bpy.context).startswith("native library missing")
    assert members.descriptor_items() == [members.NO_DESCRIPTOR]
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.bake()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"descriptors": set()}, "choose at least one"),
        ({"radius_unit": "absolute", "radius_absolute": 1000.0}, "adius"),
    ],
    ids=str,
)
def test_bad_settings_are_one_sentence_and_change_nothing(sphere_object, change, words):
    for name, value in change.items():
        setattr(bpy.context.scene.paradesc, name, value)
    before = fingerprint(sphere_object)
    with pytest.raises(RuntimeError, match=words) as caught:
        bpy.ops.paradesc.bake()
    assert "Traceback" not in str(caught.value)
    assert fingerprint(sphere_object) == before


def test_mesh_with_nan_is_one_sentence_and_changes_nothing(sphere_object):
    sphere_object.data.vertices[3].co.x = float("nan")
    before = fingerprint(sphere_object)
    with pytest.raises(RuntimeError, match="3"):
        bpy.ops.paradesc.bake()
    assert fingerprint(sphere_object) == before


def test_report_lines_tell_the_last_run(sphere_object):
    bpy.ops.paradesc.bake()
    text = "\n".join(report_panel.report_lines(record.read(sphere_object.data)))
    assert "UV islands: 6" in text
    assert "Coverage: " in text
    assert "software" in text
    assert "Memory: about " in text


def test_the_last_run_says_which_values_the_ends_of_the_colors_are(sphere_object):
    bpy.context.scene.paradesc.descriptors = {"cavity", "convexity", "principal_direction_max"}
    bpy.ops.paradesc.bake()
    mesh = sphere_object.data
    stored = record.read(mesh)
    black, white = stored["ranges"]["convexity"]
    lines = report_panel.range_lines(mesh, stored)
    assert f"Edge Wear: colors from {black:.3g} to {white:.3g}" in lines
    assert [line.partition(":")[0] for line in lines] == ["Cavity", "Edge Wear"]
    mesh.attributes.remove(mesh.attributes["cavity"])
    assert [line.partition(":")[0] for line in report_panel.range_lines(mesh, stored)] == ["Edge Wear"]


def test_labels_are_wrapped_without_losing_words():
    sentence = "One sentence that is much longer than the panel is wide, with averylongwordthatfitsnowhereatall."
    lines = drawing.wrapped(sentence, 20)
    assert " ".join(lines) == sentence
    assert all(len(line) <= 20 or " " not in line for line in lines)


def test_worker_gives_results_and_progress(sphere_object):
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    worker = Worker(partial(job.run, arrays, properties.job_settings(bpy.context.scene.paradesc)))
    results = worker.result()
    assert worker.done
    assert 0 < worker.fraction <= 1
    assert np.isfinite(results.values["mean_curvature"]).all()


def test_worker_cancelled_after_its_end_gives_no_results(sphere_object):
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    worker = Worker(partial(job.run, arrays, properties.job_settings(bpy.context.scene.paradesc)))
    worker.result()
    worker.cancel()
    with pytest.raises(bridge.ParadescError):
        worker.result()


def test_cancelled_worker_raises_cancelled(sphere_object):
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    worker = Worker(partial(job.run, arrays, properties.job_settings(bpy.context.scene.paradesc)))
    worker.cancel()
    with pytest.raises(bridge.ParadescError) as caught:
        worker.result()
    assert caught.value.status == bridge.abi.STATUS_CANCELLED
