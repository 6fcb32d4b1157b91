"""Values at faces are those of the surface at their middles, in the order of the faces, in arrays and in files."""

import numpy as np
import pytest

import paradesc
from paradesc import InputError, bridge
from paradesc.commands.main import main
from paradesc.core import face_centers, job
from paradesc.files import results, vtk_files
from shapes import as_arrays, cube_sphere, write_obj

LARGE, SMALL = 2.0, 0.7
NAMES = ("mean_curvature", "gaussian_curvature", "principal_direction_max")


def torus(around=96, across=40):
    """Positions, quads, and at any two angles the exact mean and Gaussian curvature."""
    u, v = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij")
    distance = LARGE + SMALL * np.cos(v)
    points = np.stack([distance * np.cos(u), distance * np.sin(u), SMALL * np.sin(v)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    at = lambda a, b: (a % around * across + b % across).reshape(-1)  # noqa: E731
    return points, np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], axis=1)


def exact(middles):
    """Mean and Gaussian curvature of the torus beside points (n, 3)."""
    angle = np.arctan2(middles[:, 2], np.hypot(middles[:, 0], middles[:, 1]) - LARGE)
    outer = np.cos(angle) / (LARGE + SMALL * np.cos(angle))
    return (1 / SMALL + outer) / 2, outer / SMALL


@pytest.fixture(scope="module")
def quads():
    return torus()


@pytest.fixture(scope="module")
def triangles(quads):
    points, faces = quads
    return points, np.concatenate([faces[:, :3], faces[:, [0, 2, 3]]])


def error(found, wanted):
    """The mean error in shares of the range."""
    return np.abs(found - wanted).mean() / np.ptp(wanted)


def test_faces_of_a_torus_have_its_curvature_at_their_middles(quads, triangles):
    for points, faces in (quads, triangles):
        found = paradesc.compute(points, faces, NAMES, 0.06, domain="faces")
        mean, gauss = exact(points[faces].mean(axis=1))
        assert found.domain == "faces"
        assert found["principal_direction_max"].shape == (len(faces), 3)
        at_vertices = paradesc.compute(points, faces, NAMES, 0.06)
        # Middles are as good as vertices are, whose own error is what this radius and these facets leave.
        for name, of_faces, of_vertices in zip(NAMES, (mean, gauss), exact(points), strict=False):
            assert error(found[name], of_faces) < 1.2 * error(at_vertices[name], of_vertices), name


def test_the_bits_of_a_face_do_not_depend_on_the_order_of_faces(triangles):
    points, faces = triangles
    order = np.random.default_rng(5).permutation(len(faces))
    one = paradesc.compute(points, faces, NAMES, 0.05, domain="faces")
    other = paradesc.compute(points, faces[order], NAMES, 0.05, domain="faces")
    for name in NAMES:
        # sums run over the faces in another order
        np.testing.assert_allclose(other[name], one[name][order], rtol=1e-4, atol=1e-5)


def test_a_triangle_is_a_face_that_is_measured_at_a_third_of_each_corner(triangles):
    """The library's own evaluation at places of a UV map, laid out by hand, says the same."""
    points, faces = triangles
    few = np.arange(0, len(faces), 97)
    corners = np.arange(faces.size, dtype=np.int32).reshape(-1, 3)
    arrays = bridge.MeshArrays(points, faces.reshape(-1).astype(np.int32), corners)
    side = 64
    uvs = np.zeros((len(faces), 3, 2), np.float32)
    places = np.column_stack([3 * (np.arange(len(few)) % 20), 3 * (np.arange(len(few)) // 20)]) + 1.5
    uvs[few] = (places[:, None] + [[-1, -0.5], [1, -0.5], [0, 1]]) / side
    arrays.corner_uvs = uvs.reshape(-1, 2)
    settings = job.Settings(("mean_curvature",), bridge.Options(radius=0.05, evaluate="texel", texels=side), "cpu")
    picture = job.run(arrays, settings).maps["mean_curvature"]
    column, row = np.floor(places).astype(int).T
    found = paradesc.compute(points, faces, radius=0.05, domain="faces")["mean_curvature"]
    np.testing.assert_allclose(found[few], picture[row, column], rtol=1e-4)  # rounding of the map's 32 bits


def test_faces_without_an_area_are_undefined_and_take_nothing_from_their_neighbors(triangles):
    points, faces = triangles
    flat = np.array([[0, 0, 1], [5, 6, 5]])
    every = np.concatenate([faces[:50], flat, faces[50:]])
    found = paradesc.compute(points, every, NAMES, 0.05, domain="faces")
    assert np.isnan(found["mean_curvature"][50:52]).all()
    assert found.mask[50:52].tolist() == [1, 1]
    assert np.isnan(found.coverage[50:52]).all()
    rest = np.delete(found["mean_curvature"], [50, 51])
    sound = paradesc.compute(points, faces, radius=0.05, domain="faces")["mean_curvature"]
    np.testing.assert_allclose(rest, sound, rtol=1e-4)  # sums run over the faces in another order
    assert found.report["field_report"]["undefined_vertices"] == 2


def test_polygons_are_measured_at_their_middles_wherever_their_triangles_meet():
    corners = np.array([[0, 0], [2, 0], [2, 2], [1, 0.5], [0, 2]])
    polygon = np.column_stack([corners, np.zeros(5)])
    triangle_corners = polygon[[[0, 1, 3], [1, 2, 3], [0, 3, 4]]]
    chosen, weights = face_centers.middles(triangle_corners, np.zeros(3, int), 1)
    place = weights[0] @ triangle_corners[chosen[0]]
    one, other = triangle_corners[:, 1] - triangle_corners[:, 0], triangle_corners[:, 2] - triangle_corners[:, 0]
    area = np.linalg.norm(np.cross(one, other), axis=1)
    middle = (triangle_corners.mean(axis=1) * area[:, None]).sum(axis=0) / area.sum()
    assert np.linalg.norm(place - middle) < 0.15  # the middle lies beside the polygon, and is brought into it
    square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]], float)
    chosen, weights = face_centers.middles(square, np.zeros(2, int), 1)
    np.testing.assert_allclose(weights[0] @ square[chosen[0]], [0.5, 0.5, 0], atol=1e-12)


