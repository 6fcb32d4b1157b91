"""Displacement and normal maps: through the bridge, from files, from materials, on the command line."""

import numpy as np
import pytest

from cli_test import QUICK, accepted, loaded, refused
from shapes import RADIUS, as_arrays, cube_sphere

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc import bridge  # noqa: E402
from paradesc.bridge import ParadescError  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc.files import map_images  # noqa: E402
from paradesc_blender.scene import mesh_io, surface_maps  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene, measure_curvature  # noqa: E402

UNITS = {"mean_curvature": RADIUS, "local_bending_energy": RADIUS**2}


def curvature(arrays, normals="fitted", backend="software"):
    options = bridge.Options(radius=0.06, buffer_size=256, normals=normals)
    return job.run(arrays, job.Settings(("mean_curvature",), options, backend)).values["mean_curvature"]


def make_image(name, pixels):
    """Makes a float image in Blender; pixels: (height, width, 3), rows bottom-up."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    return image


def save_image(path, pixels):
    """Saves pixels (height, width, 3), rows bottom-up, as an 8-bit PNG file."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("saved", width, height)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.filepath_raw = str(path)
    image.file_format = "PNG"
    image.save()
    bpy.data.images.remove(image)
    return path


def ramp():
    """(2, 3, 3) values of eight bits, all different: blue rises with the row, red with the column."""
    pixels = np.zeros((2, 3, 3), np.float32)
    pixels[..., 0] = np.array([10, 20, 30]) / 255
    pixels[..., 2] = np.array([[100], [200]]) / 255
    return pixels


@pytest.fixture
def target():
    empty_scene()
    return add_sphere(steps=12)


def with_material(target, name="stone"):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    target.data.materials.append(material)
    return material.node_tree


def add_texture(tree, image):
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    return texture


def connect_displacement(tree, image, midlevel=0.25, scale=0.4):
    node = tree.nodes.new("ShaderNodeDisplacement")
    node.inputs["Midlevel"].default_value = midlevel
    node.inputs["Scale"].default_value = scale
    texture = add_texture(tree, image)
    tree.links.new(texture.outputs["Color"], node.inputs["Height"])
    tree.links.new(node.outputs[0], tree.get_output_node("ALL").inputs["Displacement"])
    return node


def connect_normal_map(tree, image, strength=1.0):
    node = tree.nodes.new("ShaderNodeNormalMap")
    node.inputs["Strength"].default_value = strength
    texture = add_texture(tree, image)
    tree.links.new(texture.outputs["Color"], node.inputs["Color"])
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(node.outputs[0], shader.inputs["Normal"])
    return node


def maps_of(target, **words):
    """The maps and the notes that one of the sources gives."""
    arrays = mesh_io.read_object(target, corner_normals=False)
    notes = surface_maps.add_maps(target, arrays, surface_maps.MapChoice(**words))
    return arrays, notes


@pytest.mark.parametrize("backend", ["software", "cpu", "reference"])
def test_constant_displacement_makes_a_bigger_sphere(sphere, backend):
    plain = curvature(sphere, backend=backend)
    sphere.maps = bridge.SurfaceMaps(np.full((3, 5), 1.0, np.float32), midlevel=0.5, scale=2.0)
    bigger = curvature(sphere, backend=backend)
    sphere.maps = None
    np.testing.assert_allclose(plain, 1 / RADIUS, rtol=0.02)
    np.testing.assert_allclose(bigger, 1 / (RADIUS + 1), rtol=0.02)  # 14 quads a quarter circle, as without


