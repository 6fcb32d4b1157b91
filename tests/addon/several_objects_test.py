"""bake of several objects: one file or a file each, shared meshes, what is left out, world space, shape keys."""

import numpy as np
import pytest

from cli_test import read_ply
from shapes import RADIUS, cube_sphere

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc import bridge  # noqa: E402
from paradesc.commands import common  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc.files import results  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene, saved_scene  # noqa: E402

QUICK = ("--radius", "0.08", "--samples", "32", "--buffer", "128", "--backend", "software")


@pytest.mark.slow
def test_all_objects_go_into_one_file_each_kind_in_its_way(run, report, tmp_path, three_objects):
    words = [word for name in ("a.npz", "a.ply", "a.blend") for word in ("--output", name)]
    names = "mean_curvature,principal_direction_max"
    ended = run("bake", three_objects, "--all", "--descriptors", names, *QUICK, *words, "--json", "report.json")
    assert ended.code == 0, ended.error
    rows = report()["objects"]
    assert [row["object"] for row in rows] == ["first", "second/large", "twin"]
    assert rows[2]["notes"] == ['It shares the mesh of "first" and has its results.']
    assert any('"hidden" is disabled in renders' in note for note in report()["notes"])
    assert any('"bare" has no faces' in note for note in report()["notes"])
    with np.load(tmp_path / "a.npz") as file:
        arrays = dict(file)
    assert {name.rpartition("/")[0] for name in arrays} == {"first", "second/large", "twin"}
    np.testing.assert_array_equal(arrays["first/mean_curvature"], arrays["twin/mean_curvature"])
    np.testing.assert_allclose(arrays["twin/matrix_world"][:3, 3], (0, 10, 0))
    counts = [len(cube_sphere(steps)[0]) for steps in (6, 8, 6)]
    vertices, faces = read_ply(tmp_path / "a.ply")
    assert len(vertices) == sum(counts)
    assert faces["vertices"].max() == len(vertices) - 1
    large = np.stack([vertices[axis] for axis in "xyz"], axis=1)[counts[0] : counts[0] + counts[1]]
    np.testing.assert_allclose(np.linalg.norm(large - (10, 0, 0), axis=1), 2 * RADIUS, rtol=1e-5)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    for name in ("first", "second/large"):
        found = attribute_values(bpy.data.objects[name].data, "mean_curvature")
        np.testing.assert_array_equal(found, arrays[f"{name}/mean_curvature"])
    assert "mean_curvature" not in bpy.data.objects["hidden"].data.attributes


def test_images_of_several_objects_are_a_file_each(run, report, tmp_path, three_objects):
    words = ("--object", "first", "--object", "second/large", "--texels", "64", "--map", "m.exr", "--map", "m.png")
    ended = run("bake", three_objects, *words, *QUICK, "--dump-buffers", "dump", "--json", "report.json")
    assert ended.code == 0, ended.error
    stems = ("m_first", "m_second_large")
    assert sorted(path.name for path in tmp_path.glob("m_*")) == [f"{s}{e}" for s in stems for e in (".exr", ".png")]
    assert (tmp_path / "dump" / "second_large" / "buffers.npz").is_file()
    assert {row["object"] for row in report()["maps"]} == {"first", "second/large"}


def test_bad_object_among_several_is_named(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    bpy.data.objects["second/large"].data.vertices[3].co.x = float("nan")
    ended = run("bake", "--all", *QUICK, "--output", "out.npz")
    assert ended.code == common.EXIT_INPUT
    assert 'Object "second/large": ' in ended.error
    assert not (tmp_path / "out.npz").exists()


def test_shapes_of_bones_are_no_objects(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones.new("bone").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.pose.bones[0].custom_shape = bpy.data.objects["second/large"]
    ended = run("bake", "--all", *QUICK, "--output", "out.npz")
    assert 'The object "second/large" is the shape of a bone and was left out.' in ended.output
    with np.load(tmp_path / "out.npz") as arrays:
        assert {name.rpartition("/")[0] for name in arrays.files} == {"first", "twin"}
    assert "second/large" not in run("info").output


def test_world_space_counts_the_scale_of_each_object(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    bpy.data.objects["twin"].scale = (3, 3, 3)
    saved_scene(three_objects)
    words = ("--all", *QUICK, "--space", "world", "--output", "a.npz", "--output", "a.blend")
    ended = run("bake", three_objects, *words)
    assert ended.code == 0, ended.error
    with np.load(tmp_path / "a.npz") as arrays:
        for name, scale in (("first", 1), ("second/large", 2), ("twin", 3)):
            found = arrays[f"{name}/mean_curvature"]
            np.testing.assert_allclose(found, 1 / (scale * RADIUS), rtol=0.06)  # 32 samples on a coarse sphere
            np.testing.assert_allclose(np.linalg.norm(arrays[f"{name}/vertices"], axis=1), RADIUS, rtol=1e-5)
    assert "it was measured as" in ended.output


def test_uneven_scale_that_is_not_measured_is_said(run, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    bpy.data.objects["first"].scale = (1, 1, 2)
    assert "give --space world" in run("bake", "--object", "first", *QUICK, "--output", "a.npz").output


def test_shape_key_is_measured_where_asked_for(run, report, tmp_path):
    empty_scene()
    target = add_sphere(steps=6)
    target.shape_key_add(name="Basis")
    key = target.shape_key_add(name="half")
    points = 0.5 * cube_sphere(6)[0]
    key.data.foreach_set("co", points.astype(np.float32).ravel())
    target.active_shape_key_index = 1
    path = saved_scene(tmp_path / "keys.blend")
    for shape, size in (("basis", 1.0), ("active", 0.5)):
        words = ("--shape-key", shape, "--output", f"{shape}.npz", "--json", "report.json")
        assert run("bake", path, *QUICK, *words).code == 0
        with np.load(tmp_path / f"{shape}.npz") as arrays:
            np.testing.assert_allclose(arrays["mean_curvature"] * size * RADIUS, 1, rtol=0.06)
    assert report()["objects"][0]["notes"] == ['The shape key "half" was measured, at its full value.']


def test_directions_are_turned_with_their_object():
    arrays = bridge.MeshArrays(np.zeros((2, 3), np.float32), np.zeros(0, np.int32), np.zeros((0, 3), np.int32))
    turned = np.array([[0, -2, 0, 5], [2, 0, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1.0]])

    class Found:
        settings = job.Settings()
        values = {"principal_direction_max": np.array([[1, 0, 0], [np.nan] * 3], np.float32)}

    found = results.world_values(results.Baked("a", Found(), arrays, turned), "principal_direction_max")
    np.testing.assert_allclose(found, [[0, 1, 0], [np.nan] * 3])
