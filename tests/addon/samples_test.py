"""The sample scenes that blend_samples/make_samples.py writes: what is said of them is true."""

import importlib.util

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from paradesc import bridge, mesh_io  # noqa: E402
from shapes import ROOT  # noqa: E402


@pytest.fixture(scope="module")
def script():
    """make_samples.py as a module."""
    spec = importlib.util.spec_from_file_location("make_samples", ROOT / "blend_samples" / "make_samples.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def made(make):
    """The mesh of a sample, made in an empty scene."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return mesh_io.read_object(make(), False)


def euler_characteristic(faces):
    """V - E + F of polygons given as lists of vertices; every edge has to have two faces, one each way."""
    edges = [(a, b) for face in faces for a, b in zip(face, [*face[1:], face[0]], strict=True)]
    assert len(set(edges)) == len(edges)
    assert {(b, a) for a, b in edges} == set(edges)
    return len({vertex for face in faces for vertex in face}) - len(edges) // 2 + len(faces)


def test_rim_has_genus_20_before_and_after_it_is_subdivided(script):
    _, quads = script.rim_cage()
    assert euler_characteristic(quads) == 2 - 2 * 20
    assert euler_characteristic(made(script.make_rim).triangle_vertices.tolist()) == 2 - 2 * 20


def test_rim_is_wound_outward(script):
    arrays = made(script.make_rim)
    a, b, c = np.moveaxis(arrays.positions.astype(float)[arrays.triangle_vertices], 1, 0)
    assert (a * np.cross(b, c)).sum() > 0  # six times the volume


@pytest.mark.parametrize(("make", "charts"), [("make_torus", 16), ("make_suzanne", 20), ("make_rim", 100)])
def test_samples_have_as_many_charts_as_they_say_and_none_overlaps(script, make, charts):
    arrays = made(getattr(script, make))
    with bridge.Context("reference") as context, context.mesh(arrays) as mesh:
        report = mesh.report()
    assert report["charts"] >= charts
    assert report["nonmanifold_edges"] == report["zero_uv_area_triangles"] == report["degenerate_triangles"] == 0
    with bridge.Context("auto") as context:
        if context.backend == "reference":
            pytest.skip(context.fallback)
        with context.mesh(arrays) as mesh, mesh.compute(["mean_curvature"]) as field:
            found = field.report()
            assert found["private_layout"] == 0, "no charts share texture space"
            assert found["overlapping_texels"] == 0
            assert np.isfinite(field.values("mean_curvature")).all()
