"""Mesh files of every kind that programs write give one sphere, without Blender."""

import json

import numpy as np
import pytest

from mesh_kinds import GLTF, NEURO, SOUND, ball, glb, gltf, obj, off, ply, sphere, stl
from paradesc.bridge import InputError
from paradesc.core import job
from paradesc.files import gltf_file, mesh_files
from shapes import RADIUS

# Coordinates of the files are rounded to six places and, where they are quantized, to 1/32767 of the radius.
PLACES = RADIUS / 32767


def read(folder, suffix, content):
    if suffix in NEURO:
        pytest.importorskip("nibabel")
    path = folder / f"ball{suffix}"
    path.write_bytes(content)
    return mesh_files.read(path)


def volume(points, triangles):
    return np.linalg.det(points[triangles]).sum() / 6


@pytest.mark.parametrize(("suffix", "name"), SOUND)
def test_every_kind_of_file_is_the_same_sphere(tmp_path, suffix, name):
    (mesh,) = read(tmp_path, suffix, SOUND[suffix, name])
    points, triangles = sphere()
    found = mesh.arrays.positions @ mesh.matrix_world[:3, :3].T
    faces = mesh.arrays.triangle_vertices
    if name == "corners of all forms":  # whose last two faces are there twice
        assert faces[-2:].tolist() == [[0, 1, 2], [0, 1, 2]]
        faces = faces[:-2]
    assert len(found) == len(points)
    assert len(faces) == len(triangles)
    # the welded vertices of .stl are in another order, so the surfaces are compared
    np.testing.assert_allclose(np.sort(found, axis=0), np.sort(points, axis=0), atol=PLACES)
    np.testing.assert_allclose(volume(found, faces), volume(points, triangles), rtol=1e-4)  # wound outwards
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()  # closed


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".off", ".stl", ".glb", ".gltf", ".vtk", ".vtp", *NEURO])
def test_the_sphere_of_a_file_has_mean_curvature_one_over_radius(tmp_path, suffix):
    content = next(content for (kind, _), content in SOUND.items() if kind == suffix)
    (mesh,) = read(tmp_path, suffix, content)
    settings = job.Settings(backend="reference")
    settings.options.radius = 0.15
    found = job.run(mesh.arrays, settings).values["mean_curvature"]
    np.testing.assert_allclose(found, 1 / RADIUS, rtol=0.03)  # what facets of this size leave


@pytest.mark.parametrize(
    ("suffix", "name", "sentence"),
    [
        (".obj", "normals that are not there", "normals were left out: its faces name normals that it lacks"),
        (".obj", "no numbers", "normals were left out: some are no three numbers"),
        (".obj", "texture vertices that are not there", "has no texture coordinates, which its faces name"),
        (".stl", "no end", "does not say that it ends"),
        (".stl", "binary with a tail", "17 bytes after the 432 triangles"),
        (".stl", "plain", ""),
    ],
)
def test_what_was_left_out_is_said(tmp_path, suffix, name, sentence):
    (mesh,) = read(tmp_path, suffix, SOUND.get((suffix, name), stl()))
    assert sentence in " ".join(mesh.notes)


def test_obj_texture_coordinates_that_are_no_numbers_are_no_finite_ones(tmp_path):
    (mesh,) = read(tmp_path, ".obj", SOUND[".obj", "no numbers"])
    assert np.isnan(mesh.arrays.corner_uvs).all()
    (mesh,) = read(tmp_path, ".obj", obj(more="vt 0 0\n", corner="{0}/{0}"))
    assert np.isnan(mesh.arrays.corner_uvs).any()
    (mesh,) = read(tmp_path, ".obj", SOUND[".obj", "one coordinate"])
    assert np.array_equal(np.unique(mesh.arrays.corner_uvs, axis=0), [[0.5, 0]])


# ---- OFF: polygons

CONCAVE = [(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)]


