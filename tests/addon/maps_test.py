"""Images over the UV map: what their files contain, and that it agrees with the values at vertices."""

import json
import struct
import zlib

import numpy as np
import pytest

from conftest import real_mesh
from paradesc.bridge import Options, draw_uv_image, fill_gutter
from paradesc.core import job
from paradesc.files import exr, maps, png
from paradesc.files.results import Baked
from shapes import as_arrays, cube_sphere, write_obj

QUICK = ("--radius", "0.06", "--samples", "64", "--buffer", "256", "--backend", "software", "--texels", "128")
NONE = np.float32(np.nan)


def baked(arrays, names=("mean_curvature",), backend="software", **options):
    """One bake of arrays, as the files see it."""
    settings = job.Settings(names, Options(radius=0.06, samples=64, buffer_size=256, **options), backend)
    return Baked("sphere", job.run(arrays, settings), arrays, np.eye(4))


def looked_up(image, uvs):
    """Bilinear (n, c) values of an image (N, N, c) with rows from v = 0 up, at (n, 2)."""
    size = len(image)
    place = np.clip(uvs * size - 0.5, 0, size - 1)
    low = np.minimum(np.floor(place).astype(int), size - 2)
    (x, y), (a, b) = low.T, (place - low).T[:, :, None]
    below = image[y, x] * (1 - a) + image[y, x + 1] * a
    return below * (1 - b) + (image[y + 1, x] * (1 - a) + image[y + 1, x + 1] * a) * b


def pixels_of(path):
    """(N, N, 4) float32 of an image as Blender reads it, rows from v = 0 up."""
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    assert image.type == "IMAGE"
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)


def bumpy():
    """The sphere with a curvature that varies, smoothly."""
    points, quads, uvs = cube_sphere(steps=24)
    points = points * (1 + 0.1 * np.sin(2 * points[:, :1]) * np.cos(points[:, 1:2]))
    return points, quads, uvs


@pytest.mark.slow
@pytest.mark.parametrize("evaluate", ["vertex", "texel"])
def test_an_exr_looked_up_at_a_vertex_agrees_with_its_attribute(paradesc, tmp_path, evaluate):
    path = write_obj(tmp_path / "bumpy.obj", *bumpy())
    words = ("--evaluate", evaluate, "--output", "out.exr", "--output", "out.npz")
    process = paradesc("bake", path, *QUICK[:-1], "512", *words)
    assert process.returncode == 0, process.stderr
    arrays = as_arrays(*bumpy())
    image = pixels_of(tmp_path / "out.exr")
    assert image.shape == (512, 512, 4)
    with np.load(tmp_path / "out.npz") as file:
        values = file["mean_curvature"][arrays.corner_vertices]
    found = looked_up(image[:, :, :1], arrays.corner_uvs)[:, 0]
    span = np.ptp(np.percentile(values, [2.5, 97.5]))
    # An edge is six texels: linear over faces and again over texels, and level into the gutter.
    assert np.abs(found - values).mean() < 0.01 * span
    assert np.abs(found - values).max() < 0.1 * span
    assert np.isfinite(image).all()


def test_blender_reads_an_exr_of_one_descriptor_as_it_was_written(tmp_path):
    written = np.random.default_rng(1).normal(size=(37, 50)).astype(np.float32) * 1e4
    exr.write_exr(tmp_path / "one.exr", {"Y": written})
    read = pixels_of(tmp_path / "one.exr")
    for channel in range(3):
        assert np.array_equal(read[::-1, :, channel], written)