@pytest.mark.parametrize(
    ("maps", "words"),
    [
        (bridge.SurfaceMaps(np.zeros(4)), "heights has shape"),
        (bridge.SurfaceMaps(normals=np.zeros((2, 2))), "normal map has shape"),
        (bridge.SurfaceMaps(normals=np.zeros((2, 2, 3))), "corner_tangents is NULL"),
        (bridge.SurfaceMaps(normals=np.zeros((2, 2, 3)), corner_tangents=np.ones((5, 4))), "5 corners"),
        (bridge.SurfaceMaps(np.full((1, 1), np.nan)), "not finite"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(maps, words):
    arrays = as_arrays(*cube_sphere(4))
    arrays.maps = maps
    with pytest.raises(ParadescError, match=words):
        curvature(arrays)


def test_files_are_read_as_they_are_from_bottom_to_top(target, tmp_path):
    path = save_image(tmp_path / "ramp.png", ramp())
    pixels, fine = surface_maps.read_file(path)
    assert not fine
    assert pixels.shape == (2, 3, 4)
    np.testing.assert_allclose(pixels[..., :3], ramp(), atol=1e-6)
    arrays, notes = maps_of(target, displacement=path, midlevel=0.1, scale=3.0)
    np.testing.assert_allclose(arrays.maps.heights, ramp() @ np.array(map_images.LUMINANCE), atol=1e-6)
    assert (arrays.maps.midlevel, arrays.maps.scale) == (0.1, 3.0)
    assert arrays.maps.normals is None
    assert len(notes) == 2
    assert "ramp.png" in notes[0]
    assert "8 bits" in notes[1]
    assert not bpy.data.images.get("ramp.png")


def test_a_normal_map_from_a_file_brings_its_tangent_space(target, tmp_path):
    path = save_image(tmp_path / "ramp.png", ramp())
    arrays, _ = maps_of(target, normal_map=path)
    np.testing.assert_allclose(arrays.maps.normals, ramp(), atol=1e-6)
    assert arrays.maps.corner_tangents.shape == (len(arrays.corner_vertices), 4)
    assert arrays.corner_normals.shape == (len(arrays.corner_vertices), 3)


def test_files_that_are_no_images_are_refused(target, tmp_path):
    broken = tmp_path / "broken.png"
    broken.write_text("no image")
    for path in (tmp_path / "absent.png", broken):
        before = len(bpy.data.images)
        with pytest.raises(ParadescError, match=path.name):
            maps_of(target, displacement=path)
        assert len(bpy.data.images) == before


def test_a_mesh_without_uv_map_takes_no_maps(tmp_path):
    empty_scene()
    target = add_sphere(uv_map=False)
    with pytest.raises(ParadescError, match="no UV map"):
        maps_of(target, displacement=save_image(tmp_path / "a.png", ramp()))


def along(corners, positions, uvs, axis):
    """(n, 3) the direction in which u (0) or v (1) grows, of quads."""
    p, w = positions[corners], uvs
    e1, e2, d1, d2 = p[:, 1] - p[:, 0], p[:, 3] - p[:, 0], w[:, 1] - w[:, 0], w[:, 3] - w[:, 0]
    area = (d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0])[:, None]
    if axis == 0:
        return (e1 * d2[:, 1:] - e2 * d1[:, 1:]) / area
    return (e2 * d1[:, :1] - e1 * d2[:, :1]) / area


def test_tangents_run_along_u_and_bitangents_along_v(target):
    tangents, normals = surface_maps.read_tangent_space(target)
    points, quads, uvs = cube_sphere(12)
    bitangents = tangents[:, 3:] * np.cross(normals, tangents[:, :3])
    np.testing.assert_allclose(np.linalg.norm(tangents[:, :3], axis=1), 1, atol=1e-5)
    np.testing.assert_allclose((tangents[:, :3] * normals).sum(axis=1), 0, atol=1e-5)
    for axis, directions in enumerate((tangents[:, :3], bitangents)):
        way = np.repeat(along(quads, points, uvs, axis), 4, axis=0)
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        # Charts of a cube are sheared towards its corners, tangent spaces are not.
        assert (way * directions).sum(axis=1).min() > 0.8


def test_larger_faces_have_tangents_too(target):
    expected, _ = surface_maps.read_tangent_space(target)
    mesh = target.data
    corners = mesh_io.read_corner_vertices(mesh)
    uvs = mesh_io.read_uvs(mesh)
    # One quad of a flat pair becomes a hexagon: the two quads of a chart side by side without their common edge.
    quads = corners.reshape(-1, 4)
    shared = [np.flatnonzero(np.isin(quads[0], quads[k])).size for k in range(len(quads))]
    other = next(k for k in range(1, len(quads)) if shared[k] == 2 and np.abs(uvs[4 * k] - uvs[0]).max() < 0.1)
    vertices = set(quads[0]) & set(quads[other])
    edge = next(e.index for e in mesh.edges if set(e.vertices) == vertices)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    mesh.edges[edge].select = True
    for vertex in vertices:
        mesh.vertices[vertex].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.context.tool_settings.mesh_select_mode = (False, True, False)
    bpy.ops.mesh.dissolve_edges(use_verts=False)
    bpy.ops.object.mode_set(mode="OBJECT")
    sizes = [polygon.loop_total for polygon in mesh.polygons]
    assert sorted(sizes)[-2:] == [4, 6]
    tangents, normals = surface_maps.read_tangent_space(target)
    assert len(tangents) == len(expected) - 2
    np.testing.assert_allclose(np.linalg.norm(tangents[:, :3], axis=1), 1, atol=1e-5)
    np.testing.assert_allclose((tangents[:, :3] * normals).sum(axis=1), 0, atol=0.02)

    # The other faces' corners have what they had, except the neighbors of the hexagon.
    def key(vertices, tangents):
        return {(int(v), *np.round(t, 2)) for v, t in zip(vertices, tangents, strict=True)}

    unchanged = key(mesh_io.read_corner_vertices(mesh), tangents) & key(corners, expected)
    assert len(unchanged) > 0.95 * len(key(corners, expected))
    assert surface_maps.ORIGINAL_FACE not in mesh.attributes


def test_a_flat_normal_map_gives_the_meshs_own_normals(target):
    tilt_normals(target.data, 0.05)
    own = curvature(mesh_io.read_object(target, corner_normals=True), normals="mesh")
    fitted = curvature(mesh_io.read_object(target, corner_normals=True))
    tree = with_material(target)
    connect_normal_map(tree, make_image("flat", np.full((4, 4, 3), (0.5, 0.5, 1.0))))
    arrays, notes = maps_of(target, material=True)
    mapped = curvature(arrays)
    assert "flat" in notes[0]
    spread = np.abs(own - fitted).mean()
    assert spread > 0.02  # otherwise the test would show nothing
    # The center's normal is the mean of the corners', which "mesh" takes from one place.
    assert np.abs(mapped - own).mean() < 0.02 * spread


def bake_normals(low, high, image):
    """Bakes a normal map of one sphere from another by Cycles, and leaves it in the first one's material."""
    scene = bpy.context.scene
    try:
        scene.render.engine = "CYCLES"
    except TypeError:
        pytest.skip("this Blender has no Cycles")
    scene.cycles.samples, scene.cycles.device = 1, "CPU"
    tree = with_material(low)
    tree.nodes.active = add_texture(tree, image)
    high.select_set(True)
    low.select_set(True)
    bpy.context.view_layer.objects.active = low
    words = {"use_selected_to_active": True, "cage_extrusion": 0.3, "max_ray_distance": 1.0, "margin": 8}
    assert bpy.ops.object.bake(type="NORMAL", **words) == {"FINISHED"}
    if np.abs(surface_maps.read_pixels(image, "baked")[..., :3].mean(axis=(0, 1)) - 0.5).max() < 0.1:
        pytest.skip("this Blender's Cycles bakes nothing here")  # as Debian's 3.4.1 does
    connect_normal_map(tree, image)  # not before: Blender 3.4 bakes nothing into an image that its material uses


def tilt_normals(mesh, deviation):
    """Tilts the custom normals against the sphere's, so that the tangent space of a map matters."""
    points = np.array([vertex.co for vertex in mesh.vertices])
    tilted = points / RADIUS + np.random.default_rng(1).normal(0, deviation, points.shape)
    if hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set_from_vertices((tilted / np.linalg.norm(tilted, axis=1)[:, None]).tolist())


def test_a_normal_map_baked_by_blender_gives_the_fine_sphere():
    empty_scene()
    low, high = add_sphere("low", steps=4), add_sphere("high", steps=48)
    tilt_normals(low.data, 0.12)
    bake_normals(low, high, make_image("baked", np.full((256, 256, 3), 0.5)))
    arrays, _ = maps_of(low, material=True)
    options = bridge.Options(radius=0.08, buffer_size=512, normals="mesh")
    values = []
    for maps in (arrays.maps, None):
        arrays.maps = maps
        settings = job.Settings(("mean_curvature", "local_bending_energy"), options, "software")
        values.append(job.run(arrays, settings).values)
    mapped, own = ({name: np.abs(v[name] * unit - 1).mean() for name, unit in UNITS.items()} for v in values)
    assert own["local_bending_energy"] > 0.3  # of the tilted normals
    assert mapped["local_bending_energy"] < 0.015  # measured 0.8 %: pixels are 1/30 of an edge
    assert mapped["mean_curvature"] < 0.04  # the coarse facets lie inside the sphere: fitted normals have 2.6 % too


def test_a_material_displaces(target):
    tree = with_material(target)
    connect_displacement(tree, make_image("heights", np.full((2, 2, 3), 0.75)), midlevel=0.25, scale=2.0)
    arrays, notes = maps_of(target, material=True)
    assert "heights" in notes[0]
    np.testing.assert_allclose(curvature(arrays), 1 / (RADIUS + 1), rtol=0.03)


def test_a_displacement_in_world_space_takes_the_objects_scale_out(target):
    tree = with_material(target)
    node = connect_displacement(tree, make_image("heights", ramp()), scale=3.0)
    node.space = "WORLD"
    target.scale = (2, 2, -2)
    bpy.context.view_layer.update()
    arrays, _ = maps_of(target, material=True)
    assert arrays.maps.scale == pytest.approx(1.5)
    target.scale = (1, 2, 1)
    bpy.context.view_layer.update()
    with pytest.raises(ParadescError, match="apply the scale"):
        maps_of(target, material=True)


def test_bytes_in_srgb_are_made_linear_as_a_material_does(target, tmp_path):
    image = bpy.data.images.load(str(save_image(tmp_path / "grey.png", np.full((2, 2, 3), 188 / 255))))
    image.colorspace_settings.name = "sRGB"
    tree = with_material(target)
    connect_displacement(tree, image)
    arrays, _ = maps_of(target, material=True)
    np.testing.assert_allclose(arrays.maps.heights, 0.5029, atol=1e-3)  # linear of 188
    image.colorspace_settings.name = "Non-Color"
    arrays, _ = maps_of(target, material=True)
    np.testing.assert_allclose(arrays.maps.heights, 188 / 255, atol=1e-3)


def test_strength_mixes_the_normals_with_the_surfaces_own():
    colors = np.array([[[1.0, 0.5, 0.5], [0.5, 0.5, 1.0]]], np.float32)  # along the tangent; the surface's own
    mixed = surface_maps.with_strength(colors, 0.25)
    np.testing.assert_allclose(2 * mixed - 1, [[[0.25, 0, 0.75], [0, 0, 1]]], atol=1e-6)
    np.testing.assert_array_equal(surface_maps.with_strength(colors, 1.0), colors)


def connect_bump(tree, _image):
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(tree.nodes.new("ShaderNodeBump").outputs[0], shader.inputs["Normal"])


def connect_noise(tree, image):
    node = connect_displacement(tree, image)
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], node.inputs["Height"])