@pytest.mark.parametrize("first", range(5))
def test_off_polygons_of_any_size_beside_each_other_cover_their_area(tmp_path, first):
    points = [*CONCAVE, (4, 0), (4, 2)]
    around = np.roll(range(5), -first).tolist()
    faces = [[5, *around], [4, 1, 5, 6, 2], [3, 1, 5, 2], [2, 0, 1]]
    text = f"OFF\n{len(points)} {len(faces)} 0\n" + "".join(f"{x} {y} 0\n" for x, y in points)
    (mesh,) = read(tmp_path, ".off", (text + "".join(" ".join(map(str, face)) + "\n" for face in faces)).encode())
    corners = mesh.arrays.positions[mesh.arrays.triangle_vertices][:, :, :2].astype(float)
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / 2
    assert (areas > 0).all()
    assert np.isclose(areas.sum(), 2.5 + 4 + 2)
    assert mesh.face_count == 4


# ---- glTF


def test_gltf_primitives_that_share_their_positions_share_vertices(tmp_path):
    points, triangles = sphere()
    halves = np.array_split(triangles.astype("<u2"), 40)
    parts = [{"attributes": {"POSITION": 0}, "indices": k + 1} for k in range(len(halves))]
    arrays = [points.astype("<f4"), *(half.reshape(-1) for half in halves)]
    (mesh,) = read(tmp_path, ".glb", glb(*gltf(parts, arrays)))
    assert len(mesh.arrays.positions) == len(points)
    assert np.array_equal(mesh.arrays.triangle_vertices, triangles)


def test_gltf_meshes_that_share_their_positions_have_the_vertices_that_they_use(tmp_path):
    points, triangles = sphere()
    arrays = [points.astype("<f4"), triangles[:9].astype("<u2").reshape(-1), triangles[9:].astype("<u2").reshape(-1)]
    header, content = gltf([{"attributes": {"POSITION": 0}, "indices": 1}], arrays, [{"mesh": 0}, {"mesh": 1}])
    header["meshes"].append({"primitives": [{"attributes": {"POSITION": 0}, "indices": 2}]})
    header["scenes"] = [{"nodes": [0, 1]}]
    first, second = read(tmp_path, ".glb", glb(header, content))
    assert len(first.arrays.positions) == len(np.unique(triangles[:9]))
    assert len(second.arrays.positions) == len(np.unique(triangles[9:]))
    assert np.array_equal(first.arrays.positions[first.arrays.triangle_vertices], points.astype("f4")[triangles[:9]])


@pytest.mark.parametrize("uri", ["my%20buffer.bin", "my buffer.bin", "b%C3%BCffer.bin", "büffer.bin"])
def test_gltf_buffers_may_be_named_with_escapes(tmp_path, uri):
    header, content = ball()
    header["buffers"][0]["uri"] = uri
    name = {"my%20buffer.bin": "my buffer.bin", "b%C3%BCffer.bin": "büffer.bin"}.get(uri, uri)
    (tmp_path / name).write_bytes(content)
    (mesh,) = read(tmp_path, ".gltf", json.dumps(header).encode())
    assert len(mesh.arrays.positions) == len(sphere()[0])
    assert gltf_file.buffer_path(tmp_path / "ball.gltf", uri) == tmp_path / name


def test_gltf_nodes_stand_where_their_parents_and_they_say(tmp_path):
    turned = {"rotation": [0, 0, np.sqrt(0.5), np.sqrt(0.5)], "translation": [1, 2, 3], "children": [1, 2]}
    matrix = [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 5, 6, 7, 1]  # column after column
    nodes = [turned, {"mesh": 0, "name": "one", "matrix": matrix}, {"mesh": 0, "scale": [1, 2, 3]}, {"mesh": 0}]
    one, other = read(tmp_path, ".glb", glb(*ball(nodes=nodes)))
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(one.matrix_world[:3, :3], 2 * quarter, atol=1e-12)
    np.testing.assert_allclose(one.matrix_world[:3, 3], quarter @ [5, 6, 7] + [1, 2, 3], atol=1e-12)
    np.testing.assert_allclose(other.matrix_world[:3, :3], quarter * [1, 2, 3], atol=1e-12)
    assert (one.name, other.name) == ("one", "ball")