def test_an_exr_names_its_channels_in_alphabetical_order_whatever_order_they_were_given_in(tmp_path):
    """The format requires it; a reader that looks names up by bisection would miss others."""
    given = {name: np.full((3, 5), value, np.float32) for value, name in enumerate(("b.Z", "a", "b.X", "A", "b.Y"))}
    path = tmp_path / "many.exr"
    exr.write_exr(path, given)
    content = path.read_bytes()
    at = content.index(b"channels\0chlist\0") + len(b"channels\0chlist\0")
    (size,) = struct.unpack_from("<i", content, at)
    listed = content[at + 4 : at + 4 + size]
    names, kinds = [], []
    while listed[0]:
        name, listed = listed.split(b"\0", 1)
        names.append(name.decode())
        kinds.append(struct.unpack("<iB3xii", listed[:16]))
        listed = listed[16:]
    assert names == ["A", "a", "b.X", "b.Y", "b.Z"]
    assert set(kinds) == {(exr.FLOAT, 0, 1, 1)}
    assert listed == b"\0"
    lines = only_block(content, len(exr.header(names, 5, 3))).reshape(3, len(names), 5)
    assert all((lines[:, place] == given[name]).all() for place, name in enumerate(names))


def only_block(content, header_bytes):
    """(k,) float32 of the only block, after the header and the offset table."""
    (start,) = struct.unpack_from("<Q", content, header_bytes)
    _, size = struct.unpack_from("<2i", content, start)
    steps = np.frombuffer(zlib.decompress(content[start + 8 : start + 8 + size]), np.uint8)
    parted = np.cumsum(steps - np.uint8(128), dtype=np.uint8) + np.uint8(128)
    halves = np.split(parted, [(len(parted) + 1) // 2])
    return np.ravel(np.stack(halves, axis=1)).view("<f4")


def compositor(bpy, scene):
    """The scene's compositing nodes, of which only the output is left."""
    if hasattr(scene, "compositing_node_group"):  # since Blender 5.0
        tree = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        scene.compositing_node_group = tree
        return tree, tree.nodes.new("NodeGroupOutput")
    scene.use_nodes = True
    scene.node_tree.nodes.clear()
    return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite")


@pytest.mark.slow
def test_blender_finds_a_layer_a_descriptor(paradesc, sphere_obj, tmp_path):
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    names = ("mean_curvature", "principal_direction_max")
    process = paradesc("bake", sphere_obj, *QUICK, "--descriptors", ",".join(names), "--map", "out.exr")
    assert process.returncode == 0, process.stderr
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    tree, output = compositor(bpy, scene)
    node = tree.nodes.new("CompositorNodeImage")
    node.image = bpy.data.images.load(str(tmp_path / "out.exr"))
    assert node.image.type == "MULTILAYER"
    assert [output.name for output in node.outputs] == list(names)
    scene.render.resolution_x = scene.render.resolution_y = 128
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(tmp_path / "layer.exr")
    tree.links.new(node.outputs["mean_curvature"], output.inputs[0])
    bpy.ops.render.render(write_still=True)
    # Radius 2, 64 samples on a coarse sphere; background 0.
    read = pixels_of(tmp_path / "layer.exr")[:, :, 0]
    surface = np.abs(read) > 0.1
    assert surface.mean() > 0.7
    np.testing.assert_allclose(read[surface], 0.5, rtol=0.05)


def decode16(content):
    """(height, width, channels) uint16 and the texts of a 16-bit PNG, by the specification."""
    place, data, texts, header = 8, b"", {}, None
    while place < len(content):
        size, kind = struct.unpack(">I4s", content[place : place + 8])
        body = content[place + 8 : place + 8 + size]
        assert struct.unpack(">I", content[place + 8 + size : place + 12 + size])[0] == zlib.crc32(kind + body)
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"tEXt":
            key, text = body.split(b"\0")
            texts[key.decode()] = text.decode()
        elif kind == b"IDAT":
            data += body
        place += 12 + size
    width, height, bits, color = header[:4]
    assert bits == 16
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[color]
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, -1)
    assert (rows[:, 0] == 2).all()  # each row as difference from the one above
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).view(">u2").reshape(height, width, channels), texts


def test_a_16_bit_png_of_an_operator_says_the_unit_on_its_map(tmp_path):
    options = Options(radius=0.06, samples=16, buffer_size=128, texels=32, map_descriptor="mean_curvature")
    settings = job.Settings(("gradient_magnitude",), options, "software")
    arrays = as_arrays(*bumpy())
    maps.write_png(tmp_path / "x.png", Baked("", job.run(arrays, settings), arrays, np.eye(4)), "gradient_magnitude")
    _, texts = decode16((tmp_path / "x.png").read_bytes())
    assert texts["Description"].endswith("[1/length^2]")


