"""Bake to Image: files beside the .blend or within it, images of data, material nodes, and what a failure leaves."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from maps_test import decode16  # noqa: E402

from paradesc.bridge import ParadescError, abi  # noqa: E402
from paradesc.commands.main import make_parser  # noqa: E402
from paradesc.files import image_files  # noqa: E402
from paradesc_blender.bake import image_batch  # noqa: E402
from scene import add_sphere, cancel_at, fingerprint, saved_scene, small_bake  # noqa: E402
from shapes import write_obj  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
SIZE = 96


@pytest.fixture
def settings():
    """A sphere that is not saved, and settings that take a moment."""
    add_sphere("ball")
    made = small_bake("cpu")
    made.texels = SIZE
    return made


@pytest.fixture
def folder(settings, tmp_path):
    """The folder of the .blend, which has been saved."""
    saved_scene(tmp_path / "scene.blend")
    return tmp_path


def pngs_in(folder):
    return sorted(path.name for path in folder.iterdir() if path.suffix != ".blend")


def pixels_of(image):
    """(N, N, 4) float32, rows from the top down."""
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)[::-1]


def test_a_texture_lies_beside_the_blend_and_is_an_image_of_data(folder, capfd):
    target = bpy.data.objects["ball"]
    target.data["paradesc"] = {"attributes": []}  # which then says what was made
    before = fingerprint(target)
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    assert fingerprint(target) == before
    assert pngs_in(folder) == ["ball_curvature.png"]
    (image,) = bpy.data.images
    assert image.name == "ball_curvature.png"
    assert bpy.path.abspath(image.filepath) == str(folder / "ball_curvature.png")
    assert image.colorspace_settings.name == "Non-Color"
    written, _ = decode16((folder / "ball_curvature.png").read_bytes())
    np.testing.assert_allclose(pixels_of(image)[:, :, :1], written / 65535, atol=1e-6)
    said = [line for line in capfd.readouterr().out.splitlines() if "ball_curvature.png, 96 × 96, in" in line]
    assert len(said) == 1
    assert str(folder) in said[0]


def test_a_second_bake_fills_the_same_image(folder, settings):
    bpy.ops.paradesc.bake_image()
    (image,) = bpy.data.images
    before = pixels_of(image)
    settings.texels = 64
    bpy.context.scene.paradesc_looks.span = "fixed"
    bpy.ops.paradesc.bake_image()
    assert list(bpy.data.images) == [image]
    assert tuple(image.size) == (64, 64)
    assert np.median(pixels_of(image)[:, :, 0]) == pytest.approx(0.75, abs=0.02)  # 0.5 between -1 and 1
    assert len(before) == SIZE


def test_without_a_folder_images_are_packed_into_the_blend(settings, tmp_path, capfd):
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    (image,) = bpy.data.images
    assert image.packed_file is not None
    assert tuple(image.size) == (SIZE, SIZE)
    assert image.colorspace_settings.name == "Non-Color"
    assert "not saved yet" in capfd.readouterr().out
    written, _ = decode16(image.packed_file.data)
    np.testing.assert_allclose(pixels_of(image)[:, :, :1], written / 65535, atol=1e-6)
    settings.texels = 64
    bpy.ops.paradesc.bake_image()
    assert list(bpy.data.images) == [image]
    assert tuple(image.size) == (64, 64)
    assert pixels_of(image).shape == (64, 64, 4)
    saved_scene(tmp_path / "later.blend")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "later.blend"))
    assert len(pixels_of(bpy.data.images["ball_curvature"])) == 64


def test_each_descriptor_has_a_texture_under_the_name_that_engines_expect(folder, settings):
    settings.descriptors = {"mean_curvature", "cavity", "convexity", "ambient_openness", "curvedness"}
    bpy.ops.paradesc.bake_image()
    words = ("cavity", "curvature", "curvedness", "edges", "openness")
    assert pngs_in(folder) == [f"ball_{word}.png" for word in words]


def test_packed_channels_are_one_texture(folder, settings):
    settings.image_packed = True
    bpy.ops.paradesc.bake_image()
    assert pngs_in(folder) == ["ball_masks.png"]
    pixels, texts = decode16((folder / "ball_masks.png").read_bytes())
    assert pixels.shape == (SIZE, SIZE, 3)
    assert [name in texts["Description"] for name in image_files.PACKED] == [True] * 3
    settings.image_packed, settings.descriptors = False, {"convexity"}
    bpy.ops.paradesc.bake_image()
    alone, _ = decode16((folder / "ball_edges.png").read_bytes())
    # The other descriptors take more samples.
    np.testing.assert_allclose(pixels[:, :, 1].astype(float), alone[:, :, 0].astype(float), atol=0.01 * 65535)
    assert np.median(alone) > 0.05 * 65535


def test_outside_is_transparent_on_request(folder, settings):
    settings.image_outside, settings.texels = "transparent", 256
    uvs = bpy.data.objects["ball"].data.uv_layers.active.data
    values = np.empty(2 * len(uvs), np.float32)
    uvs.foreach_get("uv", values)
    uvs.foreach_set("uv", 0.5 * values)
    bpy.ops.paradesc.bake_image()
    alpha = pixels_of(bpy.data.images[0])[:, :, 3]
    assert set(np.unique(alpha)) == {0.0, 1.0}
    assert bpy.data.images[0].alpha_mode == "CHANNEL_PACKED"


def test_several_meshes_have_textures_of_their_own(folder):
    add_sphere("a b", steps=4)
    add_sphere("a_b", steps=4)
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    assert pngs_in(folder) == ["a_b_2_curvature.png", "a_b_curvature.png", "ball_curvature.png"]


def test_a_mesh_without_a_material_gets_one_that_shows_the_texture(folder, settings):
    settings.image_to_material, settings.descriptors = True, {"cavity", "convexity"}
    bpy.ops.paradesc.bake_image()
    bpy.ops.paradesc.bake_image()
    material = bpy.data.objects["ball"].active_material
    (found,) = bpy.data.materials
    assert found == material
    nodes = [node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    assert [node.image.name for node in nodes] == ["ball_cavity.png", "ball_edges.png"]
    assert material.node_tree.nodes.active == nodes[1]  # a sphere has no cavity to show
    (link,) = nodes[1].outputs["Color"].links
    assert link.to_socket.name == "Base Color"
    assert not nodes[0].outputs["Color"].is_linked


def test_the_users_own_material_gets_a_node_and_no_link(folder, settings):
    settings.image_to_material = True
    material = bpy.data.materials.new("mine")
    material.use_nodes = True
    bpy.data.objects["ball"].data.materials.append(material)
    links = len(material.node_tree.links)
    bpy.ops.paradesc.bake_image()
    node = material.node_tree.nodes.active
    assert node.image.name == "ball_curvature.png"
    assert node.select
    assert len(material.node_tree.links) == links
    assert list(bpy.data.materials) == [material]


def test_a_linked_material_is_one_sentence_and_no_image_is_written(folder, settings, tmp_path_factory):
    library = tmp_path_factory.mktemp("library") / "library.blend"
    bpy.data.libraries.write(str(library), {bpy.data.materials.new("theirs")})
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.materials = ["theirs"]
    bpy.data.objects["ball"].data.materials.append(wanted.materials[0])
    settings.image_to_material = True
    with pytest.raises(RuntimeError, match='"theirs" is linked from another file; make it local first'):
        bpy.ops.paradesc.bake_image()
    assert pngs_in(folder) == []
    assert not bpy.data.images


def test_cancelled_at_any_time_nothing_is_left(folder):
    for fraction in (0.0, 0.3, 0.75, 0.95):
        batch = image_batch.ImageBatch(bpy.context)
        cancel_at(batch, fraction)
        assert pngs_in(folder) == []
        assert not bpy.data.images


def test_a_file_that_cannot_be_written_is_one_sentence_and_keeps_the_old_one(folder, monkeypatch):
    (folder / "ball_curvature.png").write_bytes(b"old")

    def full(_path, _content, _writer):
        raise ParadescError(abi.STATUS_UNKNOWN, "No space left on device.")

    monkeypatch.setattr(image_batch, "write_whole", full)
    with pytest.raises(RuntimeError, match="No space left"):
        bpy.ops.paradesc.bake_image()
    assert (folder / "ball_curvature.png").read_bytes() == b"old"
    assert pngs_in(folder) == ["ball_curvature.png"]


@pytest.mark.parametrize("uv_map", [True, False])
@pytest.mark.parametrize("size", [(0, 0, 0), (1, 0, 0)])
def test_a_mesh_without_area_is_one_sentence_and_keeps_its_uv_maps(folder, size, uv_map):
    mesh = bpy.data.objects["ball"].data
    for vertex in mesh.vertices:
        vertex.co = [place * side for place, side in zip(vertex.co, size, strict=True)]
    if not uv_map:
        mesh.uv_layers.remove(mesh.uv_layers[0])
    names = mesh.uv_layers.keys()
    with pytest.raises(RuntimeError, match=r"^Error: The mesh has no area; there is no surface to measure\.$"):
        bpy.ops.paradesc.bake_image()
    assert mesh.uv_layers.keys() == names
    assert pngs_in(folder) == []


def test_it_works_in_edit_mode(folder):
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.paradesc.bake_image("INVOKE_DEFAULT") == {"FINISHED"}
    assert bpy.data.objects["ball"].mode == "EDIT"
    assert pngs_in(folder) == ["ball_curvature.png"]


def test_an_image_keeps_how_people_use_it(folder, settings):
    bpy.ops.paradesc.bake_image()
    (image,) = bpy.data.images
    image.alpha_mode = "STRAIGHT"
    own = bpy.data.images.load(image.filepath, check_existing=False)
    own.colorspace_settings.name = "sRGB"
    settings.texels = 64
    bpy.ops.paradesc.bake_image()
    assert list(bpy.data.images) == [image, own]
    assert (image.colorspace_settings.name, image.alpha_mode) == ("Non-Color", "STRAIGHT")
    assert own.colorspace_settings.name == "sRGB"
    assert [tuple(one.size) for one in (image, own)] == [(64, 64)] * 2


# ---- The command line

WORDS = ("--radius", "0.08", "--samples", "32", "--backend", "cpu", "--texels", "48")


def test_the_command_line_keeps_its_defaults():
    given = make_parser().parse_args(["bake", "x.obj", "--map", "x.png"])
    assert (given.png_range, given.pack, given.texels) == ("values", (), None)


def test_a_png_spans_the_range_of_the_colors_on_request(run, report, sphere_obj, tmp_path):
    words = ("bake", sphere_obj, *WORDS, "--range=-1:1", "--map", "x.png", "--json", "report.json")
    assert run(*words, "--png-range", "colors").code == 0
    pixels, texts = decode16((tmp_path / "x.png").read_bytes())
    (row,) = report()["maps"]
    assert f"{row['minimum']!r}" in texts["Description"]
    assert row["maximum"] == 1.0
    assert np.median(pixels) == pytest.approx(32768 + 32767 * 0.5, rel=0.01)
    assert run(*words).code == 0
    usual, texts = decode16((tmp_path / "x.png").read_bytes())
    (row,) = report()["maps"]
    assert 0.4 < row["minimum"] < row["maximum"] < 0.6
    assert (usual.min(), usual.max()) == (0, 65535)


def test_packed_channels_are_a_file_of_their_own(run, report, sphere_obj, tmp_path):
    pack = ("--pack", "cavity,convexity,ambient_openness")
    words = ("bake", sphere_obj, *WORDS, "--map", "x.png", "--map", "x.exr", "--json", "report.json")
    assert run(*words, *pack).code == 0
    assert {"x_masks.png", "x.exr"} <= {path.name for path in tmp_path.iterdir()}
    assert not (tmp_path / "x.png").exists()
    pixels, _ = decode16((tmp_path / "x_masks.png").read_bytes())
    assert pixels.shape == (48, 48, 3)
    row = next(row for row in report()["maps"] if "channels" in row)
    assert [channel["descriptor"] for channel in row["channels"]] == list(image_files.PACKED)
    assert (row["channels"][0]["minimum"], row["channels"][0]["maximum"]) == (0.0, 0.05)  # a sphere has no cavity


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--pack", "cavity,convexity"), "three or four"),
        (("--pack", "cavity,cavity,convexity"), "three or four different"),
        (("--pack", "cavity,convexity,nothing"), '"nothing" is not a descriptor'),
        (("--pack", "cavity,convexity,principal_direction_max"), "is not a descriptor for a channel"),
        (("--pack", "cavity,convexity,ambient_openness", "--descriptors", "cavity"), "convexity, ambient_openness"),
    ],
    ids=str,
)
def test_what_cannot_be_packed_is_refused(run, tmp_path, words, said):
    path = write_obj(tmp_path / "x.obj", np.eye(3), np.array([[0, 1, 2]]))
    ended = run("bake", path, "--map", "x.png", *words)
    assert ended.code == 2
    assert said in ended.error


def test_packing_needs_a_png(run, sphere_obj):
    ended = run("bake", sphere_obj, "--map", "x.exr", "--pack", "cavity,convexity,ambient_openness")
    assert ended.code == 2
    assert "--map IMAGE.png" in ended.error