def connect_scale(tree, image):
    node = connect_displacement(tree, image)
    tree.links.new(tree.nodes.new("ShaderNodeValue").outputs[0], node.inputs["Scale"])


def connect_mapping(tree, image):
    connect_displacement(tree, image)
    texture = next(node for node in tree.nodes if node.type == "TEX_IMAGE")
    tree.links.new(tree.nodes.new("ShaderNodeMapping").outputs[0], texture.inputs["Vector"])


def connect_object_normals(tree, image):
    connect_normal_map(tree, image).space = "OBJECT"


def connect_another_uv_map(tree, image):
    connect_normal_map(tree, image).uv_map = "Other"


@pytest.mark.parametrize(
    ("connect", "words"),
    [
        (lambda tree, image: None, "no Displacement or Normal Map node"),
        (connect_bump, "Bump"),
        (connect_noise, "Height of the Displacement"),
        (connect_scale, "Scale of the Displacement"),
        (connect_mapping, "not mapped by a UV map alone"),
        (connect_object_normals, "another space"),
        (connect_another_uv_map, '"Other"'),
    ],
)
def test_materials_without_usable_maps_are_refused(target, connect, words):
    connect(with_material(target), make_image("ramp", ramp()))
    with pytest.raises(ParadescError, match=words) as caught:
        maps_of(target, material=True)
    assert "stone" in caught.value.sentence or "Other" in caught.value.sentence


