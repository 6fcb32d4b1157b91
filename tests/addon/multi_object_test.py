"""One bake of several meshes computes shared ones once, names failures, and writes nothing after Esc."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.bridge import InputError  # noqa: E402
from paradesc.core import job, spaces  # noqa: E402
from paradesc_blender.bake import batch, operators, pieces  # noqa: E402
from paradesc_blender.scene import mesh_io, record, targets  # noqa: E402
from paradesc_blender.ui import panel  # noqa: E402
from scene import add_sphere, attribute_values, fingerprint, select, small_bake  # noqa: E402


@pytest.fixture(autouse=True)
def small(registered):
    small_bake()


@pytest.fixture
def spheres():
    """Two spheres and a third object that shares the first one's mesh, all selected."""
    first, second = add_sphere("first"), add_sphere("second", steps=6)
    third = bpy.data.objects.new("third", first.data)
    bpy.context.collection.objects.link(third)
    third.select_set(True)
    bpy.context.view_layer.objects.active = first
    return first, second, third


@pytest.fixture
def computed(monkeypatch):
    """The numbers of vertices of the meshes that are computed, in order."""
    counts = []
    run = job.run

    def counted(arrays, *others):
        counts.append(len(arrays.positions))
        return run(arrays, *others)

    monkeypatch.setattr(job, "run", counted)
    return counts


def reports(action):
    """The reports of the operator, from a batch that runs as the operator does."""
    made = batch.Batch(bpy.context)
    while not made.done:
        made.step(None)
        action(made)
    return made


def test_every_selected_mesh_is_baked_and_a_shared_one_once(spheres, computed):
    first, second, _ = spheres
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert computed == [len(first.data.vertices), len(second.data.vertices)]
    for target in (first, second):
        np.testing.assert_allclose(attribute_values(target.data, "mean_curvature"), 0.5, rtol=0.1)


def test_values_are_those_of_baking_each_alone(spheres):
    first, second, third = spheres
    bpy.ops.paradesc.bake()
    together = attribute_values(second.data, "mean_curvature")
    for target in (first, third):
        target.select_set(False)
    bpy.context.view_layer.objects.active = second
    second.data.attributes.remove(second.data.attributes["mean_curvature"])
    bpy.ops.paradesc.bake()
    assert np.array_equal(attribute_values(second.data, "mean_curvature"), together)


def test_a_mesh_that_fails_is_named_and_the_others_are_baked(spheres):
    first, second, _ = spheres
    second.data.vertices[3].co.x = float("nan")
    before = fingerprint(second)
    made = reports(lambda _made: None)
    made.finish(bpy.context)
    assert [piece.name for piece in made.written] == ["first"]
    assert pieces.failures(made)[0].startswith('"second": ')
    assert operators.bake_sentence(made).endswith('without "second"')
    assert fingerprint(second) == before
    assert "mean_curvature" in first.data.attributes


def test_a_mesh_that_fails_lets_the_operator_finish(spheres):
    first, second, _ = spheres
    second.data.clear_geometry()
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert "mean_curvature" in first.data.attributes


def test_a_mesh_that_cannot_be_written_does_not_lose_the_others(spheres, monkeypatch):
    first, second, _ = spheres
    places = mesh_io.places

    def full(mesh, *names):
        if mesh == first.data:
            raise InputError("No room.")
        return places(mesh, *names)

    monkeypatch.setattr(mesh_io, "places", full)
    before = fingerprint(first)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert fingerprint(first) == before
    assert "mean_curvature" in second.data.attributes


def test_where_all_fail_every_one_is_named_and_nothing_changes(spheres):
    for target in spheres[:2]:
        target.data.vertices[0].co.x = float("nan")
    before = [fingerprint(target) for target in spheres]
    with pytest.raises(RuntimeError, match=r'(?s)"first".*"second"'):
        bpy.ops.paradesc.bake()
    assert [fingerprint(target) for target in spheres] == before


def test_cancelled_after_the_first_mesh_nothing_of_it_stays(spheres):
    before = [fingerprint(target) for target in spheres]
    made = batch.Batch(bpy.context)
    made.step()
    made.step(None)
    assert made.current == 1
    made.step()
    made.cancel()
    made.close()
    assert made.done
    assert made.cancelled
    assert [fingerprint(target) for target in spheres] == before


def test_progress_is_over_all_meshes_and_never_falls(spheres):
    seen = []
    made = reports(lambda made: seen.append((made.fraction, made.stage)))
    fractions = [fraction for fraction, _ in seen]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert 0.5 in fractions
    assert any("mesh 2 of 2" in stage for _, stage in seen)
    assert made.done


def test_an_object_that_is_gone_meanwhile_is_named(spheres):
    made = reports(lambda _made: None)
    bpy.data.objects.remove(bpy.data.objects["second"])
    made.finish(bpy.context)
    assert pieces.failures(made) == ['The object "second" is gone; nothing was written.']
    assert "mean_curvature" in spheres[0].data.attributes


def test_an_object_is_baked_whose_mesh_is_edited_through_another_one(spheres):
    edited = spheres[0]
    twin = edited.copy()
    bpy.context.collection.objects.link(twin)
    select(edited)
    bpy.ops.object.mode_set(mode="EDIT")
    edited.select_set(False)
    twin.select_set(True)
    bpy.context.view_layer.objects.active = twin
    assert not bpy.ops.paradesc.bake_frames.poll()
    twin.paradesc_live.mode = "LIVE"  # waits
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert (edited.mode, twin.mode, bpy.context.object) == ("EDIT", "OBJECT", twin)
    assert (twin.paradesc_live.mode, twin.paradesc_live.sentence) == ("LIVE", "")
    select(edited)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.isfinite(attribute_values(edited.data, "mean_curvature")).all()


def test_objects_that_share_a_mesh_at_different_scales_are_said(spheres):
    first, _, third = spheres
    third.scale = (2.0, 2.0, 2.0)
    bpy.context.view_layer.update()
    assert targets.shared_note([first, third])[0].startswith("2 objects share the mesh")
    bpy.context.scene.paradesc.space = "world"
    bpy.ops.paradesc.bake()
    assert '"first" stands in the world' in record.read(first.data)["notes"]
    third.scale = (-1.0, 1.0, 1.0)  # a mirror image has the same curvatures
    bpy.context.view_layer.update()
    assert targets.shared_note([first, third]) == []
    assert "measured on" in targets.shared_note([first, third], source="deformed")[0]
    assert targets.shared_note([first], source="deformed") == []
    assert spaces.is_even(third.matrix_world)


def test_the_button_says_how_many_meshes_there_are(spheres):
    assert panel.button_text(len(targets.by_mesh(targets.chosen(bpy.context)))) == "Bake 2 Meshes"
    assert panel.button_text(1) == "Bake Descriptors"
