"""The Python package: compute() and Mesh on arrays of every kind, and on meshes of other packages, without Blender."""

import re
import subprocess
import sys
from dataclasses import fields
from importlib import import_module

import numpy as np
import pytest

import paradesc
from conftest import blender_program
from paradesc import InputError, ParadescError, bridge
from paradesc.core import contexts, members
from shapes import ADDON, ROOT, cube_sphere

PAGE = ADDON / "manual" / "python.md"
NAMES = ("mean_curvature", "gaussian_curvature", "principal_direction_max")
# Tests of other processes: the interpreter beside Blender's executable need not have numpy.
of_python = pytest.mark.skipif(bool(blender_program()), reason="runs in Python itself, not in Blender's executable")


def torus(along=160, around=64, small=0.4):
    """Positions, quads, and mean and Gaussian curvature of a torus whose larger radius is 1."""
    u, v = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a, b = 2 * np.pi * u / along, 2 * np.pi * v / around
    ring = 1 + small * np.cos(b)
    points = np.stack([ring * np.cos(a), ring * np.sin(a), small * np.sin(b)], axis=2).reshape(-1, 3)
    corners = [((u + i) % along) * around + (v + j) % around for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    gaussian = (np.cos(b) / (small * ring)).reshape(-1)
    return points, np.stack(corners, axis=2).reshape(-1, 4), (1 / small + gaussian * small).reshape(-1) / 2, gaussian


def test_principal_directions_of_a_plane_are_some_orthogonal_tangents():
    points = np.stack([*np.meshgrid(np.arange(9.0), np.arange(9.0)), np.zeros((9, 9))], axis=2).reshape(-1, 3)
    faces = np.arange(72).reshape(8, 9)[:, :8].reshape(-1, 1) + [0, 1, 10, 9]
    names = ("principal_direction_max", "principal_direction_min", "shape_index")
    first, second, index = paradesc.compute(points, faces, names, radius=2.0, radius_unit="absolute").values()
    np.testing.assert_allclose(np.linalg.norm(np.cross(first, second)[:, :2], axis=1), 0, atol=1e-6)
    np.testing.assert_allclose(np.abs(np.cross(first, second)[:, 2]), 1, atol=1e-6)
    assert np.isnan(index).all()


@pytest.fixture(scope="module")
def sphere():
    """Positions, quads, and their UVs (m, 4, 2)."""
    return cube_sphere(8)


def same(first, second):
    """Returns whether two results have the same bits."""
    return list(first) == list(second) and all(first[name].tobytes() == second[name].tobytes() for name in first)


# ---- Values


def test_torus_has_the_curvatures_of_its_closed_forms():
    points, quads, mean, gaussian = torus()
    result = paradesc.compute(points, quads, ["mean_curvature", "gaussian_curvature"], 0.02)
    for name, exact in (("mean_curvature", mean), ("gaussian_curvature", gaussian)):
        error = np.abs(result[name] - exact).mean() / np.ptp(exact)
        assert error < 0.002, name  # of the range; O(r²) and the facets are the rest


def test_results_say_all_about_themselves(sphere):
    points, quads, _ = sphere
    result = paradesc.compute(points, quads, NAMES, 0.1)
    assert tuple(result) == NAMES
    assert result["principal_direction_max"].shape == points.shape
    assert all(values.dtype == np.float32 for values in result.values())
    assert result.units == dict(zip(NAMES, ("1/length", "1/length^2", ""), strict=True))
    assert result.radius == pytest.approx(0.1 * np.linalg.norm(np.ptp(points, axis=0)))
    assert result.coverage.shape == result.mask.shape == (len(points),)
    assert result.report["mesh_report"]["triangle_count"] == 2 * len(quads)
    assert re.search(r"^mean_curvature: \S+ to \S+, median 0\.5\d* 1/length$", repr(result), re.M)
    with pytest.raises(KeyError, match="was not computed"):
        result["shape_index"]


def test_what_does_not_exist_is_nan_and_counted():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]])
    result = paradesc.compute(square, [[0, 1, 2, 3]], "shape_index", 0.5)
    assert np.isnan(result["shape_index"]).all()
    assert "shape_index: all undefined" in repr(result)
    assert result.mask[4] == 1


