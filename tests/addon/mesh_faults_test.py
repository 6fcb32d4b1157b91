"""Copies of faces and corners that differ by rounding change no value; what a mesh lacks is said with what to do."""

import importlib.util

import numpy as np
import pytest

import paradesc
from conftest import ROOT
from paradesc.core import mesh_faults, welding
from paradesc.numpy_api import result

MINOR = 0.4
BUGS = ROOT.parent / "shared" / "reviews" / "bugs" / "make.py"


def torus(around=60, across=24):
    """Vertices (n, 3), triangles (m, 3) and the mean curvature (n,) of a torus of the radii 1 and 0.4."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    ring = 1 + MINOR * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), MINOR * np.sin(v)], axis=2).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")

    def at(a, b):
        return ((i + a) % around * across + (j + b) % across).ravel()

    faces = [np.stack(corners, axis=1) for corners in ((at(0, 0), at(1, 0), at(1, 1)), (at(0, 0), at(1, 1), at(0, 1)))]
    return points, np.concatenate(faces), ((1 / MINOR + np.cos(v) / ring) / 2).ravel()


def curvature(points, faces, **options):
    """The result for a mesh."""
    return paradesc.compute(points, faces, ["mean_curvature"], radius=0.05, **options)


@pytest.mark.parametrize("backend", ["cpu", "reference"])
@pytest.mark.parametrize("over", [False, True], ids=["wound alike", "turned over"])
@pytest.mark.parametrize("share", [1, 0.3], ids=["all", "some"])
def test_copies_of_faces_change_no_bit(backend, over, share):
    points, faces, exact = torus()
    copies = np.roll(faces, 1, axis=1)[: int(share * len(faces))]
    doubled = np.concatenate([faces, copies[:, ::-1] if over else copies])
    alone, found = curvature(points, faces, backend=backend), curvature(points, doubled, backend=backend)
    np.testing.assert_array_equal(found["mean_curvature"], alone["mean_curvature"])
    np.testing.assert_allclose(found["mean_curvature"], exact, atol=0.06)  # of a coarse torus
    assert found.report["mesh_report"]["copied_triangles"] == len(copies)
    assert found.report["mesh_report"]["parts"] == 1
    assert found.warnings == alone.warnings == []


def soup(points, faces, error=0.0):
    """Triangles that share no vertex, each corner moved by this much at most."""
    corners = points[faces].reshape(-1, 3)
    corners = corners + np.random.default_rng(1).uniform(-error, error, corners.shape)
    return corners, np.arange(len(corners)).reshape(-1, 3)


EPSILON = float(np.finfo(np.float32).eps)


@pytest.mark.parametrize("error", [0, EPSILON, 2 * EPSILON, 6 * EPSILON])
def test_corners_that_differ_by_rounding_meet(error):
    points, faces, _ = torus()
    found = curvature(*soup(points, faces, error))
    expected = curvature(points, faces)["mean_curvature"][faces.ravel()]
    # An error of 1e-6 bends edges of 0.1 by 1e-5, which curvature of 1/0.1 takes tenfold.
    np.testing.assert_allclose(found["mean_curvature"], expected, atol=1e-3)
    assert found.report["mesh_report"]["boundary_edges"] == 0
    assert found.warnings == []


def test_a_soup_that_does_not_meet_is_told_of():
    points, faces, _ = torus()
    (sentence,) = curvature(*soup(points, faces, 1e-4)).warnings
    assert sentence.startswith("The mesh falls apart: its 2,880 triangles are 2,880 parts")
    assert sentence.endswith("(trimesh's merge_vertices with fewer digits).")


def test_inconsistent_winding_is_told_of():
    points, faces, _ = torus()
    faces[7] = faces[7, ::-1]
    (sentence,) = curvature(points, faces).warnings
    assert sentence.startswith("3 edges have faces that are wound against each other")
    assert sentence.endswith("give the faces one winding (trimesh.repair.fix_winding).")


def test_blender_is_told_of_its_menus_and_python_of_calls():
    report = dict.fromkeys(("degenerate_triangles", "copied_triangles", "boundary_edges"), 0)
    report |= {"triangle_count": 100, "parts": 100, "boundary_edges": 300, "opposed_edges": 1, "inward_parts": 1}
    found = mesh_faults.sentences({**report, "nonmanifold_edges": 1})
    menus = ["Recalculate Outside", "Recalculate Outside", "By Distance"]
    assert [sentence.rpartition(" > ")[2] for sentence in found] == [f"{menu})." for menu in menus]
    told = [result.for_python(sentence) for sentence in found]
    calls = [
        "trimesh.repair.fix_winding",
        "faces[:, ::-1] of an array, or trimesh.repair.fix_inversion",
        "trimesh's merge_vertices with fewer digits",
    ]
    assert [sentence.rpartition(" (")[2] for sentence in told] == [f"{call})." for call in calls]
    assert not any("Mesh >" in sentence for sentence in told)
    assert result.for_python("Anything else.") == "Anything else."


def test_a_mesh_wound_inwards_is_told_of():
    points, faces, exact = torus()
    found = curvature(points, faces[:, ::-1])
    np.testing.assert_allclose(found["mean_curvature"], -exact, atol=0.06)
    (sentence,) = found.warnings
    assert sentence.startswith("The closed mesh is wound inwards")
    two = np.concatenate([faces, faces[:, ::-1] + len(points)])
    (sentence,) = curvature(np.concatenate([points, points + (3, 0, 0)]), two).warnings
    assert sentence.startswith("1 closed part is wound inwards")


def test_many_triangles_without_area_are_told_of():
    points, faces, _ = torus()
    lines = np.repeat(np.arange(200), 3).reshape(-1, 3)
    (sentence,) = curvature(points, np.concatenate([faces, lines])).warnings
    assert sentence.startswith("200 of 3,080 triangles have no area and are left out")


def test_faces_upon_each_other_that_are_cut_otherwise_are_told_of():
    points, faces, _ = torus()
    half = len(faces) // 2  # both triangles of a quad: a b c, a c d
    a, b, c, d = *faces[:half].T, faces[half:, 2]
    other = np.concatenate([np.stack([b, a, d], axis=1), np.stack([b, d, c], axis=1)])
    (sentence,) = curvature(points, np.concatenate([faces, other])).warnings
    assert "edges have more than two faces" in sentence


def test_sound_meshes_are_not_told_of():
    points, faces, _ = torus()
    for some in (faces, faces[300:], faces[faces.max(axis=1) < 700]):  # the others are open
        assert curvature(points, some).warnings == []
    cards = np.arange(4 * 40).reshape(-1, 4)
    corners = np.concatenate([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]] * 40) + np.repeat(np.arange(40), 4)[:, None]
    report = curvature(corners, cards).report["mesh_report"]
    assert report["parts"] == 40
    assert mesh_faults.sentences(report) == []


def test_a_vertex_of_a_triangle_without_area_has_the_value_at_its_place():
    points, faces, _ = torus()
    more = np.concatenate([points, points[[5]], [[9.0, 0, 0]]])
    found = curvature(more, np.concatenate([faces, [[len(points), 5, 6]]]))["mean_curvature"]
    assert found[len(points)] == found[5]
    assert np.isnan(found[-1])


def test_no_edge_is_shorter_than_what_is_welded():
    points, faces, _ = torus()
    near = welding.reach(points.astype(np.float32), faces)
    assert near == pytest.approx(16 * EPSILON * 1.4)
    far = welding.reach((points + 4e6).astype(np.float32), faces)
    assert 0 < far < 0.01 * 0.5  # the spacing of floats there is 0.25 or more
    assert welding.reach(np.zeros((0, 3), np.float32), np.zeros((0, 3), int)) == 0


@pytest.mark.parametrize("name", ["doubled_same", "doubled_opposite", "soup_last_bit"])
def test_reported_meshes_have_the_values_of_their_surface(name):
    if not BUGS.is_file():
        pytest.skip(f"there is no {BUGS}")
    spec = importlib.util.spec_from_file_location("reported_meshes", BUGS)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    points, faces, exact = made.MESHES[name]()
    found = curvature(points, faces)
    np.testing.assert_allclose(found["mean_curvature"], exact, atol=0.04)  # what the radius smooths away: 0.033
    assert found.warnings == []
