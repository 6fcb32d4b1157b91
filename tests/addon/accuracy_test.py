"""The means of the accuracy report (tests/accuracy): surfaces, meshes, baseline, and how it keeps its sections."""

import json
import subprocess
import sys

import bpy
import numpy as np
import pytest

from paradesc import bridge
from shapes import ROOT, cube_sphere, write_obj

ACCURACY = ROOT / "tests" / "accuracy"
if str(ACCURACY) not in sys.path:
    sys.path.insert(0, str(ACCURACY))

import baseline  # noqa: E402
import meshes  # noqa: E402
import surfaces  # noqa: E402

IN_PYTHON = pytest.mark.skipif(bool(bpy.app.binary_path), reason="the report is a program of Python, not of Blender")


@pytest.fixture(scope="module")
def reference():
    """The reference backend."""
    with bridge.Context("reference") as context:
        yield context


@pytest.mark.parametrize("irregular", [False, True])
@pytest.mark.parametrize("name", surfaces.SURFACES)
def test_surfaces_have_the_curvatures_that_they_say(reference, name, irregular):
    surface = surfaces.SURFACES[name](vertices=6000, irregular=irregular)
    with reference.mesh(surface.arrays) as mesh, mesh.compute(["mean_curvature", "gaussian_curvature"]) as field:
        inside = surface.boundary_distance > 1.5 * field.report()["radius"]
        # 1 % of the largest curvature: facets and the finite support leave 0.5 % on 6000 vertices.
        scale = np.abs(surface.mean).max() + np.sqrt(np.abs(surface.gaussian).max())
        assert np.abs(field.values("mean_curvature") - surface.mean)[inside].max() < 0.01 * scale
        assert np.abs(field.values("gaussian_curvature") - surface.gaussian)[inside].max() < 0.02 * scale**2
        assert inside.sum() > 3000


@pytest.mark.parametrize(("charts", "counts"), [(1, [1, 1, 1, 1, 1, 1]), (2, [24, 8, 24, 4, 4, 4])])
def test_surfaces_have_as_many_charts_as_asked_and_all_face_one_way(reference, charts, counts):
    for make, count in zip(surfaces.SURFACES.values(), counts, strict=True):
        surface = make(vertices=3000, charts=charts)
        assert surface.arrays.corner_uvs.min() >= 0
        assert surface.arrays.corner_uvs.max() <= 1
        with reference.mesh(surface.arrays) as mesh:
            report = mesh.report()
        assert report["charts"] == count
        assert report["flipped_triangles"] == report["zero_uv_area_triangles"] == 0


def test_projected_charts_cover_a_mesh_without_overlap(reference):
    arrays = meshes.project_charts(surfaces.torus(vertices=3000).arrays, cells=3)
    u, v = arrays.corner_uvs[arrays.triangle_corners].transpose(2, 0, 1)
    signed = (u[:, 1] - u[:, 0]) * (v[:, 2] - v[:, 0]) - (u[:, 2] - u[:, 0]) * (v[:, 1] - v[:, 0])
    assert (signed > 0).all()
    assert arrays.corner_uvs.min() >= 0
    assert arrays.corner_uvs.max() <= 1
    with reference.mesh(arrays) as mesh:
        assert mesh.report()["charts"] > 20


def test_loop_subdivision_keeps_topology_indices_and_uvs():
    arrays = surfaces.torus(vertices=400, charts=2).arrays
    fine = meshes.loop_subdivide(arrays, 2)
    assert len(fine.triangle_corners) == 16 * len(arrays.triangle_corners)
    assert meshes.euler_characteristic(fine.triangle_vertices) == 0
    moved = np.linalg.norm(fine.positions[: len(arrays.positions)] - arrays.positions, axis=1)
    assert 0 < moved.max() < 0.1  # old vertices keep their indices, and move by less than an edge
    assert np.isclose(uv_area(fine), uv_area(arrays), rtol=1e-5)


def uv_area(arrays):
    """The area of all triangles in the UV map."""
    u, v = arrays.corner_uvs.astype(float)[arrays.triangle_corners].transpose(2, 0, 1)
    return np.abs((u[:, 1] - u[:, 0]) * (v[:, 2] - v[:, 0]) - (u[:, 2] - u[:, 0]) * (v[:, 1] - v[:, 0])).sum() / 2


def test_obj_reader_reads_quads_with_their_uvs(tmp_path):
    points, quads, uvs = cube_sphere(4)
    arrays = meshes.read_obj(write_obj(tmp_path / "sphere.obj", points, quads, uvs))
    assert len(arrays.triangle_corners) == 2 * len(quads)
    assert np.allclose(arrays.positions, points, atol=1e-6)
    assert np.allclose(arrays.corner_uvs[:3], uvs[0, [0, 1, 2]], atol=1e-6)
    assert meshes.read_obj(write_obj(tmp_path / "bare.obj", points, quads)).corner_uvs is None


@pytest.mark.slow
def test_baseline_has_a_spheres_curvature_where_it_sees_many_vertices():
    surface = surfaces.sphere(vertices=4000)
    values, count = baseline.mean_curvature(surface.arrays, 0.4, surface.normals)
    assert count > 100
    # Its weights are those of vertices, in steps: 5 % of H with a hundred of them.
    assert np.abs(values - 1).max() < 0.05


@pytest.mark.slow
@IN_PYTHON
def test_a_section_is_written_and_kept_while_another_is_measured(tmp_path):
    with bridge.Context("cpu") as context:
        device = context.device

    def write(section):
        words = ["--quick", "--sections", section, "--output", str(tmp_path / "page.md")]
        command = [sys.executable, str(ACCURACY / "report.py"), *words]
        return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)

    for section in ("integral-k", "settings"):
        done = write(section)
        assert done.returncode == 0, done.stderr
    page = (tmp_path / "page.md").read_text()
    assert "shape operator |" in page, "the table of the section measured first"
    assert "default |" in page
    assert "Not measured yet: `--sections closed`" in page
    kept = json.loads((tmp_path / "results-quick" / "settings.json").read_text())
    assert kept["seconds"] > 0
    assert device
    assert device in kept["stamp"]


@IN_PYTHON
def test_an_unknown_section_is_refused_with_one_line():
    command = [sys.executable, str(ACCURACY / "report.py"), "--sections", "nonsense"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert "there is no section nonsense" in done.stderr
