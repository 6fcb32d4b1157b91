"""Meshes of trimesh, PyVista and Open3D are measured by their arrays, and get their values."""

from types import SimpleNamespace

import numpy as np
import pytest

import paradesc
from paradesc import InputError
from python_api_test import NAMES, same
from shapes import cube_sphere


@pytest.fixture(scope="module")
def sphere():
    """Positions, quads, and their UVs (m, 4, 2)."""
    return cube_sphere(8)


def test_trimesh_goes_in_and_gets_its_values():
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
    result = paradesc.compute(mesh, descriptors=NAMES, radius=0.1)
    assert np.abs(result["mean_curvature"] - 0.5).max() < 0.01
    assert result.to(mesh) is mesh
    assert np.array_equal(mesh.vertex_attributes["mean_curvature"], result["mean_curvature"])
    assert mesh.vertex_attributes["principal_direction_max"].shape == mesh.vertices.shape
    mesh.vertex_attributes["mean_curvature"] *= 2  # a copy: the result stays
    assert np.abs(result["mean_curvature"] - 0.5).max() < 0.01
    with pytest.raises(InputError, match="The mesh has 12 vertices, but the result belongs to one with 642"):
        result.to(trimesh.creation.icosphere(subdivisions=0))


def test_pyvista_goes_in_and_gets_its_values(sphere, pyvista):
    points, quads, _ = sphere
    mixed = [*quads[1:].tolist(), quads[0, [0, 1, 2]].tolist(), quads[0, [0, 2, 3]].tolist()]
    expected = paradesc.compute(points.astype(np.float32), mixed, radius=0.1)
    flat = np.concatenate([[len(face), *face] for face in mixed])
    poly = pyvista.PolyData(points.astype(np.float32), flat)
    for mesh in (poly, poly.cast_to_unstructured_grid()):
        result = paradesc.compute(mesh, radius=0.1)
        assert same(result, expected)
        assert np.array_equal(result.to(mesh).point_data["mean_curvature"], result["mean_curvature"])
        mesh.point_data["mean_curvature"] *= 2
        assert same(result, expected)
    with pytest.raises(InputError, match="cells that are no polygons"):
        paradesc.compute(pyvista.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid())


def test_points_without_faces_are_refused_as_what_they_are(sphere, pyvista):
    points = sphere[0]
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    cloud_of_open3d = type("PointCloud", (), {"points": points})()
    for cloud in (pyvista.PolyData(points), trimesh.PointCloud(points), cloud_of_open3d):
        with pytest.raises(InputError, match="Points without faces are no surface; make a mesh of them first"):
            paradesc.compute(cloud)


@pytest.mark.parametrize("stripped", [slice(None), slice(100, None)], ids=["all", "a part"])
def test_triangle_strips_of_pyvista_are_faces(sphere, pyvista, stripped):
    points, quads, _ = sphere
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    mesh = pyvista.PolyData.from_regular_faces(points, triangles[stripped]).strip()
    mesh.faces = np.insert(np.delete(triangles, stripped, axis=0), 0, 3, axis=1).ravel()
    assert mesh.n_strips > 0
    expected = paradesc.compute(points, triangles, radius=0.1)
    assert np.allclose(paradesc.compute(mesh, radius=0.1)["mean_curvature"], expected["mean_curvature"], rtol=1e-4)


def test_values_at_faces_are_those_of_the_polygons_among_the_cells_of_pyvista(sphere, pyvista):
    points, quads, _ = sphere
    mesh = pyvista.PolyData(points, np.insert(quads, 0, 4, axis=1), verts=[1, 0], lines=[2, 0, 1, 3, 1, 2, 3])
    result = paradesc.compute(mesh, descriptors=NAMES, radius=0.1, domain="faces")
    stored = result.to(mesh).cell_data
    for name, values in result.items():
        assert np.isnan(stored[name][:3]).all()
        assert np.array_equal(stored[name][3:], values)
    strips = mesh.triangulate().strip()
    with pytest.raises(InputError, match="A triangle strip is one cell"):
        paradesc.compute(strips, radius=0.1, domain="faces").to(strips)


class Tensor:
    """As much of Open3D's as is needed."""

    device = "CPU:0"

    def __init__(self, array):
        self.array = array

    def cpu(self):
        return self

    def numpy(self):
        return self.array

    def to(self, _device):
        return self

    from_numpy = classmethod(lambda cls, array: cls(array))


def test_open3d_goes_in_and_its_tensor_meshes_get_their_values(sphere):
    """With stand-ins of the same attributes: the package itself is large."""
    points, quads, _ = sphere
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    expected = paradesc.compute(points, triangles, radius=0.1)
    old = SimpleNamespace(vertices=points, triangles=triangles)
    new = SimpleNamespace(vertex={"positions": Tensor(points)}, triangle={"indices": Tensor(triangles)})
    assert same(paradesc.compute(old, radius=0.1), expected)
    result = paradesc.compute(new, radius=0.1)
    assert same(result, expected)
    assert result.to(new).vertex["mean_curvature"].array.shape == (len(points), 1)
    with pytest.raises(InputError, match="from_legacy"):
        result.to(old)
    with pytest.raises(InputError, match="cannot be given to a dict"):
        result.to({})