def test_several_radii_are_named_as_on_the_command_line(sphere):
    points, quads, _ = sphere
    result = paradesc.compute(points, quads, "mean_curvature", (0.1, 0.25))
    assert list(result) == ["mean_curvature_r0.1", "mean_curvature_r0.25"]
    assert result.radii["mean_curvature_r0.25"] == pytest.approx(2.5 * result.radius)
    alone = paradesc.compute(points, quads, "mean_curvature", 0.25)
    assert alone["mean_curvature"].tobytes() == result["mean_curvature_r0.25"].tobytes()


def test_values_do_not_depend_on_the_number_of_threads(sphere):
    points, quads, _ = sphere
    one, all_of_them = (paradesc.compute(points, quads, radius=0.1, threads=count) for count in (1, 0))
    assert same(one, all_of_them)


def test_a_mesh_far_from_the_origin_loses_nothing(sphere):
    points, quads, _ = sphere
    far_off = np.array([5e6, 0, -3e7])
    far = paradesc.compute(points + far_off, quads, radius=0.1)
    near = paradesc.compute(points, quads, radius=0.1)
    assert np.abs(far["mean_curvature"] - near["mean_curvature"]).max() < 1e-5
    rounded = paradesc.compute((points + far_off).astype(np.float32), quads, radius=0.1)
    assert np.nanmax(np.abs(rounded["mean_curvature"] - near["mean_curvature"])) > 1e-2  # it was lost before


def test_corners_are_given_with_harris():
    corner = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3, indexing="ij"), axis=3).reshape(-1, 3)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    assert paradesc.compute(corner, faces, "harris", 0.1).corners.dtype == np.int32


# ---- What is taken


@pytest.mark.parametrize(
    ("points_as", "faces_as"),
    [
        (lambda a: a.astype(">f8"), lambda a: a.astype(">i8")),
        (np.asfortranarray, np.asfortranarray),
        (lambda a: np.repeat(a, 2, axis=0)[::2], lambda a: np.repeat(a, 2, axis=1)[:, ::2]),
        (lambda a: a.tolist(), lambda a: a.tolist()),
        (lambda a: a.astype(np.longdouble), lambda a: a.astype(np.uint16)),
        (lambda a: a, lambda a: a.astype(np.float64)),
    ],
    ids=["other byte order", "columns", "strides", "lists", "other types", "whole floats"],
)
def test_every_kind_of_array_gives_the_same_bits_and_stays_as_it_was(sphere, points_as, faces_as):
    points, quads, _ = sphere
    given, faces = points_as(points), faces_as(quads)
    for array in (given, faces):
        if isinstance(array, np.ndarray):
            array.flags.writeable = False
    assert same(paradesc.compute(given, faces, radius=0.1), paradesc.compute(points, quads, radius=0.1))
    assert np.array_equal(given, points)
    assert np.array_equal(faces, quads)


def test_uvs_belong_to_vertices_to_corners_or_to_faces(sphere):
    points, quads, uvs = sphere
    options = {"radius": 0.2, "backend": "cpu", "evaluate": "texel", "texels": 64}
    found = [paradesc.compute(points, quads, uvs=given, **options) for given in (uvs, uvs.reshape(-1, 2))]
    assert same(*found)
    with pytest.raises(InputError, match=r"uvs has the shape \(3, 2\), but"):
        paradesc.compute(points, quads, uvs=uvs[0, :3])
    assert len(paradesc.compute(points, quads, uvs=points[:, :2], **options)) == 1


def test_normals_of_the_mesh_are_used(sphere):
    points, quads, _ = sphere
    own = points / np.linalg.norm(points, axis=1, keepdims=True)
    given = paradesc.compute(points, quads, radius=0.1, normals="mesh", corner_normals=own)
    assert np.abs(given["mean_curvature"] - 0.5).max() < 0.01


def test_sharp_edges_count(sphere):
    points, quads, _ = sphere
    edges = quads[:8, :2]
    marked = paradesc.compute(points, quads, radius=0.1, sharp_edges=edges, creases="marked")
    assert marked.report["field_report"]["crease_edges"] > 0
    assert same(
        paradesc.compute(points, quads, radius=0.1, sharp_edges=[]), paradesc.compute(points, quads, radius=0.1)
    )


def test_polygons_of_several_sizes_are_one_mesh(sphere):
    points, quads, _ = sphere
    mixed = [*quads[1:].tolist(), quads[0, [0, 1, 2]].tolist(), tuple(quads[0, [0, 2, 3]])]
    result = paradesc.compute(points, mixed, radius=0.1)
    assert result.report["mesh_report"]["boundary_edges"] == 0
    assert np.abs(result["mean_curvature"] - 0.5).max() < 0.01


