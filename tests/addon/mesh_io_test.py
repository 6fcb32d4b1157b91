"""Meshes into arrays and results into attributes, inside Blender."""

import itertools

import numpy as np
import pytest

from shapes import cube_sphere

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc import bridge  # noqa: E402
from paradesc.bridge import InputError, ParadescError  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc_blender.scene import delivery, mesh_io, record  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene, fingerprint  # noqa: E402

SETTINGS = job.Settings(
    ("mean_curvature", "shape_index"), bridge.Options(radius=0.08, samples=64, buffer_size=256), "software"
)


@pytest.fixture
def sphere_object():
    empty_scene()
    return add_sphere()


def made_up_results(target, names=("mean_curvature",)):
    """Results for the object's vertices without any computation."""
    count = len(target.data.vertices)
    values = {name: np.linspace(-1, 1, count, dtype=np.float32) + index for index, name in enumerate(names)}
    return job.Results(
        settings=job.Settings(tuple(names)),
        values=values,
        coverage=np.full(count, 0.75, np.float32),
        mask=np.zeros(count, np.uint8),
        mesh_report={"vertex_count": count},
        field_report={"radius": 0.1, "seconds_total": 0.0},
        backend="software",
        device="none",
        warnings=["One.", "Two."],
    )


def test_arrays_are_those_of_the_mesh(sphere_object):
    points, quads, uvs = cube_sphere(8)
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    np.testing.assert_allclose(arrays.positions, points, atol=1e-6)
    assert np.array_equal(arrays.corner_vertices.reshape(-1, 4), quads)
    np.testing.assert_allclose(arrays.corner_uvs.reshape(-1, 4, 2), uvs, atol=1e-6)
    assert arrays.triangle_corners.shape == (2 * len(quads), 3)
    assert arrays.corner_normals is None
    assert arrays.triangle_smooth is None or arrays.triangle_smooth.all()
    assert arrays.sharp_edges is None


def test_arrays_have_the_types_that_c_reads(sphere_object):
    arrays = mesh_io.read_object(sphere_object, corner_normals=True)
    assert arrays.positions.dtype == arrays.corner_uvs.dtype == arrays.corner_normals.dtype == np.float32
    assert arrays.corner_vertices.dtype == arrays.triangle_corners.dtype == np.int32
    assert all(array.flags.c_contiguous for array in (arrays.positions, arrays.corner_uvs, arrays.triangle_corners))


def test_triangles_cover_every_quad_once(sphere_object):
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    corners = np.bincount(arrays.triangle_corners.ravel(), minlength=len(arrays.corner_vertices))
    assert set(corners) == {1, 2}
    assert corners.reshape(-1, 4).sum(axis=1).tolist() == [6] * (len(corners) // 4)


@pytest.mark.parametrize("sides", [(3, 3, 3, 3), (4, 3, 3, 4), (5, 3), (4, 4)])
def test_triangles_and_their_faces_are_those_of_blender(sides):
    empty_scene()
    mesh = bpy.data.meshes.new("Fan")
    points = [
        (np.cos(6.0 * k / side), np.sin(6.0 * k / side), 3.0 * row)
        for row, side in enumerate(sides)
        for k in range(side)
    ]
    starts = np.cumsum((0, *sides))
    mesh.from_pydata(points, [], [range(*ends) for ends in itertools.pairwise(starts)])
    mesh.calc_loop_triangles()
    told = [(tuple(triangle.loops), triangle.polygon_index) for triangle in mesh.loop_triangles]
    corners, faces = mesh_io.read_triangles(mesh)
    assert corners.dtype == faces.dtype == np.int32
    assert [(tuple(row), face) for row, face in zip(corners.tolist(), faces.tolist(), strict=True)] == told


def test_corner_normals_of_a_smooth_sphere_point_outward(sphere_object):
    arrays = mesh_io.read_object(sphere_object, corner_normals=True)
    outward = arrays.positions[arrays.corner_vertices] / 2.0
    assert (arrays.corner_normals * outward).sum(axis=1).min() > 0.99


def test_flat_faces_and_sharp_edges_are_told(sphere_object):
    mesh = sphere_object.data
    mesh.polygons[3].use_smooth = False
    mesh.edges[7].use_edge_sharp = True
    mesh.update()
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    flat = np.flatnonzero(arrays.triangle_smooth == 0)
    assert {corner // 4 for corner in arrays.triangle_corners[flat].ravel()} == {3}
    assert len(flat) == 2
    assert arrays.sharp_edges.tolist() == [list(mesh.edges[7].vertices)]


def test_mesh_without_uv_map_has_no_uvs_where_none_are_needed():
    empty_scene()
    target = add_sphere(uv_map=False)
    assert mesh_io.read_object(target, corner_normals=False, needs_uvs=False).corner_uvs is None


def test_active_uv_map_is_the_one_read(sphere_object):
    other = sphere_object.data.uv_layers.new(name="other")
    sphere_object.data.uv_layers.active = other
    uvs = 0.25 * cube_sphere(8)[2].astype(np.float32).ravel()
    other.data.foreach_set("uv", uvs)
    assert np.array_equal(mesh_io.read_object(sphere_object, corner_normals=False).corner_uvs.ravel(), uvs)


def test_mesh_without_faces_is_one_sentence():
    empty_scene()
    mesh = bpy.data.meshes.new("cloud")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    with pytest.raises(ParadescError, match="no faces"):
        mesh_io.read_object(bpy.data.objects.new("cloud", mesh), corner_normals=False)


def test_a_face_of_two_corners_counts_as_no_surface():
    empty_scene()
    mesh = bpy.data.meshes.new("import")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1), (2, 2, 2)], [], [(3, 4), (0, 1, 2), (3, 4)])
    _, triangles = mesh_io.surface_of(mesh)
    assert triangles.tolist() == [[0, 1, 2]]