@pytest.mark.slow
def test_a_16_bit_png_says_which_values_its_ends_are(paradesc, tmp_path):
    path = write_obj(tmp_path / "bumpy.obj", *bumpy())
    names = "mean_curvature,shape_index"
    process = paradesc(
        "bake", path, *QUICK, "--backend", "cpu", "--descriptors", names, "--map", "x.png", "--map", "x.exr", "--json", "r.json"
    )
    assert process.returncode == 0, process.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    images = [row for row in report["maps"] if "descriptor" in row]
    assert [row["path"] for row in images] == ["x_mean_curvature.png", "x_shape_index.png"]
    pixels, texts = decode16((tmp_path / "x_mean_curvature.png").read_bytes())
    assert pixels.shape == (128, 128, 1)
    row = images[0]
    values = row["minimum"] + (row["maximum"] - row["minimum"]) * pixels[:, :, 0] / 65535.0
    assert f"{row['minimum']!r}" in texts["Description"]
    assert f"{row['maximum']!r}" in texts["Description"]
    assert "65535" in texts["Description"]
    settings = job.Settings(
        ("mean_curvature",), Options(radius=0.06, samples=64, buffer_size=256, texels=128), "cpu"
    )
    arrays = as_arrays(*bumpy())
    image = maps.image_of(Baked("", job.run(arrays, settings), arrays, np.eye(4)), "mean_curvature")
    exact = fill_gutter(image, maps.GUTTER)[::-1, :, 0]
    surface = exact != 0
    step = (row["maximum"] - row["minimum"]) / 65535
    # Half a step of 16 bits, and what an .obj's seven digits change.
    assert np.abs(values - exact)[surface].max() < step + 1e-3 * (row["maximum"] - row["minimum"])


def test_16_bits_of_three_channels_are_written_as_given():
    image = np.random.default_rng(2).integers(0, 65536, (9, 7, 3)).astype(np.uint16)
    read, texts = decode16(png.encode_png(image, {"Title": "x"}))
    assert np.array_equal(read, image)
    assert texts == {"Title": "x"}


def test_the_gutter_takes_what_lies_beside_it_and_ends():
    image = np.full((40, 40, 1), NONE)
    image[15:25, 15:20] = 3.0
    image[15:25, 20:25] = 5.0
    filled = fill_gutter(image, steps=4)[:, :, 0]
    assert (filled[11:29, 11:15] == 3.0).all()
    assert (filled[11:29, 25:29] == 5.0).all()
    assert not filled[:11].any()
    assert not filled[29:].any()


def test_triangles_on_any_tile_are_drawn_where_a_repeated_texture_shows_them():
    corner = np.array([[0.1, 0.1], [0.4, 0.1], [0.1, 0.4]])
    moved = [np.add(corner, offset) for offset in ([0, 0], [-6.5, 3.5], [0.75, 0])]
    corners = np.arange(9, dtype=np.int32).reshape(3, 3)
    image = draw_uv_image(np.stack(moved), corners, np.repeat([0, 1, 2], 3), 40)
    shown = np.where(np.isnan(image), -1, image)[:, :, 0]
    assert shown[6, 6] == 0
    assert shown[26, 26] == 1
    assert shown[5, 36] == 2
    assert shown[4, 2] == 2  # over the right side and in again from the left
    np.testing.assert_allclose(shown, np.round(shown), atol=1e-6)  # weights add up to 1
    assert set(np.unique(np.round(shown))) == {-1, 0, 1, 2}


def test_a_map_of_texels_is_the_image_where_the_layout_is_the_uv_map():
    result = baked(as_arrays(*bumpy()), evaluate="texel", texels=64)
    image = maps.image_of(result, "mean_curvature")[:, :, 0]
    source = result.results.maps["mean_curvature"]
    both = np.isfinite(image)
    assert both.sum() > 2000
    assert np.isfinite(source[both]).all()
    np.testing.assert_allclose(image[both], source[both], rtol=1e-3)


