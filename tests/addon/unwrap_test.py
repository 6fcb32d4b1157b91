"""Meshes without a usable UV map get a layout, and nothing else in the file changes."""

import numpy as np
import pytest

from conftest import real_mesh
from shapes import cube_sphere

bpy = pytest.importorskip("bpy", reason="needs Blender")

import paradesc_blender  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.bridge import ParadescError  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc.core.uv_faults import uv_areas  # noqa: E402
from paradesc_blender.scene import delivery, mesh_io, record, unwrap  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene, fingerprint, measure_curvature  # noqa: E402

OPTIONS = bridge.Options(radius=0.08, samples=64, buffer_size=512)
SETTINGS = job.Settings(("mean_curvature",), OPTIONS, "software")
CURVATURE = 0.5  # of the sphere


@pytest.fixture
def bare():
    """The sphere without a UV map."""
    empty_scene()
    return add_sphere(steps=16, uv_map=False)


@pytest.fixture
def unwraps(monkeypatch):
    """Counts how often Blender unwraps."""
    made = []
    original = unwrap.unwrapped
    monkeypatch.setattr(unwrap, "unwrapped", lambda *words: made.append(words) or original(*words))
    return made


def read(target, **words):
    return mesh_io.read_object(target, corner_normals=False, **words)


def bake(target):
    """Computes and writes; gives the results."""
    results = job.run(read(target), SETTINGS)
    delivery.deliver(target, results)
    return results


def error_percent(values):
    return 100 * np.abs(values / CURVATURE - 1).mean()


def data_blocks():
    """Every data-block of the file, by kind and name."""
    kinds = ("scenes", "objects", "meshes", "collections", "images", "materials", "worlds", "texts")
    return {kind: [item.name_full for item in getattr(bpy.data, kind)] for kind in kinds}


def state():
    """The parts of the open scene that an unwrap could disturb."""
    layer = bpy.context.view_layer
    return (
        data_blocks(),
        bpy.context.scene.name,
        None if layer.objects.active is None else layer.objects.active.name,
        bpy.context.mode,
        [(item.name, item.mode, item.select_get(), item.hide_get()) for item in bpy.context.scene.objects],
        tuple(bpy.context.tool_settings.mesh_select_mode),
        bpy.context.tool_settings.use_uv_select_sync,
    )


def overlapping_texels(uvs, triangles, side=512):
    """How many texel centers lie inside more than one triangle."""
    count = np.zeros((side, side), int)
    for corners in uvs[triangles].astype(np.float64) * side:
        low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(corners.max(axis=0)).astype(int), side)
        x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
        signs = []
        for k in range(3):
            (ax, ay), (bx, by) = corners[k], corners[(k + 1) % 3]
            signs.append((bx - ax) * (y - ay) - (by - ay) * (x - ax))
        signs = np.array(signs)
        count[low[1] : high[1], low[0] : high[0]] += (signs > 1e-6).all(axis=0) | (signs < -1e-6).all(axis=0)
    assert count.max() > 0
    return (count > 1).sum()


def test_sphere_without_uv_map_has_its_curvature(bare):
    results = job.run(read(bare), SETTINGS)
    assert np.isfinite(results.values["mean_curvature"]).all()
    assert error_percent(results.values["mean_curvature"]) < 1.0
    (sentence,) = [text for text in results.warnings if "unwrapped" in text]
    assert "has no UV map" in sentence
    assert f"into {results.mesh_report['charts']} charts" in sentence


def test_layout_lies_in_the_unit_square_without_overlap(bare):
    arrays = read(bare)
    assert arrays.corner_uvs.dtype == np.float32
    assert arrays.corner_uvs.shape == (len(bare.data.loops), 2)
    assert arrays.corner_uvs.min() >= 0
    assert arrays.corner_uvs.max() <= 1
    assert (uv_areas(arrays.corner_uvs, arrays.triangle_corners) > 0).all()
    assert overlapping_texels(arrays.corner_uvs, arrays.triangle_corners) == 0