# ---- What is refused

POINTS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
NAN = float("nan")


def changed(rows, row, column, value):
    """A copy with another value in one place."""
    found = [list(one) for one in rows]
    found[row][column] = value
    return found


@pytest.mark.parametrize(
    ("vertices", "faces", "sentence"),
    [
        (changed(POINTS, 2, 1, NAN), FACES, r"Vertex 2 is at \(0, nan, 0\); positions have to be finite numbers\."),
        (changed(POINTS, 0, 0, float("inf")), FACES, "Vertex 0 is at"),
        ([row[:2] for row in POINTS], FACES, r"vertices has the shape \(4, 2\), but \(n, 3\) is needed\."),
        (np.zeros((0, 3)), FACES, "vertices is empty"),
        ([], FACES, r"vertices has the shape \(0,\)"),
        ("abc", FACES, "vertices holds text"),
        ([["a", "b", "c"]], FACES, "vertices holds text"),
        (np.array(POINTS, object), FACES, "vertices holds Python objects"),
        (np.array(POINTS) * 1j, FACES, "vertices holds complex numbers"),
        (np.array(POINTS, bool), FACES, "vertices holds truth values"),
        (np.ma.masked_equal(POINTS, 1), FACES, "vertices has masked values"),
        ([[0, 0, 0], [1, 0]], FACES, "vertices cannot be read as an array"),
        (np.array(POINTS) * 1e200, FACES, "more than 32-bit floats hold"),
        (POINTS, None, "faces is missing"),
        (object(), "curvedness", "faces is 'curvedness'; give it as descriptors= if a mesh is in place of two arrays."),
        (object(), ["curvedness"], r"faces is \['curvedness'\]; give it as descriptors="),
        (POINTS, changed(FACES, 3, 1, 4), "Face 3 names vertex 4, but there are 4 vertices, counted from 0."),
        (POINTS, changed(FACES, 1, 0, -1), "Face 1 names vertex -1"),
        (POINTS, changed(FACES, 1, 0, 1.5), "faces has the value 1.5 in row 1; vertices are whole numbers."),
        (POINTS, changed(FACES, 1, 0, NAN), "faces has the value nan in row 1"),
        (POINTS, [[0, 1, 2], [0, 1]], "Face 1 has 2 corners; at least three are needed."),
        (POINTS, [[0, 1, 2], [0, 1, 2, 9]], "Face 1 names vertex 9"),
        (POINTS, [0, 1, 2], r"faces has the shape \(3,\), but \(m, 3\) triangles"),
        (POINTS, [], "faces"),
        (POINTS, np.zeros((0, 3), int), "faces is empty"),
        (POINTS, np.zeros((2, 2, 2), int), "faces has the shape"),
        (POINTS, "012", "faces holds text"),
        (POINTS, np.array([[0, 1, 2], [0, 1]], object), "faces holds Python objects"),
        (POINTS, {0: 1}, "faces holds Python objects"),
        (7, FACES, "vertices has the shape"),
    ],
)  # fmt: skip
def test_arrays_that_cannot_be_used_are_refused_by_one_sentence(vertices, faces, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        paradesc.compute(vertices, faces)
    assert isinstance(caught.value, ValueError)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"radius": 0}, "radius is 0; it has to be above 0."),
        ({"radius": -1}, "radius is -1; it has to be above 0."),
        ({"radius": NAN}, "radius is nan; a finite number is needed."),
        ({"radius": "0.1"}, "radius is '0.1'; a finite number is needed."),
        ({"radius": True}, "radius is True"),
        ({"radius": ()}, "radius is empty"),
        ({"radius": (0.1, 0.1)}, "A radius is listed twice."),
        ({"radius": (0.1, 0.10000001)}, "The radii 0.1 and 0.10000001 are the same to six digits, .* end in _r0.1;"),
        ({"radius": 1e300}, r"The radius is \d[.0-9]*e\+300, but the mesh's diagonal is only"),
        ({"radius": 10}, "diagonal"),
        ({"descriptors": "wobbliness"}, "There is no descriptor 'wobbliness'; choose from .*mean_curvature"),
        ({"descriptors": ()}, "No descriptor is chosen"),
        ({"descriptors": 3}, "descriptors is 3"),
        ({"descriptors": ["mean_curvature"] * 2}, "listed twice"),
        ({"samples": 1.5}, "samples is 1.5; a whole number is needed."),
        ({"samples": 1}, "samples"),
        ({"radius_unit": "meters"}, "radius_unit is 'meters'; choose one of diagonal, absolute, mean-edge."),
        ({"normals": None}, "normals is None; choose one of fitted, max, mesh."),
        ({"map_descriptor": "x"}, "map_descriptor is 'x'; choose one of"),
        ({"backend": "tpu"}, "backend is 'tpu'; choose one of auto, gpu"),
        ({"threads": -1}, "threads is -1; it has to be between 0 and 4096."),
        ({"memory_limit": 2**70}, "memory_limit is"),
        ({"progress": 3}, "progress is 3; give a function"),
        ({"uvs": [[NAN, 0]] * 4}, "uvs is not a finite 32-bit float at corner 0"),
        ({"sharp_edges": [[0, 4]]}, "Sharp edge 0 names vertex 4"),
        ({"sharp_edges": [[0, 1, 2]]}, r"sharp_edges has the shape \(1, 3\)"),
        ({"normals": "mesh"}, "corner_normals is missing"),
        ({"backend": "software"}, "UV"),
    ],
)
def test_options_that_make_no_sense_are_refused_by_one_sentence(options, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        paradesc.compute(POINTS, FACES, **options)
    assert "\n" not in str(caught.value)


def limits():
    """Options that are numbers, with the limits that the panel and presets have."""
    known = [field.name for field in fields(bridge.Options)]
    found = [row for group in members.GROUPS for row in group().items()]
    return {name: one.words for name, one in found if name in known and one.kind in ("int", "float")}


@pytest.mark.parametrize("name", [*limits(), "corner_threshold"])
def test_limits_are_those_of_the_panel(sphere, name):
    words = limits().get(name, {"min": 1e-4, "max": 1.0})  # the panel has percent
    for side, step in (("min", -1), ("max", 1)):
        if side in words:
            paradesc.compute(*sphere[:2], "harris", 0.3, backend="cpu", **{name: words[side]})
            with pytest.raises(InputError, match=name.split("_")[0]):
                paradesc.compute(*sphere[:2], "harris", 0.3, backend="cpu", **{name: words[side] + step})


def test_too_little_memory_is_no_input_error(sphere):
    points, quads, _ = sphere
    with pytest.raises(ParadescError) as caught:
        paradesc.compute(points, quads, memory_limit=1000)
    assert not isinstance(caught.value, InputError)


# ---- Frames


def test_frames_have_the_bits_of_new_meshes_whatever_came_before(sphere):
    points, quads, _ = sphere
    with paradesc.Mesh(points, quads) as mesh:
        for scale, names, radius in ((1.0, NAMES, 0.1), (1.5, "curvedness", (0.1, 0.2)), (0.5, NAMES, 0.15)):
            mesh.positions = frame = points * [1, scale, 1]
            assert same(mesh.compute(names, radius), paradesc.compute(frame, quads, names, radius))
        assert mesh.report["diagonal"] == pytest.approx(np.linalg.norm(np.ptp(frame, axis=0)), rel=1e-5)
        assert np.array_equal(mesh.positions, frame)
        with pytest.raises(ValueError, match="read-only"):
            mesh.positions[0] = 0


def test_a_quad_that_becomes_concave_is_cut_otherwise():
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0.1], [0, 2, 0]], float)
    with paradesc.Mesh(points, [[0, 1, 2, 3]]) as mesh:
        mesh.compute("mean_curvature", 0.5)
        mesh.positions = bent = points * 1.0
        bent[1, :2] = (0.5, 0.9)
        mesh.positions = bent
        assert same(mesh.compute("mean_curvature", 0.5), paradesc.compute(bent, [[0, 1, 2, 3]], radius=0.5))