@pytest.mark.slow
def test_stacked_charts_get_an_image_in_the_uv_map_and_a_note(paradesc, tmp_path):
    points, quads, uvs = cube_sphere()
    stacked = uvs.copy()
    stacked[:, :, 0] = np.mod(uvs[:, :, 0] * 3, 1)  # all columns of charts on one
    path = write_obj(tmp_path / "stacked.obj", points, quads, stacked)
    for evaluate in ("vertex", "texel"):
        process = paradesc("bake", path, *QUICK, "--evaluate", evaluate, "--map", f"{evaluate}.exr", "--json", "r.json")
        assert process.returncode == 0, process.stderr
        assert "the last one" in process.stdout
        assert json.loads((tmp_path / "r.json").read_text())["objects"][0]["field_report"]["private_layout"] == 1
        image = pixels_of(tmp_path / f"{evaluate}.exr")[:, :, 0]
        inside = np.abs(image) > 0.1
        assert inside.mean() > 0.7
        np.testing.assert_allclose(image[inside], 0.5, rtol=0.05)


@pytest.mark.parametrize("evaluate", ["vertex", "texel"])
def test_an_image_lies_in_the_uv_map_where_the_computation_took_its_stretch_back(evaluate):
    points, quads, uvs = bumpy()
    arrays = as_arrays(points, quads, uvs * [0.02, 1])
    before = arrays.corner_uvs.copy()
    result = baked(arrays, evaluate=evaluate, texels=512)
    assert result.results.field_report["private_layout"] == 2
    np.testing.assert_array_equal(arrays.corner_uvs, before)
    assert maps.notes(result) == []  # no charts share a place
    image = maps.image_of(result, "mean_curvature")
    expected = maps.image_of(baked(arrays, backend="cpu", evaluate=evaluate, texels=512), "mean_curvature")
    np.testing.assert_array_equal(np.isfinite(image), np.isfinite(expected))
    assert np.isfinite(image).sum() > 3000
    both = np.isfinite(image)
    span = np.ptp(np.percentile(expected[both], [2.5, 97.5]))
    # The processor measures at the texels that are drawn, OpenGL at those of its own layout, up to a texel away.
    assert np.abs(image - expected)[both].max() < 0.1 * span


@pytest.mark.slow
def test_image_that_fits_no_uv_map_says_so(paradesc, tmp_path):
    path = write_obj(tmp_path / "bare.obj", *cube_sphere(4)[:2])
    process = paradesc("bake", path, *QUICK, "--map", "bare.exr")
    assert process.returncode == 0, process.stderr
    assert "they fit no UV map of the mesh" in process.stdout
    assert maps.notes(baked(as_arrays(*cube_sphere(4)))) == []


@pytest.mark.parametrize("evaluate", ["vertex", "texel"])
def test_coordinates_beyond_the_unit_square_are_drawn_as_a_repeated_texture_shows_them(evaluate):
    arrays = as_arrays(*bumpy())
    expected = maps.image_of(baked(arrays, texels=96), "mean_curvature")
    arrays.corner_uvs = arrays.corner_uvs - np.float32([3, 5])
    arrays.corner_uvs[: len(arrays.corner_uvs) // 2] += np.float32([1, 0])  # three of the six charts on another tile
    result = baked(arrays, evaluate=evaluate, texels=96)
    assert result.results.mesh_report["uv_remapped"] == 1
    image = maps.image_of(result, "mean_curvature")
    both = np.isfinite(image) & np.isfinite(expected)
    assert both.sum() > 0.99 * np.isfinite(expected).sum()
    span = np.ptp(np.percentile(expected[both], [2.5, 97.5]))
    assert np.abs(image - expected)[both].mean() < 0.03 * span  # half the texels each way, for two tiles in the square


@pytest.mark.slow
def test_the_reference_makes_images_too_but_has_no_buffers(paradesc, sphere_obj, tmp_path):
    words = ("--radius", "0.06", "--backend", "reference", "--texels", "32")
    process = paradesc("bake", sphere_obj, *words, "--map", "out.exr")
    assert process.returncode == 0, process.stderr
    assert np.median(pixels_of(tmp_path / "out.exr")[:, :, 0]) == pytest.approx(0.5, rel=0.03)
    refused = paradesc("bake", sphere_obj, *words, "--dump-buffers", "dump")
    assert refused.returncode == 2
    assert "reference" in refused.stderr
    assert not (tmp_path / "dump").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "--output"),
        (("--map", "x.tif"), ".exr"),
        (("--map", "none/x.exr"), "none"),
        (("--dump-buffers", "a/b"), 'to write "b" into'),
    ],
)
def test_what_cannot_be_written_is_refused_before_anything_is_computed(paradesc, sphere_obj, words, said):
    process = paradesc("bake", sphere_obj, *words)
    assert process.returncode == 2
    assert said in process.stderr
    assert process.stderr.count("\n") == 1