def test_charts_keep_gutters_of_several_texels(bare):
    arrays = read(bare)
    side, apart = 1024, 3
    results = job.run(arrays, SETTINGS)
    assert results.mesh_report["charts"] > 1
    # Charts as connected corners at equal UVs; bounding boxes are packed, so boxes have to lie apart.
    uvs = arrays.corner_uvs[arrays.triangle_corners] * side
    _, corner = np.unique(uvs.reshape(-1, 2), axis=0, return_inverse=True)
    chart = np.arange(corner.max() + 1)
    corner = corner.reshape(-1, 3)
    for _ in range(len(chart)):
        least = np.full(len(chart), len(chart))
        np.minimum.at(least, corner.ravel(), np.repeat(chart[corner].min(axis=1), 3))
        if np.array_equal(least, chart):
            break
        chart = least
    names = chart[corner[:, 0]]
    boxes = [(uvs[names == name].min(axis=(0, 1)), uvs[names == name].max(axis=(0, 1))) for name in np.unique(names)]
    assert len(boxes) == results.mesh_report["charts"]
    for index, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:index]:
            assert max((other_low - high).max(), (low - other_high).max()) >= apart


def test_same_mesh_gets_the_same_layout(bare):
    assert np.array_equal(read(bare).corner_uvs, read(bare).corner_uvs)


def test_vertices_split_by_a_file_are_unwrapped_as_one_surface():
    empty_scene()
    points, quads, _ = cube_sphere(8)
    mesh = bpy.data.meshes.new("split")
    mesh.from_pydata(points[quads.ravel()].tolist(), [], np.arange(quads.size).reshape(-1, 4).tolist())
    target = bpy.data.objects.new("split", mesh)
    bpy.context.collection.objects.link(target)
    results = job.run(read(target), SETTINGS)
    assert results.mesh_report["charts"] < len(quads) / 4
    assert error_percent(results.values["mean_curvature"]) < 3.0  # twice as coarse as the other sphere


def test_faces_that_use_a_place_twice_do_not_harm_the_others(bare):
    mesh = bare.data
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    collapsed, kept = corners[:2]
    mesh.vertices[collapsed].co = mesh.vertices[kept].co
    arrays = read(bare)
    assert np.isfinite(arrays.corner_uvs).all()
    areas = uv_areas(arrays.corner_uvs, arrays.triangle_corners)
    assert (areas != 0).mean() > 0.99


@pytest.mark.parametrize(
    ("value", "words"),
    [(0.25, "without area"), (np.nan, "not finite"), (np.inf, "not finite")],
    ids=["a point", "nan", "infinity"],
)
def test_unusable_uv_map_is_replaced_for_the_computation_and_kept(bare, value, words):
    layer = bare.data.uv_layers.new(name="mine")
    uvs = np.full(2 * len(bare.data.loops), value, np.float32)
    layer.data.foreach_set("uv", uvs)
    results = bake(bare)
    assert error_percent(results.values["mean_curvature"]) < 1.0
    assert any(words in text for text in results.warnings)
    assert [item.name for item in bare.data.uv_layers] == ["mine"]
    assert bare.data.uv_layers.active.name == "mine"
    assert np.array_equal(mesh_io.read_uvs(bare.data).ravel(), uvs, equal_nan=True)


def test_map_with_area_on_some_faces_only_is_the_users_choice(bare, unwraps):
    layer = bare.data.uv_layers.new(name="mine", do_init=False)
    uvs = np.zeros((len(bare.data.loops), 2), np.float32)
    few = len(bare.data.polygons) // 20
    uvs[: 4 * few] = np.tile([[0, 0], [1, 0], [1, 1], [0, 1]], (few, 1))
    layer.data.foreach_set("uv", uvs.ravel())
    arrays = read(bare)
    assert unwraps == []
    assert arrays.layout is None
    assert np.array_equal(arrays.corner_uvs, uvs)


def test_usable_uv_map_is_taken_and_nothing_kept(unwraps):
    empty_scene()
    target = add_sphere()
    results = bake(target)
    assert unwraps == []
    assert not any("unwrapped" in text for text in results.warnings)
    assert unwrap.ATTRIBUTE not in target.data.attributes