def test_positions_of_another_mesh_are_refused_and_the_old_ones_stay(sphere):
    points, quads, _ = sphere
    mesh = paradesc.Mesh(points, quads)
    before = mesh.compute(radius=0.1)
    for wrong, sentence in ((points[1:], "positions has the shape"), (points * NAN, "Vertex 0 is at")):
        with pytest.raises(InputError, match=sentence):
            mesh.positions = wrong
    assert same(mesh.compute(radius=0.1), before)
    mesh.close()
    mesh.close()
    with pytest.raises(ParadescError, match="The mesh is closed"):
        mesh.compute()


def test_a_mesh_that_nobody_holds_leaves_its_device_to_the_next(sphere):
    points, quads, _ = sphere
    used = len(contexts.POOL.used)
    for _ in range(5):
        paradesc.Mesh(points, quads).compute(radius=0.1)
    paradesc.compute(points, quads, radius=0.1)
    assert len(contexts.POOL.used) == used
    assert len(contexts.POOL.idle) <= contexts.MOST_IDLE


# ---- Hostile inputs


@pytest.mark.slow
@of_python
def test_hostile_inputs_give_a_result_or_one_sentence():
    words = [sys.executable, "-W", "ignore", str(ROOT / "tests" / "fuzz" / "python_inputs.py"), "--inputs", "2000"]
    done = subprocess.run(
        words, capture_output=True, text=True, timeout=200, env={"PYTHONPATH": str(ADDON)}, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


# ---- The package


@of_python
def test_the_package_offers_its_names_without_reading_them_early():
    code = "import sys, paradesc\n"
    code += "assert not [name for name in sys.modules if name == 'numpy' or name.startswith('paradesc.')]\n"
    code += "from paradesc import *\nassert compute and Mesh and descriptors()\n"
    code += "names = {name for name in dir(paradesc) if not name.startswith('__')}\nassert names == set(paradesc.__all__)\n"
    code += "try:\n    paradesc.wobble\nexcept AttributeError as error:\n    print(error)"
    done = subprocess.run([sys.executable, "-c", code], env={"PYTHONPATH": str(ADDON)}, capture_output=True, text=True,
                          check=False)  # fmt: skip
    assert done.stdout == "module 'paradesc' has no attribute 'wobble'\n", done.stderr
    assert (ADDON / "paradesc" / "py.typed").is_file()


@pytest.mark.slow
def test_a_users_program_is_typed(tmp_path):
    api = pytest.importorskip("mypy.api", reason="mypy is not installed")
    program = tmp_path / "program.py"
    program.write_text(
        "import numpy as np\nimport paradesc\nfrom numpy.typing import NDArray\n\n"
        "def curvature(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float32]:\n"
        "    result = paradesc.compute(points, faces, ['mean_curvature'], (0.01, 0.02), harris_k=0.05)\n"
        "    print(result.units, result.radius, paradesc.__version__, paradesc.descriptors()[0].unit)\n"
        "    with paradesc.Mesh(points, [[0, 1, 2], [0, 1, 2, 3]], threads=2) as mesh:\n"
        "        mesh.positions = points\n"
        "        found: paradesc.Result = mesh.compute('shape_index', progress=lambda stage, fraction: True)\n"
        "    return found['shape_index']\n"
    )
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import paradesc\nparadesc.compute([], sampels=3)\nparadesc.compute([], normals='x')\n")
    words = ["--strict", "--no-incremental", "--follow-imports=silent", f"--cache-dir={tmp_path}"]
    out, *_ = api.run([*words, str(program)])
    assert "Success" in out, out
    out, *_ = api.run([*words, str(wrong)])
    assert "sampels" in out
    assert 'argument "normals"' in out.lower() or "normals" in out


def blocks():
    """The Python of the manual's page."""
    return re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)


