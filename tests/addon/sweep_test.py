"""A small sweep (tests/sweep.py) over all descriptors, three radii and both precisions finds what it has to find."""

import sys

import numpy as np
import pytest

pytest.importorskip("bpy", reason="needs Blender")

from conftest import MESHES
from shapes import ROOT, as_arrays, cube_sphere

sys.path.append(str(ROOT / "tests"))
import sweep

from paradesc import bridge
from paradesc.core import job

SMALL = {"buffer_size": 256, "samples": 32}


def findings(rows):
    """All sentences."""
    return [sentence for row in rows for sentence in row.findings]


def test_no_value_of_a_sphere_is_missing():
    rows = list(sweep.bakes("sphere", as_arrays(*cube_sphere(4)), (0.1, 0.15, 0.2), sweep.BACKENDS, **SMALL))
    assert [row.precision for row in rows] == 3 * ["full"] + 3 * ["half"] + 3 * ["cpu"]
    assert findings(rows) == []
    assert all(row.whole == row.vertices > 0 and not row.planes for row in rows)


@pytest.mark.slow
def test_a_plane_has_no_shape_index_and_everything_else():
    points, quads, uvs = cube_sphere(4)
    arrays = as_arrays(points * (1, 1, 0), quads[:16], uvs[:16])
    (row, *_) = sweep.bakes("plane", arrays, (0.1,), **SMALL)
    assert row.findings == []
    assert row.planes == row.whole > 0


@pytest.mark.slow
def test_a_uv_map_without_area_is_no_error_of_the_device():
    arrays = as_arrays(*cube_sphere(3))
    arrays.corner_uvs[:] = 0.5
    assert findings(sweep.bakes("point", arrays, (0.2,), **SMALL)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["double_sided", "zero_area_face", "degenerate_edge", "infinite_coordinates"])
def test_malformed_meshes_have_values_or_are_refused(name):
    paths = sweep.files(MESHES, quick=True, only=(name,))
    if not paths:
        pytest.skip("real meshes are not in shared/meshes beside the checkout")
    rows, _ = sweep.sweep(paths, (0.04,), **SMALL)
    assert rows
    assert findings(rows) == []


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("mean_curvature", np.nan, "1 values are missing, the first at vertex 7"),
        ("shape_index", np.nan, "missing"),
        ("shape_index", 1.5, "outside"),
        ("curvedness", np.inf, "infinite"),
        ("harris", np.nan, "missing"),
    ],
)
def test_what_is_wrong_is_found(sphere, name, value, said):
    names = sweep.names_on("software")
    settings = job.Settings(names, bridge.Options(radius=0.1, **SMALL), "software")
    results = job.run(sphere, settings)
    results.values[name][7] = value
    row = sweep.Row("sphere", 0, 0.1, "full")
    sweep.check(results, row, lambda _names: job.run(sphere, settings))
    (sentence,) = row.findings
    assert name in sentence
    assert said in sentence
