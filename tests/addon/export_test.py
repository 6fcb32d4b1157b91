"""Other programs get values and colors through each of Blender's exporters. Runs inside Blender."""

import json
import struct

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import addon_utils  # noqa: E402
from mesh_io_test import made_up_results  # noqa: E402

import paradesc_blender  # noqa: E402
from paradesc_blender.scene import delivery, mesh_io, scene_io  # noqa: E402
from paradesc_blender.show import channels  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene  # noqa: E402

NAMES = ("mean_curvature", "shape_index")
NEW = bpy.app.version >= (4, 0, 0)
needs_new = pytest.mark.skipif(not NEW, reason="since Blender 4.0")
needs_usd = pytest.mark.skipif(not bpy.app.build_options.usd, reason="this Blender was built without USD")


@pytest.fixture
def baked():
    """A sphere with made-up values, and all copies for exporters; vertex 5 has no value."""
    empty_scene()
    target = add_sphere(steps=3)
    results = made_up_results(target, NAMES)
    results.values["shape_index"][5] = np.nan
    delivery.deliver(target, results)
    channels.export_copies(target.data)
    channels.corner_colors(target.data, "mean_curvature")
    return target


def positions(mesh):
    """(n, 3) float32"""
    return mesh_io.read_array(mesh.vertices, "co", np.float32, 3)


def imported():
    """The only mesh that an importer made, in world space like its source."""
    return next(item for item in bpy.data.objects if item.type == "MESH")


def nearest(source, points):
    """(k,) index of the (n, 3) source point that lies at each of (k, 3) points."""
    distance = np.linalg.norm(points[:, None] - source[None], axis=2)
    assert distance.min(axis=1).max() < 1e-4
    return distance.argmin(axis=1)


def enable(name):
    """Enables an exporter that is an add-on, which a Blender without preferences has not enabled."""
    addon_utils.enable(name)