def test_no_material_and_several_are_refused(target):
    with pytest.raises(ParadescError, match="no material"):
        maps_of(target, material=True)
    with_material(target, "stone")
    with_material(target, "moss")
    target.data.polygons[0].material_index = 1
    with pytest.raises(ParadescError, match='"moss", "stone"'):
        maps_of(target, material=True)


def test_the_operator_takes_the_materials_maps(target):
    import paradesc_blender

    paradesc_blender.register()
    measure_curvature()
    try:
        settings = bpy.context.scene.paradesc
        settings.radius_percent, settings.buffer_size, settings.backend = 6.0, 256, "software"
        settings.material_maps = True
        connect_displacement(with_material(target), make_image("up", np.full((2, 2, 3), 1.0)), midlevel=0.5, scale=2.0)
        assert bpy.ops.paradesc.bake() == {"FINISHED"}
        np.testing.assert_allclose(attribute_values(target.data, "mean_curvature"), 1 / (RADIUS + 1), rtol=0.03)
    finally:
        paradesc_blender.unregister()


@pytest.mark.slow
def test_the_command_line_displaces_by_a_file(paradesc, sphere_obj, tmp_path):
    path = save_image(tmp_path / "white.png", np.ones((2, 2, 3)))
    words = ("--displacement", path, "--midlevel", "0", "--displacement-scale", "0.5", "--output", "out.npz")
    output = accepted(paradesc("bake", sphere_obj, *QUICK, *words))
    assert 'displaced by "white.png"' in output
    np.testing.assert_allclose(loaded(tmp_path / "out.npz")["mean_curvature"], 1 / (RADIUS + 0.5), rtol=0.03)


@pytest.mark.slow
def test_the_command_line_takes_the_materials_maps(paradesc, target, tmp_path):
    image = make_image("up", np.ones((2, 2, 3)))
    image.pack()
    connect_displacement(with_material(target), image, midlevel=0.5, scale=2.0)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    output = accepted(paradesc("bake", tmp_path / "scene.blend", *QUICK, "--material-maps", "--output", "out.npz"))
    assert 'displaced by "up"' in output
    np.testing.assert_allclose(loaded(tmp_path / "out.npz")["mean_curvature"], 1 / (RADIUS + 1), rtol=0.03)


@pytest.mark.slow
def test_the_command_line_refuses_in_one_sentence(paradesc, sphere_obj, tmp_path):
    def run(*words):
        return paradesc("bake", sphere_obj, *QUICK, *words, "--output", "out.npz")

    refused(run("--displacement", "absent.png"), "absent.png")
    refused(run("--material-maps"), "material")
    path = save_image(tmp_path / "white.png", np.ones((2, 2, 3)))
    refused(run("--material-maps", "--normal-map", path), "--material-maps")
    assert not (tmp_path / "out.npz").exists()