def test_edit_mode_gives_the_mesh_as_edited_so_far(sphere_object):
    import bmesh

    before = len(bpy.data.meshes)
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(sphere_object.data)
    edited.verts.ensure_lookup_table()
    edited.verts[0].co.z += 1.0
    bmesh.update_edit_mesh(sphere_object.data)
    arrays = mesh_io.read_object(sphere_object, corner_normals=True)
    points, _, uvs = cube_sphere(8)
    np.testing.assert_allclose(arrays.positions[0], points[0] + (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(arrays.corner_uvs.reshape(-1, 4, 2), uvs, atol=1e-6)
    assert sphere_object.mode == "EDIT"
    assert len(bpy.data.meshes) == before
    bpy.ops.object.mode_set(mode="OBJECT")


def test_results_become_attributes_and_active_colors(sphere_object):
    results = made_up_results(sphere_object, ("mean_curvature", "shape_index"))
    assert delivery.deliver(sphere_object, results) == []
    mesh = sphere_object.data
    for name in ("mean_curvature", "shape_index", "coverage"):
        assert (mesh.attributes[name].data_type, mesh.attributes[name].domain) == ("FLOAT", "POINT")
    for name in ("mean_curvature_color", "shape_index_color"):
        assert (mesh.attributes[name].data_type, mesh.attributes[name].domain) == ("FLOAT_COLOR", "POINT")
    assert np.array_equal(attribute_values(mesh, "mean_curvature"), results.values["mean_curvature"])
    assert np.array_equal(attribute_values(mesh, "shape_index"), results.values["shape_index"])
    assert (attribute_values(mesh, "coverage") == 0.75).all()
    assert mesh.color_attributes.active_color.name == "mean_curvature_color"
    assert mesh.color_attributes[mesh.color_attributes.render_color_index].name == "mean_curvature_color"
    colors = attribute_values(mesh, "mean_curvature_color")
    assert colors[0, 2] > colors[0, 0] + 0.3  # the lowest value is blue
    assert colors[-1, 0] > colors[-1, 2] + 0.3  # the highest is red
    assert (colors[:, 3] == 1).all()


def test_undefined_values_stay_nan_and_are_grey(sphere_object):
    results = made_up_results(sphere_object)
    results.values["mean_curvature"][5] = np.nan
    delivery.deliver(sphere_object, results)
    assert np.isnan(attribute_values(sphere_object.data, "mean_curvature")[5])
    np.testing.assert_allclose(attribute_values(sphere_object.data, "mean_curvature_color")[5, :3], 0.21404, atol=1e-4)
    assert np.flatnonzero(attribute_values(sphere_object.data, "paradesc_mask")).tolist() == [5]
    assert attribute_values(sphere_object.data, "paradesc_mask")[5] == 1


def test_second_bake_overwrites_the_first(sphere_object):
    delivery.deliver(sphere_object, made_up_results(sphere_object))
    names = sorted(attribute.name for attribute in sphere_object.data.attributes)
    again = made_up_results(sphere_object)
    again.values["mean_curvature"] += 5
    delivery.deliver(sphere_object, again)
    assert sorted(attribute.name for attribute in sphere_object.data.attributes) == names
    assert np.array_equal(attribute_values(sphere_object.data, "mean_curvature"), again.values["mean_curvature"])


def test_which_vertices_have_no_value_is_written_only_where_one_has_none_or_had(sphere_object):
    mesh, name = sphere_object.data, "paradesc_mask"
    results = made_up_results(sphere_object)
    delivery.deliver(sphere_object, results)
    assert name not in mesh.attributes
    results.values["mean_curvature"][7] = np.nan
    delivery.deliver(sphere_object, results)
    assert np.flatnonzero(attribute_values(mesh, name)).tolist() == [7]
    results.values["mean_curvature"][7] = 0.5
    delivery.deliver(sphere_object, results)
    assert not attribute_values(mesh, name).any()  # what reads it goes on


def test_summary_says_what_was_done(sphere_object):
    delivery.deliver(sphere_object, made_up_results(sphere_object))
    stored = record.read(sphere_object.data)
    assert stored["settings"]["descriptors"] == ["mean_curvature"]
    assert stored["settings"]["radius"] == 0.02
    assert stored["warnings"].splitlines() == ["One.", "Two."]
    assert stored["attributes"] == ["coverage", "mean_curvature", "mean_curvature_color"]


def test_largest_seed_fits_the_summary(sphere_object):
    results = made_up_results(sphere_object)
    results.settings.options.seed = 2**32 - 1
    delivery.deliver(sphere_object, results)
    assert record.read(sphere_object.data)["settings"]["seed"] == 2**32 - 1


def test_attribute_of_another_type_stays_whoever_made_it(sphere_object):
    delivery.deliver(sphere_object, made_up_results(sphere_object))
    mesh = sphere_object.data
    mesh.attributes.remove(mesh.attributes["coverage"])
    mesh.attributes.new("coverage", "INT", "FACE")
    mesh.attributes.remove(mesh.attributes["mean_curvature_color"])
    mesh.attributes.new("mean_curvature_color", "FLOAT", "FACE")
    sentences = delivery.deliver(sphere_object, made_up_results(sphere_object))
    assert ["mean_curvature_2" in sentences[0], "coverage_2" in sentences[1]] == [True, True]
    assert (mesh.attributes["coverage"].data_type, mesh.attributes["coverage_2"].data_type) == ("INT", "FLOAT")
    assert mesh.attributes["mean_curvature_color"].domain == "FACE"


def test_uv_map_with_a_result_name_stays(sphere_object):
    sphere_object.data.uv_layers[0].name = "mean_curvature"
    (sentence,) = delivery.deliver(sphere_object, made_up_results(sphere_object))
    assert '"mean_curvature_2"' in sentence
    assert sphere_object.data.uv_layers.keys() == ["mean_curvature"]


def test_a_failure_takes_back_what_was_made(sphere_object, monkeypatch):
    before, make = fingerprint(sphere_object), mesh_io.make_attribute
    made = []

    def fail_at_the_third(mesh, name):
        made.append(name)
        if len(made) == 3:
            raise InputError("No.")
        return make(mesh, name)

    monkeypatch.setattr(mesh_io, "make_attribute", fail_at_the_third)
    with pytest.raises(ParadescError, match=r"No\."):
        delivery.deliver(sphere_object, made_up_results(sphere_object))
    assert fingerprint(sphere_object) == before


def test_changed_mesh_is_refused_and_kept(sphere_object):
    results = made_up_results(sphere_object)
    results.coverage = results.coverage[:-1]
    before = fingerprint(sphere_object)
    with pytest.raises(ParadescError, match="changed"):
        delivery.deliver(sphere_object, results)
    assert fingerprint(sphere_object) == before


def test_linked_mesh_is_refused(sphere_object, tmp_path):
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    empty_scene()
    with bpy.data.libraries.load(str(path), link=True) as (source, target):
        target.objects = source.objects
    linked = bpy.data.objects["sphere"]
    with pytest.raises(ParadescError, match="linked"):
        mesh_io.check_writable(linked)
    local = linked.copy()  # a local object of a linked mesh would lose its attributes just the same
    with pytest.raises(ParadescError, match="linked"):
        mesh_io.check_writable(local)


def test_computed_values_survive_saving(sphere_object, tmp_path):
    results = job.run(mesh_io.read_object(sphere_object, corner_normals=False), SETTINGS)
    delivery.deliver(sphere_object, results)
    path = tmp_path / "saved.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    mesh = bpy.data.objects["sphere"].data
    for name, values in results.values.items():
        assert np.array_equal(attribute_values(mesh, name), values, equal_nan=True)
    assert mesh.color_attributes.active_color.name == "mean_curvature_color"


def test_modifiers_do_not_change_what_is_read(sphere_object):
    sphere_object.modifiers.new("subdivision", "SUBSURF").levels = 2
    arrays = mesh_io.read_object(sphere_object, corner_normals=False)
    assert len(arrays.positions) == len(sphere_object.data.vertices)
