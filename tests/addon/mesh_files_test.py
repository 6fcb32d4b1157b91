"""Mesh files are read without Blender into the file's own vertices (mesh_kinds_test.py: of all kinds of writers)."""

import numpy as np
import pytest

from mesh_kinds import STL, ball, glb, gltf, sphere
from paradesc.core import polygons
from paradesc.files import mesh_files, vtp_file
from shapes import cube_sphere, write_obj

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read_text(path, text):
    path.write_text(text)
    return mesh_files.read(path)


def triangles_of(mesh):
    return mesh.arrays.triangle_vertices.tolist()


# ---- OBJ


def test_obj_keeps_vertices_at_seams_and_the_uv_map_of_corners(tmp_path):
    points, quads, uvs = cube_sphere(4)
    (mesh,) = mesh_files.read(write_obj(tmp_path / "sphere.obj", points, quads, uvs))
    assert mesh.name == "sphere"
    assert np.allclose(mesh.arrays.positions, points, atol=1e-6)
    assert np.array_equal(mesh.arrays.corner_vertices.reshape(-1, 4), quads)
    assert np.allclose(mesh.arrays.corner_uvs, uvs.reshape(-1, 2), atol=1e-6)
    assert (mesh.face_count, len(mesh.arrays.triangle_corners)) == (96, 192)
    assert np.array_equal(mesh.matrix_world, np.eye(4))


def test_obj_keeps_vertices_that_no_face_uses(tmp_path):
    (mesh,) = read_text(tmp_path / "a.obj", SQUARE + "v 9 9 9\nf 1 2 3\n")
    assert len(mesh.arrays.positions) == 5
    assert mesh.name == "a"


@pytest.mark.parametrize(
    "face",
    ["f 1 2 3", "f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/1/1", "f -4 -3 -2", "f -4/-1/-1 -3/1/1 -2/1/1",
     "f 1/ 2/ 3/", "f 1/1 2 3//1", "f 1// 2// 3//", " f\t1 2 \\\n 3  # a face", "f 1 2 3\r"],
)  # fmt: skip
def test_obj_faces_may_be_written_in_all_ways(tmp_path, face):
    (mesh,) = read_text(tmp_path / "a.obj", SQUARE + "vt 0.5 0.25\nvn 0 0 1\n" + face + "\n")
    assert triangles_of(mesh) == [[0, 1, 2]]


def test_obj_faces_of_several_kinds_keep_their_order(tmp_path):
    text = SQUARE + "vt 0.5 0.25\nf 1 2 3\nf 1/1 2/1 3/1 4/1\nf 2//1 3//1 4//1\nvn 0 0 1\n"
    (mesh,) = read_text(tmp_path / "a.obj", text)
    assert triangles_of(mesh) == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [1, 2, 3]]
    assert mesh.arrays.corner_uvs.tolist() == [[0, 0]] * 3 + [[0.5, 0.25]] * 4 + [[0, 0]] * 3
    assert mesh.corner_normals is None


def test_obj_objects_have_their_own_vertices(tmp_path):
    text = "o one\n" + SQUARE + "f 1 2 3\no two\nv 0 0 5\nv 7 7 7\nf 2 3 5\no none\no one\nf 4 3 1\n"
    one, two, again = read_text(tmp_path / "a.obj", text)
    assert [one.name, two.name, again.name] == ["one", "two", "one.001"]
    assert len(one.arrays.positions) == 3
    assert two.arrays.positions.tolist() == [[1, 0, 0], [1, 1, 0], [0, 0, 5], [7, 7, 7]]
    assert triangles_of(two) == [[0, 1, 2]]


# ---- PLY


def as_ply(order, faces, more="", rows=()):
    kind = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}[order]
    header = f"ply\nformat {order} 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\n"
    header += f"property double z\n{more}element face {len(faces)}\nproperty list uchar int vertex_indices\n"
    header += "property uchar flag\nend_header\n"
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    body = b""
    for row, point in enumerate(points):
        numbers = [*point, *(rows[row] if rows else ())]
        if kind is None:
            body += (" ".join(map(str, numbers)) + "\n").encode()
        else:
            kinds = ["f4", "f4", "f8"] + ["f4"] * (len(numbers) - 3)
            body += b"".join(np.array(n, kind + k).tobytes() for n, k in zip(numbers, kinds, strict=True))
    for face in faces:
        if kind is None:
            body += (" ".join(map(str, [len(face), *face, 7])) + "\n").encode()
        else:
            body += bytes([len(face)]) + np.array(face, kind + "i4").tobytes() + b"\7"
    return header.encode() + body


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("faces", [[[0, 1, 2]], [[0, 1, 2, 3]], [[0, 1, 2], [0, 1, 2, 3], [0, 2, 3]]])
def test_ply_has_faces_of_any_size(tmp_path, order, faces):
    (tmp_path / "a.ply").write_bytes(as_ply(order, faces))
    (mesh,) = mesh_files.read(tmp_path / "a.ply")
    expected = [[face[0], *face[k : k + 2]] for face in faces for k in range(1, len(face) - 1)]
    assert triangles_of(mesh) == expected
    assert mesh.arrays.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


@pytest.mark.parametrize("names", [("s", "t"), ("u", "v"), ("texture_u", "texture_v")])
def test_ply_texture_coordinates_of_vertices_are_read(tmp_path, names):
    more = "".join(f"property float {name}\n" for name in names)
    rows = [[0, 0], [1, 0], [1, 0.5], [0, 0.5]]
    (tmp_path / "a.ply").write_bytes(as_ply("binary_little_endian", [[0, 1, 2, 3]], more, rows))
    (mesh,) = mesh_files.read(tmp_path / "a.ply")
    assert mesh.arrays.corner_uvs.tolist() == rows


