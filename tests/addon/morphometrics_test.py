"""surface_morphometrics 2 finds the command `paradesc`, which writes what its next steps read.

That package, and graph-tool, are installed by conda alone. In their place stand stubs of just what is used:
`load_config` of surface_morphometrics/config_utils.py, as it is in 2.0.0b2 (repository
GrotjahnLab/surface_morphometrics, commit e7f8683), and graph-tool's Graph by its manual. So these tests do not say that
the real packages were run. On 2026-11-27 the sources of that commit were: `morphometrics --help` lists the command,
`morphometrics paradesc config.yml` writes the files of a sphere, and `morphometrics export_obj` makes a colored .obj of
them. No real graph-tool has read a .gt.
"""

import csv
import math
import sys
import types

import numpy as np
import pytest

from paradesc.files import mesh_files, vtk_files
from shapes import ADDON, cube_sphere

click = pytest.importorskip("click", reason="click is not installed")
from click.testing import CliRunner  # noqa: E402

from paradesc import morphometrics  # noqa: E402

RADIUS, HIT = 10.0, 4


@pytest.fixture
def config(tmp_path, monkeypatch):
    """A config.yml, and the stub of the module that reads it."""

    def load_config(configfile, require=()):
        assert require == ("work_dir",)
        assert configfile == str(tmp_path / "config.yml")
        return {"work_dir": f"{tmp_path}/", "curvature_measurements": {"radius_hit": HIT, "exclude_borders": 1}}

    package, module = types.ModuleType("surface_morphometrics"), types.ModuleType("surface_morphometrics.config_utils")
    module.load_config = load_config
    monkeypatch.setitem(sys.modules, package.__name__, package)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    (tmp_path / "config.yml").write_text("work_dir: .\n")
    return tmp_path / "config.yml"


def surface(folder, name="TE1_IMM", inwards=True):
    """A sphere as make_meshes writes it, wound as PyCurv wants it, and its triangles."""
    points, quads, _ = cube_sphere(12)
    points = RADIUS * points / np.linalg.norm(points, axis=1, keepdims=True)
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]).astype("<i4")
    triangles = triangles[:, ::-1].copy() if inwards else triangles
    flat = triangles[:1].copy()
    flat[:, 1] = flat[:, 0]  # PyCurv leaves out what has no area
    values = {"label": np.ones(len(points), "<f4")}
    vtk_files.write_polydata(
        folder / f"{name}.surface.vtp", points.astype("<f4"), np.concatenate([flat, triangles]), values, False
    )
    return points, triangles


def run(*words):
    return CliRunner().invoke(morphometrics.command, list(map(str, words)))


def table(path):
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def test_the_entry_point_names_the_command():
    tomllib = pytest.importorskip("tomllib", reason="Python 3.10 has none")
    listed = tomllib.loads((ADDON.parent / "pyproject.toml").read_text())["project"]["entry-points"]
    assert listed["morphometrics.commands"] == {"paradesc": "paradesc.morphometrics:command"}
    assert isinstance(morphometrics.command, click.Command)
    assert "pycurv" in morphometrics.command.get_short_help_str(200)


@pytest.mark.filterwarnings("error")  # the winding that PyCurv wants is no fault
def test_every_triangle_of_a_sphere_has_pycurvs_quantities_with_its_signs(config):
    points, triangles = surface(config.parent)
    done = run(config)
    assert done.exit_code == 0, done.output
    assert "TE1_IMM.AVV_rh4.vtp, TE1_IMM.AVV_rh4.csv" in done.output
    found = table(config.parent / "TE1_IMM.AVV_rh4.csv")
    assert np.array_equal(found["index"], np.arange(len(triangles)))
    for name, wanted in {
        "kappa_1": 0.1, "kappa_2": 0.1, "mean_curvature_VV": 0.1, "gauss_curvature_VV": 0.01, "curvedness_VV": 0.1,
        "coverage": 1,
    }.items():  # fmt: skip
        np.testing.assert_allclose(found[name], wanted, rtol=0.03)  # what facets of 10 degrees leave
    assert (found["shape_index_VV"] > 0.9).all()  # a cap, seen from the side of the normals
    assert (found["kappa_1"] >= found["kappa_2"]).all()
    middles = points[triangles].mean(axis=1)
    inward = -middles / np.linalg.norm(middles, axis=1, keepdims=True)
    for name, exact in (("n_v", inward), ("xyz", middles)):
        vector = np.column_stack([found[f"{name}_{axis}"] for axis in "xyz"])
        np.testing.assert_allclose(vector, exact, atol=0.02)
    np.testing.assert_allclose(found["area"].sum(), 4 * math.pi * RADIUS**2, rtol=0.02)


def test_the_vtp_holds_the_same_as_cell_data(config):
    vtk = pytest.importorskip("vtk", reason="VTK is not installed")
    from vtk.util.numpy_support import vtk_to_numpy

    surface(config.parent)
    run(config, "TE1_IMM.surface.vtp")
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(config.parent / "TE1_IMM.AVV_rh4.vtp"))
    reader.Update()
    cells, found = reader.GetOutput().GetCellData(), table(config.parent / "TE1_IMM.AVV_rh4.csv")
    for name in ("kappa_1", "shape_index_VV", "area"):
        np.testing.assert_allclose(vtk_to_numpy(cells.GetArray(name)), found[name], rtol=1e-6)
    assert cells.GetArray("n_v").GetNumberOfComponents() == 3
    assert reader.GetOutput().GetNumberOfCells() == len(found["index"])