def test_reference_needs_no_layout(bare, unwraps):
    arrays = read(bare, needs_uvs=False)
    assert arrays.corner_uvs is None
    results = job.run(arrays, job.Settings(("mean_curvature",), OPTIONS, "reference"))
    assert unwraps == []
    assert error_percent(results.values["mean_curvature"]) < 1.0
    assert results.unwrapped is None


def test_reading_changes_nothing(bare):
    before = fingerprint(bare), state()
    read(bare)
    assert (fingerprint(bare), state()) == before


@pytest.mark.parametrize("mode", ["EDIT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"])
def test_mode_selection_and_other_objects_stay(bare, mode):
    other = add_sphere("other")
    other.select_set(False)
    other.hide_set(True)
    bpy.context.view_layer.objects.active = bare
    bare.select_set(True)
    bpy.ops.object.mode_set(mode=mode)
    before = state()
    arrays = read(bare)
    assert arrays.layout is not None
    assert state() == before
    bpy.ops.object.mode_set(mode="OBJECT")


def test_other_object_in_edit_mode_keeps_its_edits_and_uvs(bare):
    import bmesh

    other = add_sphere("other")
    bare.select_set(False)
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(other.data)
    edited.verts.ensure_lookup_table()
    edited.verts[0].co.z += 1.0
    layer = edited.loops.layers.uv.active
    uvs = [tuple(corner[layer].uv) for face in edited.faces for corner in face.loops]
    before = state()
    read(bare)
    assert state() == before
    edited = bmesh.from_edit_mesh(other.data)
    assert [tuple(corner[layer].uv) for face in edited.faces for corner in face.loops] == uvs
    bpy.ops.object.mode_set(mode="OBJECT")
    np.testing.assert_allclose(other.data.vertices[0].co.z, cube_sphere(8)[0][0, 2] + 1.0, rtol=1e-6)


def test_edit_mode_unwraps_the_mesh_as_edited_so_far(bare):
    import bmesh

    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(bare.data)
    edited.faces.ensure_lookup_table()
    bmesh.ops.delete(edited, geom=edited.faces[:10], context="FACES")
    bmesh.update_edit_mesh(bare.data)
    arrays = read(bare)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(arrays.corner_uvs) == len(bare.data.loops) == 4 * (len(cube_sphere(16)[1]) - 10)


def test_failed_operator_is_one_sentence_and_leaves_nothing(bare, monkeypatch):
    def fail():
        raise RuntimeError("Error: it\nbroke.\n")

    monkeypatch.setattr(unwrap, "run_operator", fail)
    before = fingerprint(bare), state()
    with pytest.raises(ParadescError, match="could not unwrap") as caught:
        read(bare)
    assert "\n" not in caught.value.sentence
    assert (fingerprint(bare), state()) == before


def test_position_that_is_not_finite_is_one_sentence(bare):
    bare.data.vertices[3].co.x = float("nan")
    with pytest.raises(ParadescError, match="vertex 3"):
        read(bare)


def test_layout_is_kept_hidden_and_is_no_uv_map(bare):
    bake(bare)
    attribute = bare.data.attributes[unwrap.ATTRIBUTE]
    assert attribute.is_internal
    assert attribute.domain == "CORNER"
    assert len(bare.data.uv_layers) == 0
    assert unwrap.ATTRIBUTE not in record.read(bare.data)["attributes"]


def test_kept_layout_is_used_again(bare, unwraps):
    first = bake(bare)
    assert len(unwraps) == 1
    again = bake(bare)
    assert len(unwraps) == 1
    assert np.array_equal(first.values["mean_curvature"], again.values["mean_curvature"])
    assert any("earlier bake" in text for text in again.warnings)
    bare.data.vertices[0].co.z += 0.01  # the faces are connected as before
    assert read(bare).layout.kept
    bpy.ops.object.mode_set(mode="EDIT")
    assert read(bare).layout.kept
    bpy.ops.object.mode_set(mode="OBJECT")
    assert read(bare).layout.kept
    assert len(unwraps) == 1


def test_kept_layout_survives_saving(bare, unwraps, tmp_path):
    bake(bare)
    path = tmp_path / "saved.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert read(bpy.data.objects["sphere"]).layout.kept
    assert len(unwraps) == 1