def primitive(path):
    """The attributes of the only primitive of a .glb, each (n, k)."""
    content = path.read_bytes()
    (length,) = struct.unpack("<I", content[12:16])
    scene, binary = json.loads(content[20 : 20 + length]), content[28 + length :]
    kinds, widths = {5126: "<f4", 5123: "<u2", 5121: "u1"}, {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
    found = {}
    for name, number in scene["meshes"][0]["primitives"][0]["attributes"].items():
        accessor = scene["accessors"][number]
        start = scene["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
        width = widths[accessor["type"]]
        values = np.frombuffer(binary, kinds[accessor["componentType"]], accessor["count"] * width, start)
        found[name] = values.reshape(-1, width)
    return found


def test_gltf_carries_values_whose_names_begin_with_an_underscore(baked, tmp_path):
    expected, source = attribute_values(baked.data, "mean_curvature"), positions(baked.data)
    enable("io_scene_gltf2")
    with scene_io.numpy_bool():
        bpy.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"), export_attributes=True)
    found = {name.lower(): values for name, values in primitive(tmp_path / "a.glb").items()}
    points = found["position"][:, [0, 2, 1]] * (1, -1, 1)  # Y is up there
    np.testing.assert_allclose(found["_mean_curvature"][:, 0], expected[nearest(source, points)], atol=1e-6)
    assert np.isfinite(found["_shape_index"]).all()  # glTF knows no NaN: the copy has 0 there
    assert "color_0" in found


def test_gltf_shows_the_descriptor_that_our_material_shows(baked, tmp_path):
    paradesc_blender.register()
    try:
        bpy.ops.paradesc.show(name="shape_index")
        bpy.ops.paradesc.make_material(kind="colors")
    finally:
        paradesc_blender.unregister()
    colors, source = attribute_values(baked.data, "shape_index_color"), positions(baked.data)
    enable("io_scene_gltf2")
    with scene_io.numpy_bool():
        bpy.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"))
    found = primitive(tmp_path / "a.glb")
    place = nearest(source, found["POSITION"][:, [0, 2, 1]] * (1, -1, 1))
    values = found["COLOR_0"] / (1 if found["COLOR_0"].dtype.kind == "f" else np.iinfo(found["COLOR_0"].dtype).max)
    np.testing.assert_allclose(values[:, :3], colors[place, :3], atol=1e-4)


@pytest.mark.skipif(bpy.app.version < (4, 2, 0), reason="since Blender 4.2")
@pytest.mark.parametrize("every", [True, False])
def test_gltf_carries_every_mask_or_the_shown_one_alone_as_its_exporter_is_told(baked, tmp_path, every):
    baked.data.materials.append(bpy.data.materials.new("own"))
    enable("io_scene_gltf2")
    options = {"export_vertex_color": "ACTIVE", "export_all_vertex_colors": every}
    with scene_io.numpy_bool():
        bpy.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"), **options)
    found = primitive(tmp_path / "a.glb")
    count = len(baked.data.color_attributes) if every else 1
    assert [name for name in found if name.startswith("COLOR")] == [f"COLOR_{number}" for number in range(count)]
    colors = attribute_values(baked.data, baked.data.color_attributes.active_color.name)
    place = nearest(positions(baked.data), found["POSITION"][:, [0, 2, 1]] * (1, -1, 1))
    shown = found["COLOR_0"] / (1 if found["COLOR_0"].dtype.kind == "f" else np.iinfo(found["COLOR_0"].dtype).max)
    np.testing.assert_allclose(shown[:, :3], colors[place, :3], atol=1e-4)


@needs_new
def test_ply_carries_values_and_the_active_color(baked, tmp_path):
    source = positions(baked.data)
    values, colors = (
        attribute_values(baked.data, "mean_curvature"),
        attribute_values(baked.data, "mean_curvature_color"),
    )
    path = str(tmp_path / "a.ply")
    bpy.ops.wm.ply_export(filepath=path, export_attributes=True, export_colors="LINEAR", apply_modifiers=False)
    empty_scene()
    bpy.ops.wm.ply_import(filepath=path, import_colors="LINEAR")
    place = nearest(source, positions(imported().data))
    np.testing.assert_allclose(attribute_values(imported().data, "mean_curvature"), values[place], atol=1e-6)
    np.testing.assert_allclose(attribute_values(imported().data, "Col"), colors[place], atol=1 / 255)  # cut to 8 bits


@needs_usd
@needs_new
def test_usd_carries_values_and_colors_exactly(baked, tmp_path):
    expected = {name: attribute_values(baked.data, name) for name in (*NAMES, "coverage", "mean_curvature_color")}
    path = str(tmp_path / "a.usdc")
    bpy.ops.wm.usd_export(filepath=path)
    empty_scene()
    bpy.ops.wm.usd_import(filepath=path)
    for name, values in expected.items():
        assert np.array_equal(attribute_values(imported().data, name), values, equal_nan=True), name


def test_fbx_carries_colors(baked, tmp_path):
    source, colors = positions(baked.data), attribute_values(baked.data, "mean_curvature_color")
    enable("io_scene_fbx")
    path = str(tmp_path / "a.fbx")
    bpy.ops.export_scene.fbx(filepath=path)
    empty_scene()
    bpy.ops.import_scene.fbx(filepath=path)
    mesh = imported().data
    points = (np.array(imported().matrix_world)[:3, :3] @ positions(mesh).T).T
    expected = colors[nearest(source, points)][mesh_io.read_corner_vertices(mesh)]
    found = np.empty(4 * len(mesh.loops), np.float32)
    mesh.attributes["mean_curvature_color"].data.foreach_get("color", found)
    np.testing.assert_allclose(found.reshape(-1, 4), expected, atol=0.02)  # 8 bits, sRGB


def test_obj_carries_the_active_color_on_request(baked, tmp_path):
    colors = attribute_values(baked.data, "mean_curvature_color")
    path = str(tmp_path / "a.obj")
    bpy.ops.wm.obj_export(filepath=path, export_colors=True)
    empty_scene()
    bpy.ops.wm.obj_import(filepath=path)
    np.testing.assert_allclose(attribute_values(imported().data, "Color"), colors, atol=1e-3)  # four digits


@pytest.mark.skipif(not bpy.app.build_options.alembic, reason="this Blender was built without Alembic")
def test_alembic_carries_the_corner_colors_alone(baked, tmp_path):
    path = str(tmp_path / "a.abc")
    colors = mesh_io.read_array(baked.data.attributes["mean_curvature_corner_color"].data, "color", np.float32, 4)
    bpy.ops.wm.alembic_export(filepath=path, vcolors=True, as_background_job=False)
    empty_scene()
    bpy.ops.wm.alembic_import(filepath=path, as_background_job=False)
    (found,) = imported().data.color_attributes
    assert (found.name, found.data_type, found.domain) == ("mean_curvature_corner_color", "BYTE_COLOR", "CORNER")
    read = mesh_io.read_array(found.data, "color", np.float32, 4)
    np.testing.assert_allclose(np.sort(read, axis=0), np.sort(colors, axis=0), atol=0.01)  # 8 bits, corners in any order