@pytest.mark.slow
def test_dumped_buffers_hold_what_was_baked(paradesc, sphere_obj, tmp_path):
    process = paradesc("bake", sphere_obj, *QUICK, "--dump-buffers", "dump")
    assert process.returncode == 0, process.stderr
    folder = tmp_path / "dump"
    names = ("position", "normal", "charts", "adjacency", "distortion", "mean_curvature")
    assert sorted(path.name for path in folder.iterdir()) == sorted(["buffers.npz", *(f"{name}.png" for name in names)])
    with np.load(folder / "buffers.npz") as file:
        arrays = {name: file[name] for name in file.files}
    carried = arrays["chart"] >= 0
    assert 0.7 < carried.mean() < 1
    assert set(np.unique(arrays["chart"])) == {-1, 0, 1, 2, 3, 4, 5}
    np.testing.assert_allclose(np.linalg.norm(arrays["position"][carried], axis=1), 2, rtol=0.02)
    np.testing.assert_allclose(np.linalg.norm(arrays["normal"][carried], axis=1), 1, atol=1e-4)
    assert np.isnan(arrays["position"][~carried]).all()
    area = np.nansum(arrays["distortion"][:, :, 3]) / 256**2
    assert area == pytest.approx(16 * np.pi, rel=0.1)  # and half a texel beyond every border
    assert (arrays["neighbor"] >= 0).sum() > 6 * 4 * 60
    assert (arrays["neighbor"][arrays["neighbor"] >= 0] != arrays["chart"][arrays["neighbor"] >= 0]).all()


@pytest.mark.slow
def test_half_takes_less_memory_and_the_summary_says_so(paradesc, sphere_obj, tmp_path):
    for precision, size in (("full", "3.1 MB"), ("half", "2.1 MB")):
        process = paradesc("bake", sphere_obj, *QUICK, "--precision", precision, "--output", f"{precision}.npz")
        assert process.returncode == 0, process.stderr
        assert size in process.stdout
    with np.load(tmp_path / "full.npz") as full, np.load(tmp_path / "half.npz") as half:
        np.testing.assert_allclose(half["mean_curvature"], full["mean_curvature"], rtol=1e-3)


@pytest.mark.slow
def test_a_real_mesh_has_the_same_values_at_texels(tmp_path, paradesc):
    path = real_mesh("bob.obj")
    words = ("bake", path, "--radius", "0.05", "--samples", "64", "--buffer", "512", "--backend", "software")
    for evaluate in ("vertex", "texel"):
        process = paradesc(*words, "--evaluate", evaluate, "--texels", "256", "--output", f"{evaluate}.npz")
        assert process.returncode == 0, process.stderr
    with np.load(tmp_path / "vertex.npz") as one, np.load(tmp_path / "texel.npz") as other:
        a, b = one["mean_curvature"], other["mean_curvature"]
    assert np.isfinite(b).all()
    assert np.abs(a - b).mean() < 0.01 * np.ptp(np.percentile(a, [2.5, 97.5]))