def test_a_gltf_node_below_several_others_stands_in_as_many_places(tmp_path):
    nodes = [{"children": [1, 2]}, {"children": [3]}, {"children": [3], "translation": [9, 0, 0]}, {"mesh": 0}]
    found = read(tmp_path, ".glb", glb(*ball(nodes=nodes)))
    assert [(mesh.name, mesh.matrix_world[0, 3]) for mesh in found] == [("ball", 0), ("ball.001", 9)]


def test_gltf_texture_coordinates_may_be_whole_numbers_and_end_at_the_top(tmp_path):
    points, triangles = sphere()
    for kind in ("u1", "u2", "f4"):
        most = 1 if kind == "f4" else np.iinfo(kind).max
        uvs = np.round((points[:, :2] / RADIUS + 1) / 2 * (most if kind != "f4" else 1), 9 if kind == "f4" else 0)
        arrays = [points.astype("<f4"), triangles.reshape(-1).astype("<u2"), uvs.astype("<" + kind)]
        arrays[2] = {"array": arrays[2], "normalized": True} if kind != "f4" else arrays[2]
        parts = [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2, "NORMAL": 0}, "indices": 1}]
        (mesh,) = read(tmp_path, ".glb", glb(*gltf(parts, arrays)))
        expected = (uvs / most * (1, -1) + (0, 1))[triangles.reshape(-1)]
        np.testing.assert_allclose(mesh.arrays.corner_uvs, expected, atol=1e-6)
        assert np.array_equal(mesh.corner_normals, points.astype("f4")[triangles.reshape(-1)])


def test_gltf_interleaved_and_morphed_tables_are_read(tmp_path):
    points, triangles = sphere()
    both = np.column_stack([points, points]).astype("<f4")
    moved = {"array": points.astype("<f4"), "sparse": "of a morph, which is not looked at"}
    arrays = [both[:, :3].copy(), triangles.reshape(-1).astype("<u2"), moved]
    parts = [{"attributes": {"POSITION": 0}, "indices": 1, "targets": [{"POSITION": 2}]}]
    header, content = gltf(parts, arrays)
    view = header["bufferViews"][0]
    view["byteOffset"], view["byteStride"], view["byteLength"] = len(content), 24, both.nbytes
    header["buffers"][0]["byteLength"] = len(content) + both.nbytes
    (mesh,) = read(tmp_path, ".glb", glb(header, content + both.tobytes()))
    assert np.array_equal(mesh.arrays.positions, points.astype("f4"))


def test_files_may_be_named_in_capitals_and_in_any_alphabet(tmp_path):
    for name in ("BALL.OBJ", "é猫 'x'#1.obj", "a.b.obj"):
        (tmp_path / name).write_bytes(obj())
        (mesh,) = mesh_files.read(tmp_path / name)
        assert mesh.name == name[: -len(".obj")]


def test_the_check_before_another_reader_leaves_to_it_what_this_one_does_not_know(tmp_path):
    path = tmp_path / "a.glb"
    path.write_bytes(glb(*ball(extensionsRequired=["KHR_draco_mesh_compression"])))
    assert mesh_files.check(path) == 0
    with pytest.raises(InputError, match="export it without compression"):
        mesh_files.read(path)
    for name, content in (("a.fbx", b"x"), ("a.gltf", GLTF["embedded"]), ("a.off", off()), ("points.ply", ply()[:9])):
        (tmp_path / name).write_bytes(content)
    assert [mesh_files.check(tmp_path / name) for name in ("a.fbx", "a.gltf", "a.off")] == [0, 432, 432]
    with pytest.raises(InputError, match="header does not end"):
        mesh_files.check(tmp_path / "points.ply")
    (tmp_path / "b.obj").write_bytes(obj() + b"f 1 2 3 4\nf 3 1 2\nf 2 1 3\nf 5 5 6\nf 1 2\nf 4 1 2 3\n")
    assert mesh_files.check(tmp_path / "b.obj") == 432 + 2  # doubles and what has no area are counted by nobody
