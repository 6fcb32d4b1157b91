"""The assets that blend_samples/models makes for pictures and tests: what artists bring, whole, and always the same."""

import sys

import numpy as np
import pytest

from shapes import ROOT

bpy = pytest.importorskip("bpy", reason="needs Blender")
bmesh = pytest.importorskip("bmesh", reason="needs Blender")

sys.path.insert(0, str(ROOT / "blend_samples"))

import models  # noqa: E402
from models import solids  # noqa: E402

SCULPTED = ("stone", "car", "creature", "column", "helmet", "rock", "caterpillar")


@pytest.fixture(autouse=True)
def scene():
    """An empty scene."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def points_of(made):
    """(n, 3) float32 positions."""
    points = np.empty(3 * len(made.data.vertices), np.float32)
    made.data.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)


def faces_at_edges(made):
    """How many faces each edge has, and the volume inside."""
    shape = bmesh.new()
    shape.from_mesh(made.data)
    counts, volume = np.array([len(edge.link_faces) for edge in shape.edges]), shape.calc_volume(signed=True)
    shape.free()
    return counts, volume


def test_a_sphere_on_a_grid_becomes_a_closed_sphere():
    step, radius = 0.05, 0.7
    solid = solids.Solid((0, -1, -1), (1, 1, 1), step, mirrored=True)
    solid.add(solids.ellipsoid((0, 0, 0), (radius, radius, radius)))
    points, quads = solid.mesh()
    # Between nodes the distance is linear, which misses a sphere by up to an eighth of step²/radius along each axis.
    assert np.abs(np.linalg.norm(points, axis=1) - radius).max() < 3 / 8 * step**2 / radius
    corners = points[quads]
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert (across * corners.mean(axis=1)).sum(axis=1).min() > 0  # all look out
    sides = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    assert set(np.unique(sides, axis=0, return_counts=True)[1]) == {2}


@pytest.mark.slow
@pytest.mark.parametrize("name", models.MODELS)
def test_a_model_is_one_selected_solid_of_a_size_that_artists_bring(name):
    made = models.MODELS[name]()
    assert bpy.context.selected_objects == [made] == list(bpy.context.scene.objects)
    made.data.calc_loop_triangles()
    assert len(made.data.loop_triangles) <= 150_000
    counts, volume = faces_at_edges(made)
    assert set(counts) <= {2, 4}  # none is open; thin places may share an edge
    assert (counts == 4).sum() < 0.001 * len(counts)
    assert volume > 0  # faces look out


@pytest.mark.slow
@pytest.mark.parametrize("name", SCULPTED)
def test_a_model_is_the_same_at_every_run(name):
    first, second = (points_of(models.MODELS[name]()) for _ in range(2))
    assert np.array_equal(first, second)


@pytest.mark.slow
def test_an_unwrapped_model_has_its_uv_map_inside_the_square():
    made = models.house()
    models.unwrap(made)
    uvs = np.empty(2 * len(made.data.loops), np.float32)
    made.data.uv_layers.active.data.foreach_get("uv", uvs)
    assert uvs.min() >= 0
    assert 0.5 < uvs.max() <= 1