# ---- The other formats


def test_stl_is_welded_in_the_order_of_first_use(tmp_path):
    points, triangles = sphere()
    (tmp_path / "ball.stl").write_bytes(STL["binary"])
    (mesh,) = mesh_files.read(tmp_path / "ball.stl")
    assert len(mesh.arrays.positions) == len(points)
    assert np.array_equal(np.unique(mesh.arrays.corner_vertices, return_index=True)[1], np.sort(first_uses(mesh)))
    assert np.allclose(mesh.arrays.positions[mesh.arrays.triangle_vertices], points[triangles], atol=1e-6)
    assert "1,296 corners of 432 were welded into 218 vertices" in mesh.notes[0]


def first_uses(mesh):
    corners = mesh.arrays.corner_vertices.tolist()
    return [corners.index(vertex) for vertex in range(len(mesh.arrays.positions))]


def test_off_is_read(tmp_path):
    (mesh,) = read_text(tmp_path / "a.off", "OFF\n# square\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    assert len(mesh.arrays.triangle_corners) == 2
    assert len(mesh.arrays.positions) == 4


def test_gltf_has_a_mesh_for_each_node_with_its_place(tmp_path):
    nodes = [{"mesh": 0}, {"mesh": 0, "name": "moved", "translation": [1, 2, 3]}, {"mesh": 0, "name": "moved"}]
    (tmp_path / "two.glb").write_bytes(glb(*ball(nodes=nodes, scenes=[{"nodes": [2, 0, 1]}])))
    first, moved, again = mesh_files.read(tmp_path / "two.glb")
    assert [first.name, moved.name, again.name] == ["ball", "moved", "moved.001"]
    assert np.array_equal(moved.matrix_world[:3, 3], [1, 2, 3])
    assert np.allclose(first.arrays.positions, sphere()[0], atol=1e-6)
    assert np.array_equal(first.arrays.triangle_vertices, sphere()[1])


def test_gltf_parts_of_a_node_are_one_mesh(tmp_path):
    arrays = [np.eye(3, dtype="<f4"), 2 * np.eye(3, dtype="<f4")]
    parts = [{"attributes": {"POSITION": 0}}, {"attributes": {"POSITION": 1}}]
    (tmp_path / "a.glb").write_bytes(glb(*gltf(parts, arrays, [{"name": "thing", "mesh": 0, "scale": [2, 2, 2]}])))
    (mesh,) = mesh_files.read(tmp_path / "a.glb")
    assert mesh.name == "thing"
    assert triangles_of(mesh) == [[0, 1, 2], [3, 4, 5]]
    assert np.allclose(mesh.matrix_world, np.diag([2, 2, 2, 1]))


# ---- Polygons


def area(points, triangles):
    corners = points[triangles]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2


@pytest.mark.parametrize(
    "outline",
    [
        [(0, 0), (1, 0), (1, 1), (0, 1)],
        [(0, 0), (2, 0), (0.5, 0.5), (0, 2)],
        [(2, 0), (0.5, 0.5), (0, 2), (0, 0)],
        [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (3, 2), (3, 3), (0, 3)],
        [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)],
        [(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)],
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_triangles_cover_a_polygon_once(outline, turned):
    points = np.array([(*point, 0.0) for point in (outline[::-1] if turned else outline)], np.float32)
    around = np.arange(len(points), dtype=np.int32)
    triangles = polygons.PolygonMesh(points, around, np.array([len(points)])).arrays.triangle_corners
    flat = points[:, :2]
    whole = (flat[:, 0] * np.roll(flat[:, 1], -1) - flat[:, 1] * np.roll(flat[:, 0], -1)).sum() / 2
    areas = area(points, triangles)
    assert len(triangles) == len(points) - 2
    assert (areas * np.sign(whole) >= 0).all()
    assert np.isclose(areas.sum(), whole)


def test_faces_without_area_or_corners_do_not_shift_the_others():
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], np.float32)
    corners = np.array([0, 1, 0, 1, 2, 0, 1, 2, 3, 1, 1, 1, 1, 1], np.int32)
    triangles = polygons.PolygonMesh(points, corners, np.array([2, 3, 4, 0, 5])).arrays.triangle_corners
    assert triangles[:3].tolist() == [[2, 3, 4], [5, 6, 7], [5, 7, 8]]
    assert triangles.shape == (6, 3)
    assert set(triangles[3:].ravel()) == {9, 10, 11, 12, 13}


def test_a_polygon_that_crosses_itself_still_has_all_triangles():
    points = np.array([(0, 0, 0), (2, 2, 0), (2, 0, 0), (0, 2, 0), (1, 3, 0)], np.float32)
    assert polygons.PolygonMesh(points, np.arange(5), np.array([5])).arrays.triangle_corners.shape == (3, 3)


def test_letters_of_base64_get_no_more_padding_than_they_need(monkeypatch):
    given = []  # newer versions of Python refuse more

    def decoded(letters, validate):
        given.append((letters, validate))
        return bytes(6)

    monkeypatch.setattr(vtp_file.base64, "b64decode", decoded)
    assert vtp_file.from_base64(b"AAAAAAAAAAAA", 0, 4) == vtp_file.from_base64(b"AAAAAA==", 0, 4) == bytes(4)
    assert given == [(b"AAAAAAAA", True), (b"AAAAAA==", True)]
