"""The tangent space of normal maps: closed forms, and beside Blender's own MikkTSpace."""

import numpy as np
import pytest

from paradesc.bridge import MeshArrays
from paradesc.core.tangents import corner_tangents
from shapes import as_arrays, cube_sphere


def sheet(uvs, positions=((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))):
    """A square of two triangles with these UVs, seen from above."""
    return MeshArrays(
        positions=np.array(positions, np.float32),
        corner_vertices=np.arange(4, dtype=np.int32),
        triangle_corners=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        corner_uvs=np.array(uvs, np.float32),
        corner_normals=np.tile(np.float32([0, 0, 1]), (4, 1)),
    )


@pytest.mark.parametrize("turn", [0.0, 0.4, 2.0])
def test_tangents_of_a_plane_point_where_u_grows(turn):
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    matrix = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    found = corner_tangents(sheet(corners @ matrix.T))
    np.testing.assert_allclose(found, np.tile([np.cos(turn), np.sin(turn), 0, 1], (4, 1)), atol=1e-6)
    found = corner_tangents(sheet(corners @ matrix.T * (-1, 1)))
    np.testing.assert_allclose(found, np.tile([-np.cos(turn), -np.sin(turn), 0, -1], (4, 1)), atol=1e-6)


def test_tangents_lie_across_the_normals():
    arrays = as_arrays(*cube_sphere(6))
    arrays.corner_normals = (arrays.positions / 2)[arrays.corner_vertices]
    found = corner_tangents(arrays)
    np.testing.assert_allclose(np.linalg.norm(found[:, :3], axis=1), 1, atol=1e-6)
    assert np.abs((found[:, :3] * arrays.corner_normals).sum(axis=1)).max() < 1e-5
    assert set(found[:, 3].tolist()) <= {1.0, -1.0}


def test_triangles_without_area_take_the_tangents_beside_them():
    found = corner_tangents(sheet([(0, 0), (1, 0), (1, 1), (1, 1)]))
    np.testing.assert_allclose(found[:3, :3], [[1, 0, 0]] * 3, atol=1e-6)
    assert np.isfinite(corner_tangents(sheet(np.zeros((4, 2))))).all()


def test_a_mesh_without_triangles_has_tangents_of_nothing():
    arrays = sheet(np.zeros((4, 2)))
    arrays.triangle_corners = arrays.triangle_corners[:0]
    assert np.isfinite(corner_tangents(arrays)).all()


# ---- Beside Blender


def object_of(name, triangulated, smooth, mirrored=False):
    """A primitive of Blender, its quads cut or not, flat or smooth, its UV map folded or not."""
    import bmesh
    import bpy

    from scene import empty_scene

    empty_scene()
    getattr(bpy.ops.mesh, f"primitive_{name}_add")()
    target = bpy.context.object
    if triangulated:
        cut = bmesh.new()
        cut.from_mesh(target.data)
        bmesh.ops.triangulate(cut, faces=cut.faces)
        cut.to_mesh(target.data)
        cut.free()
    target.data.polygons.foreach_set("use_smooth", [smooth] * len(target.data.polygons))
    if mirrored:
        layer = target.data.uv_layers.active.data
        uvs = np.empty(2 * len(layer), np.float32)
        layer.foreach_get("uv", uvs)
        uvs[::2] = np.abs(uvs[::2] - 0.4)
        layer.foreach_set("uv", uvs)
    return target


@pytest.mark.parametrize("triangulated", [True, False])
@pytest.mark.parametrize(("smooth", "mirrored"), [(True, False), (False, False), (True, True)])
@pytest.mark.parametrize("name", ["uv_sphere", "torus", "cube", "monkey", "ico_sphere"])
def test_tangents_are_those_of_blender(name, smooth, mirrored, triangulated):
    pytest.importorskip("bpy", reason="needs Blender")
    from paradesc_blender.scene import mesh_io, surface_maps

    target = object_of(name, triangulated, smooth, mirrored)
    wanted, normals = surface_maps.read_tangent_space(target)
    arrays = mesh_io.read_mesh(target.data, True, False, name)
    np.testing.assert_allclose(arrays.corner_normals, normals, atol=2e-7)
    found = corner_tangents(arrays)
    distances = np.linalg.norm(found[:, :3] - wanted[:, :3], axis=1)
    assert np.mean(distances > 1e-4) < 0.003
    assert np.mean(found[:, 3] != wanted[:, 3]) < 0.003