@pytest.mark.usefixtures("pyvista")
def test_the_manuals_code_runs(tmp_path, monkeypatch):
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    monkeypatch.chdir(tmp_path)
    for name in ("part.ply", "other.ply"):
        trimesh.creation.icosphere(subdivisions=3).export(name)
    assert import_module("paradesc.pyvista_accessor")  # which an installed package finds by its entry point

    names = {}
    assert len(blocks()) >= 6
    for code in blocks():
        if "open3d" not in code:
            exec(compile(code, str(PAGE), "exec"), names)
    assert (tmp_path / "directions.vtp").is_file()


def test_curvature_of_ribbons_exists_as_far_as_the_manual_says():
    x = np.linspace(0, 1, 201)
    first = np.arange(200)
    quads = np.stack([first, first + 1, first + 202, first + 201], axis=1)
    for share, backend, exists in ((150, "cpu", True), (500, "cpu", False), (500, "reference", True)):
        points = np.stack([np.tile(x, 2), np.repeat([0, 0.1 / share], 201), np.zeros(402)], axis=1)
        found = paradesc.compute(points, quads, radius=0.1, radius_unit="absolute", backend=backend)["mean_curvature"]
        assert np.isfinite(found).all() == exists
        assert np.isnan(found).all() != exists
    assert "thinner than about 1/200 of the radius" in (ADDON / "manual" / "reference.md").read_text(encoding="utf-8")