def test_a_mask_of_a_face_says_that_a_boundary_cuts_its_neighborhood(triangles):
    points, faces = triangles
    middles = points[faces].mean(axis=1)
    half = middles[:, 0] > 0
    found = paradesc.compute(points, faces[half], radius=0.05, domain="faces")
    edges = np.sort(np.concatenate([faces[half][:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    edges, uses = np.unique(edges, axis=0, return_counts=True)
    begins, ways = points[edges[uses == 1, 0]], points[edges[uses == 1, 1]] - points[edges[uses == 1, 0]]
    offsets = middles[half][:, None] - begins
    along = np.clip((offsets * ways).sum(axis=2) / (ways * ways).sum(axis=1), 0, 1)
    distances = np.linalg.norm(offsets - along[:, :, None] * ways, axis=2).min(axis=1)
    certain = np.abs(distances / found.radius - 1) > 1e-4  # floats round positions
    np.testing.assert_array_equal(found.mask[certain], np.where(distances < found.radius, 2, 0)[certain])
    assert 0 < (found.mask == 2).mean() < 0.5


def test_several_radii_and_masks_have_values_at_faces_too(triangles):
    points, faces = triangles
    found = paradesc.compute(points, faces, ["cavity", "harris"], [0.05, 0.1], domain="faces")
    assert list(found) == ["cavity_r0.05", "harris_r0.05", "cavity_r0.1", "harris_r0.1"]
    assert all(values.shape == (len(faces),) for values in found.values())
    assert len(found.corners) == 0
    assert str(found).startswith(f"{len(faces):,} faces")
    assert found.report["mesh_report"]["charts"] == 0


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"domain": "edges"}, "domain is 'edges'; choose one of vertices, faces"),
        ({"backend": "reference"}, "Values at faces are computed on the processor alone"),
        ({"evaluate": "texel"}, "Values at faces are computed on the processor alone"),
        ({"relocation": "paper"}, "Values at faces are computed on the processor alone"),
    ],
)
def test_what_is_not_measured_at_faces_is_refused(triangles, words, sentence):
    with pytest.raises(InputError, match=sentence):
        paradesc.compute(*triangles, **{"domain": "faces", **words})


def test_a_mesh_that_is_kept_says_who_has_values_at_faces(triangles):
    with paradesc.Mesh(*triangles) as mesh, pytest.raises(TypeError, match="has values at vertices"):
        mesh.compute(domain="faces")


def test_more_faces_than_the_map_has_texels_are_refused(triangles, monkeypatch):
    monkeypatch.setattr(face_centers.texel_centers, "LARGEST_MAP", 16)
    with pytest.raises(InputError, match="The mesh has 7,680 faces; values at faces end at 256"):
        paradesc.compute(*triangles, domain="faces")


def test_trimesh_and_pyvista_get_values_of_faces(pyvista):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
    result = paradesc.compute(mesh, radius=0.1, domain="faces")
    assert np.array_equal(result.to(mesh).face_attributes["mean_curvature"], result["mean_curvature"])
    poly = pyvista.wrap(mesh)
    assert np.array_equal(result.to(poly).cell_data["mean_curvature"], result["mean_curvature"])
    with pytest.raises(InputError, match="The mesh has 20 faces, but the result belongs to one with 1280"):
        result.to(trimesh.creation.icosphere(subdivisions=0))