def test_kept_layout_is_made_afresh_after_a_change_of_the_faces(bare, unwraps):
    bake(bare)
    before = record.layout_of(bare.data)
    corners = np.empty(len(bare.data.loops), np.int32)
    bare.data.loops.foreach_get("vertex_index", corners)
    corners[:4] = np.roll(corners[:4], 1)  # the same counts, another first corner
    bare.data.loops.foreach_set("vertex_index", corners)
    bare.data.update(calc_edges=True)
    assert not read(bare).layout.kept
    bake(bare)
    assert record.layout_of(bare.data)["topology"] != before["topology"]
    assert read(bare).layout.kept


def tamper_values(mesh):
    values = np.zeros(3 * len(mesh.loops), np.float32)
    mesh.attributes[unwrap.ATTRIBUTE].data.foreach_get("vector", values)
    values[0] = np.nan
    mesh.attributes[unwrap.ATTRIBUTE].data.foreach_set("vector", values)


def tamper_domain(mesh):
    mesh.attributes.remove(mesh.attributes[unwrap.ATTRIBUTE])
    mesh.attributes.new(unwrap.ATTRIBUTE, "FLOAT_VECTOR", "POINT")


def tamper_type(mesh):
    mesh.attributes.remove(mesh.attributes[unwrap.ATTRIBUTE])
    mesh.attributes.new(unwrap.ATTRIBUTE, "INT", "CORNER")


def tamper_property(mesh):
    mesh[record.PROPERTY]["layout"] = 7


@pytest.mark.parametrize("tamper", [tamper_values, tamper_domain, tamper_type, tamper_property])
def test_kept_layout_that_was_tampered_with_is_ignored_and_replaced(bare, unwraps, tamper):
    bake(bare)
    tamper(bare.data)
    results = bake(bare)
    assert len(unwraps) == 2
    assert error_percent(results.values["mean_curvature"]) < 1.0
    assert read(bare).layout.kept


def test_layout_of_a_mesh_that_changed_meanwhile_is_not_kept(bare):
    results = job.run(read(bare), SETTINGS)
    corners = np.empty(len(bare.data.loops), np.int32)
    bare.data.loops.foreach_get("vertex_index", corners)
    corners[:4] = np.roll(corners[:4], 1)
    bare.data.loops.foreach_set("vertex_index", corners)
    delivery.deliver(bare, results)
    assert unwrap.ATTRIBUTE not in bare.data.attributes


def test_linked_mesh_is_measured_without_storing(bare, tmp_path):
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    empty_scene()
    with bpy.data.libraries.load(str(path), link=True) as (source, target):
        target.objects = source.objects
    linked = bpy.data.objects["sphere"]
    bpy.context.collection.objects.link(linked)
    before = state()
    results = job.run(read(linked), SETTINGS)
    assert error_percent(results.values["mean_curvature"]) < 1.0
    assert state() == before
    assert unwrap.ATTRIBUTE not in linked.data.attributes


def test_operator_bakes_without_a_uv_map(bare):
    paradesc_blender.register()
    measure_curvature()
    try:
        settings = bpy.context.scene.paradesc
        settings.radius_percent, settings.samples, settings.buffer_size = 8.0, 64, 512
        settings.backend = "software"
        blocks = data_blocks()
        assert bpy.ops.paradesc.bake() == {"FINISHED"}
        assert error_percent(attribute_values(bare.data, "mean_curvature")) < 1.0
        assert "unwrapped a copy" in record.read(bare.data)["warnings"]
        assert data_blocks() == blocks
    finally:
        paradesc_blender.unregister()


@pytest.mark.slow
def test_bunny_is_unwrapped_well():
    path = real_mesh("stanford-bunny.obj")
    empty_scene()
    bpy.ops.wm.obj_import(filepath=str(path))
    (target,) = [item for item in bpy.data.objects if item.type == "MESH"]
    arrays = read(target)
    results = job.run(arrays, job.Settings(("mean_curvature",), bridge.Options(samples=64), "software"))
    assert results.field_report["overlapping_texels"] < 1e-5 * 1024**2
    assert results.field_report["undefined_vertices"] <= 1  # all of its triangles are too small for the map
    assert results.field_report["coverage_mean"] > 0.999