def test_a_surface_wound_outwards_has_the_other_sign(config):
    surface(config.parent, inwards=False)
    assert run(config).exit_code == 0
    np.testing.assert_allclose(table(config.parent / "TE1_IMM.AVV_rh4.csv")["kappa_2"], -0.1, rtol=0.03)


def test_results_that_are_there_stay_unless_they_may_be_replaced(config):
    surface(config.parent)
    theirs = config.parent / "TE1_IMM.AVV_rh4.csv"
    theirs.write_text("from PyCurv")
    done = run(config)
    assert done.exit_code == 1
    assert "TE1_IMM.AVV_rh4.csv exists already; add --force to overwrite it." in done.output
    assert theirs.read_text() == "from PyCurv"
    assert not (config.parent / "TE1_IMM.AVV_rh4.vtp").exists()
    assert run(config, "-f").exit_code == 0
    assert "kappa_1" in theirs.read_text()


def test_a_surface_that_cannot_be_read_does_not_keep_the_others_from_it(config):
    surface(config.parent, "good")
    (config.parent / "bad.surface.vtp").write_text("<VTKFile")
    done = run(config)
    assert done.exit_code == 1
    assert "its XML is damaged" in done.output
    assert (config.parent / "good.AVV_rh4.csv").exists()
    assert not list(config.parent.glob("*.part"))
    assert "does not end in .surface.vtp" in run(config, "good.AVV_rh4.vtp").output
    assert "There is no file" in run(config, "gone.surface.vtp").output


def test_a_radius_of_zero_is_refused(config):
    surface(config.parent)
    done = run(config, "--radius", 0)
    assert done.exit_code == 1
    assert "it has to be above 0" in done.output
    assert not list(config.parent.glob("*AVV*"))


@pytest.mark.parametrize("measured", [None, {}, {"radius_hit": "wide"}])
def test_a_config_without_the_radius_is_one_sentence(config, monkeypatch, measured):
    module = sys.modules["surface_morphometrics.config_utils"]
    monkeypatch.setattr(module, "load_config", lambda *_, **__: {"work_dir": ".", "curvature_measurements": measured})
    done = run(config)
    assert done.exit_code == 1
    assert "has no number radius_hit below curvature_measurements; add it." in done.output


def test_an_empty_folder_is_one_sentence(config):
    done = run(config)
    assert done.exit_code == 1
    assert "run morphometrics make_meshes first" in done.output


class StubGraph:
    """A stub of graph_tool.Graph: it keeps what it is given."""

    def __init__(self, directed=True):
        assert not directed
        self.vp, self.ep, self.gp, self.edges, self.count = {}, {}, {}, None, 0

    def add_vertex(self, count):
        self.count = count

    def add_edge_list(self, edges):
        self.edges = np.asarray(edges)

    def new_vertex_property(self, kind, vals):
        assert kind in ("double", "vector<double>", "object")
        assert len(vals) == self.count
        return vals

    def new_edge_property(self, kind, vals):
        assert kind in ("double", "int")
        assert len(vals) == len(self.edges)
        return vals

    def new_graph_property(self, kind, value):
        assert (kind, type(value)) == ("double", float)
        return value

    def save(self, path, fmt):
        with open(path, "w", encoding="ascii") as file:  # noqa: PTH123 (as a library in C++ does)
            file.write(fmt)
        saved.append(self)


saved: list[StubGraph] = []


def test_graph_tools_file_holds_the_same_and_which_triangles_are_neighbors(config, monkeypatch):
    stub = types.ModuleType("graph_tool")
    stub.Graph = StubGraph
    monkeypatch.setitem(sys.modules, "graph_tool", stub)
    find = morphometrics.importlib.util.find_spec
    monkeypatch.setattr(
        morphometrics.importlib.util, "find_spec", lambda name: stub if name == "graph_tool" else find(name)
    )
    points, triangles = surface(config.parent)
    done = run(config)
    assert done.exit_code == 0, done.output
    assert (config.parent / "TE1_IMM.AVV_rh4.gt").read_text() == "gt"
    graph, found = saved.pop(), table(config.parent / "TE1_IMM.AVV_rh4.csv")
    np.testing.assert_allclose(graph.vp["curvedness_VV"], found["curvedness_VV"], rtol=1e-6)
    np.testing.assert_allclose(graph.vp["points"], points[triangles], atol=1e-5)
    assert np.array_equal(np.bincount(graph.edges.reshape(-1)), np.full(len(triangles), 3))  # it is closed
    assert graph.gp["total_area"] == pytest.approx(found["area"].sum(), rel=1e-6)


def test_published_names_are_read_as_they_are_written(config):
    surface(config.parent)
    assert run(config, "--radius", 6).exit_code == 0
    (mesh,) = mesh_files.read(config.parent / "TE1_IMM.AVV_rh4.vtp")
    assert mesh.face_count == len(table(config.parent / "TE1_IMM.AVV_rh4.csv")["index"])
