"""A cube from a file by the command line's bake, with a radius and no other choice: 0 within faces, 1 along edges.

Both bounds are what masks need: within a hundredth of black, and white but for a twentieth.
"""

import sys

import numpy as np
import pytest

from paradesc import bridge
from paradesc.core import job
from shapes import cube_sphere, write_obj

pytest.importorskip("bpy", reason="needs Blender")

STEPS = 8
NAME = "convexity"
WORDS = ("--descriptors", NAME, "--radius", "0.05", "--output", "out.npz")


def say(sentence):
    """Shows a figure where pytest shows output (-s)."""
    sys.stdout.write(f"{sentence}\n")


def cube():
    """Vertices of a cube from -1 to 1 with STEPS x STEPS faces a side, and its quads."""
    points, quads, _ = cube_sphere(STEPS)
    points = points / np.abs(points).max(axis=1, keepdims=True)
    return np.round((points + 1) * STEPS / 2) * 2 / STEPS - 1, quads


def distance_to_edge(points):
    """(n,) how far points on the faces are from the nearest edge of the cube."""
    return 1 - np.sort(np.abs(points), axis=1)[:, 1]


@pytest.fixture(params=["quads", "triangles"])
def cube_obj(request, tmp_path):
    """The cube as a file without normals and without a UV map."""
    points, quads = cube()
    faces = quads if request.param == "quads" else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    path = write_obj(tmp_path / "cube.obj", points, faces)
    assert not any(line.startswith(("vn", "vt", "s ")) for line in path.read_text().splitlines())
    return path


@pytest.fixture
def computed(monkeypatch):
    """The arrays and results that bakes of this process computed."""
    kept = []
    original = job.run

    def run(arrays, *words):
        kept.append((arrays, original(arrays, *words)))
        return kept[-1][1]

    monkeypatch.setattr(job, "run", run)
    return kept


@pytest.mark.parametrize("backend", [(), ("--backend", "cpu")], ids=["auto", "cpu"])
def test_vertices_within_faces_are_flat_and_those_along_edges_are_edges(run, cube_obj, tmp_path, backend):
    assert run("bake", cube_obj, *WORDS, *backend).code == 0
    with np.load(tmp_path / "out.npz") as file:
        points, found = file["vertices"], file[NAME]
    along = distance_to_edge(points) < 1e-6
    say(f"{NAME} at vertices: within faces to {found[~along].max():.6f}, along edges from {found[along].min():.6f}")
    assert (len(found), along.sum()) == (6 * STEPS**2 + 2, 12 * STEPS - 4)
    assert np.abs(found[~along]).max() <= 0.01
    assert found[along].min() >= 0.95


@pytest.mark.parametrize("backend", [(), ("--backend", "cpu")], ids=["auto", "cpu"])
def test_texels_have_what_the_volume_in_the_ball_says_from_the_edge_to_flat_faces(run, cube_obj, computed, backend):
    words = ("--evaluate", "texel", "--texels", "256")
    assert run("bake", cube_obj, *WORDS, *words, *backend).code == 0
    ((arrays, results),) = computed
    image, radius = results.maps[NAME], results.radius
    assert radius == pytest.approx(0.05 * np.sqrt(12), rel=1e-4)  # of the diagonal
    points = bridge.draw_uv_image(results.layout, arrays.triangle_vertices, arrays.positions, len(image), numbers=True)
    there = np.isfinite(points[:, :, 0])
    found, points = image[there], points[there]
    assert np.isfinite(found).all()
    distance = distance_to_edge(points)
    within, along = distance > radius, distance < 0.15 * radius
    say(f"{NAME} at texels: within faces to {found[within].max():.6f}, along edges from {found[along].min():.6f}")
    assert along.sum() > 1000 < within.sum()
    assert np.abs(found[within]).max() <= 0.01
    assert found[along].min() >= 0.95
    # Beside one edge and far from others, half a cap of the ball lacks: H r = 2/3 t² (3 - t), with t = 1 - d / r.
    beside = 1 - np.abs(points).min(axis=1) > radius
    share = np.clip(1 - distance[beside] / radius, 0, 1)
    expected = np.minimum(2 / 3 * share**2 * (3 - share), 1)
    say(f"  from the closed form at most {np.abs(found[beside] - expected).max():.6f}")
    assert np.abs(found[beside] - expected).max() < 0.01  # values are looked up between texels