# ---- Files


@pytest.fixture(scope="module")
def baked():
    arrays = as_arrays(*cube_sphere(4))
    names = ("mean_curvature", "principal_direction_max")
    settings = job.Settings(names, bridge.Options(radius=0.1), "cpu", domain="faces")
    return results.Baked("sphere", face_centers.run(arrays, settings), arrays, np.eye(4))


@pytest.mark.parametrize("suffix", ["vtp", "vtk"])
def test_vtk_finds_values_of_faces_as_cell_data(tmp_path, baked, pyvista, suffix):
    path = tmp_path / f"a.{suffix}"
    {"vtp": vtk_files.write_vtp, "vtk": vtk_files.write_vtk}[suffix](path, baked)
    found = pyvista.read(path)
    assert not found.point_data
    for name, values in {**baked.results.values, **baked.results.extras}.items():
        assert np.array_equal(found.cell_data[name], values, equal_nan=True), name


def test_ply_and_npz_hold_values_of_faces(tmp_path, baked):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    results.write_ply(tmp_path / "a.ply", baked)
    mesh = trimesh.load(tmp_path / "a.ply", process=False)
    raw = mesh.metadata["_ply_raw"]["face"]["data"]
    assert np.array_equal(raw["mean_curvature"].reshape(-1), baked.results.values["mean_curvature"])
    directions = baked.results.values["principal_direction_max"]
    assert np.array_equal(raw["principal_direction_max_z"].reshape(-1), directions[:, 2])
    assert np.array_equal(mesh.faces, baked.arrays.triangle_vertices)
    results.write_npz(tmp_path / "a.npz", [baked])
    kept = np.load(tmp_path / "a.npz")
    assert np.array_equal(kept["triangles"], baked.arrays.triangle_vertices)
    assert np.array_equal(kept["mean_curvature"], baked.results.values["mean_curvature"])


@pytest.mark.slow
def test_the_command_line_writes_values_of_faces_of_one_object_and_of_several(tmp_path, capsys):
    path = write_obj(tmp_path / "a.obj", *cube_sphere(4))
    path.write_text(f"{path.read_text()}o two\nv 9 0 0\nv 9 1 0\nv 9 0 1\nf -3 -2 -1\n")
    outputs = [word for suffix in ("npz", "vtp", "vtk", "ply") for word in ("-o", str(tmp_path / f"b.{suffix}"))]
    words = ["bake", str(path), "--reader", "files", "--radius", "0.2", "--domain", "faces", *outputs]
    assert main([*words, "--json", str(tmp_path / "b.json"), "--fail-over-undefined", "0"]) == 0
    assert "undefined faces 0" in capsys.readouterr().out
    assert '"domain": "faces"' in (tmp_path / "b.json").read_text()
    assert np.load(tmp_path / "b.npz")["mean_curvature"].shape == (192,)
    assert main([*words, "--all"]) == 0
    both = np.load(tmp_path / "b.npz")
    assert (both["sphere/mean_curvature"].shape, both["two/mean_curvature"].shape) == ((192,), (1,))
    assert b"element face 193" in (tmp_path / "b.ply").read_bytes()
    assert b'NumberOfPolys="193"' in (tmp_path / "b.vtp").read_bytes()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["-o", "a.gii"], '"a.gii" holds no values of faces; give one of .npz, .ply, .vtp, .vtk.'),
        (["-o", "a.curv"], "holds no values of faces"),
        (["-o", "a.blend"], "holds no values of faces"),
        (["-o", "a.exr"], "holds no values of faces"),
        (["--map", "a.png"], "--map has nothing to do with values of faces; leave it or --domain out."),
        (["-o", "a.npz", "--corners", "a.json", "--descriptors", "harris"], "--corners has nothing to do"),
        (["-o", "a.npz", "--from-file", "b.obj"], "--from-file has nothing to do"),
    ],
)
def test_what_holds_no_values_of_faces_is_refused(tmp_path, monkeypatch, capsys, words, sentence):
    monkeypatch.chdir(tmp_path)
    assert main(["bake", "a.obj", "--domain", "faces", *words]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--backend", "reference"], ["--evaluate", "texel"], ["--precision", "half"]])
def test_options_that_do_not_go_with_faces_are_a_fault_of_the_arguments(tmp_path, capsys, words):
    path = write_obj(tmp_path / "a.obj", *cube_sphere(4))
    words = ["--reader", "files", "--domain", "faces", "-o", str(tmp_path / "a.npz"), *words]
    assert main(["bake", str(path), *words]) == 2
    assert "Values at faces are computed on the processor alone" in capsys.readouterr().err
