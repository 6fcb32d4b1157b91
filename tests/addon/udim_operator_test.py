"""Bake to Image over several UDIM tiles: files, tiled images and their tiles in Blender, and the command line."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from image_operator_test import pixels_of, pngs_in  # noqa: E402
from maps_test import decode16  # noqa: E402

from paradesc_blender.bake import image_batch  # noqa: E402
from scene import add_sphere, cancel_at, saved_scene, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
SIZE = 64
SIX = [1001, 1002, 1003, 1011, 1012, 1013]


def in_tiles(target, scale=(3, 2), move=(0, 0)):
    """Gives each of the sphere's charts a tile of its own."""
    layer = target.data.uv_layers.active.data
    uvs = np.empty(2 * len(layer), np.float32)
    layer.foreach_get("uv", uvs)
    layer.foreach_set("uv", (uvs.reshape(-1, 2) * np.float32(scale) + np.float32(move)).ravel())
    target.data.update()
    return target


def names_of(stem, tiles):
    return [f"{stem}.{tile}.png" for tile in tiles]


@pytest.fixture
def settings():
    """A sphere over six tiles that is not saved, and settings that take a moment."""
    in_tiles(add_sphere("ball"))
    made = small_bake("cpu")
    made.texels = SIZE
    return made


@pytest.fixture
def folder(settings, tmp_path):
    """The folder of the .blend, which has been saved."""
    saved_scene(tmp_path / "scene.blend")
    return tmp_path


def tiles_of(image):
    return [tile.number for tile in image.tiles]


def test_tiles_lie_beside_the_blend_and_are_one_tiled_image_of_data(folder, capfd):
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    assert pngs_in(folder) == names_of("ball_curvature", SIX)
    (image,) = bpy.data.images
    assert image.name == "ball_curvature.<UDIM>.png"
    assert image.source == "TILED"
    assert bpy.path.abspath(image.filepath) == str(folder / "ball_curvature.<UDIM>.png")
    assert image.colorspace_settings.name == "Non-Color"
    assert tiles_of(image) == SIX
    assert [tuple(tile.size) for tile in image.tiles] == [(SIZE, SIZE)] * 6
    first, _ = decode16((folder / "ball_curvature.1001.png").read_bytes())
    np.testing.assert_allclose(pixels_of(image)[:, :, :1], first / 65535, atol=1e-6)
    assert "6 images, ball_curvature.1001.png to ball_curvature.1013.png, 64 × 64" in capfd.readouterr().out


def test_a_second_bake_fills_the_same_image_and_follows_the_tiles(folder, settings):
    bpy.ops.paradesc.bake_image()
    (image,) = bpy.data.images
    in_tiles(bpy.data.objects["ball"], (1, 1), (1, 0))
    settings.texels = 32
    bpy.ops.paradesc.bake_image()
    assert list(bpy.data.images) == [image]
    assert tiles_of(image) == [tile + 1 for tile in SIX] == [1002, 1003, 1004, 1012, 1013, 1014]
    assert [tuple(tile.size) for tile in image.tiles] == [(32, 32)] * 6
    first, _ = decode16((folder / "ball_curvature.1002.png").read_bytes())
    np.testing.assert_allclose(pixels_of(image)[:, :, :1], first / 65535, atol=1e-6)


def test_without_a_folder_all_tiles_are_packed_into_the_blend(settings, tmp_path):
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    (image,) = bpy.data.images
    assert (image.name, image.source, image.filepath) == ("ball_curvature", "TILED", "//ball_curvature.<UDIM>.png")
    assert [packed.tile_number for packed in image.packed_files] == SIX
    bpy.ops.paradesc.bake_image()
    assert list(bpy.data.images) == [image]
    saved_scene(tmp_path / "later.blend")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "later.blend"))
    image = bpy.data.images["ball_curvature"]
    assert tiles_of(image) == SIX
    assert pixels_of(image).shape == (SIZE, SIZE, 4)
    assert image.colorspace_settings.name == "Non-Color"


def test_a_packed_image_follows_a_map_that_gets_tiles_and_loses_them(settings):
    target, sizes = bpy.data.objects["ball"], []
    for scale in ((1 / 3, 1 / 2), (3, 2), (1 / 3, 1 / 2)):
        in_tiles(target, scale)
        bpy.ops.paradesc.bake_image()
        (image,) = bpy.data.images
        sizes.append((image.source, len(image.packed_files), tuple(image.size)))
    assert sizes == [("FILE", 1, (SIZE, SIZE)), ("TILED", 6, (SIZE, SIZE)), ("FILE", 1, (SIZE, SIZE))]


def test_a_map_in_one_other_tile_is_a_tiled_image_of_that_tile(folder, settings):
    in_tiles(bpy.data.objects["ball"], (1 / 3, 1 / 2), (2, 3))
    bpy.ops.paradesc.bake_image()
    assert pngs_in(folder) == ["ball_curvature.1033.png"]
    (image,) = bpy.data.images
    assert (image.source, tiles_of(image)) == ("TILED", [1033])


def test_the_tiles_of_packed_channels_go_into_the_material(folder, settings):
    settings.image_packed = settings.image_to_material = True
    bpy.ops.paradesc.bake_image()
    bpy.ops.paradesc.bake_image()
    assert pngs_in(folder) == names_of("ball_masks", SIX)
    pixels, _ = decode16((folder / "ball_masks.1012.png").read_bytes())
    assert pixels.shape == (SIZE, SIZE, 3)
    tree = bpy.data.objects["ball"].active_material.node_tree
    (node,) = [node for node in tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    assert (node.image.name, node.image.source) == ("ball_masks.<UDIM>.png", "TILED")
    assert tree.nodes.active == node


def test_tiles_bring_the_detail_of_another_mesh(folder, settings):
    fine = add_sphere("fine", steps=16, uv_map=False)
    low = bpy.data.objects["ball"]
    low.select_set(True)
    fine.select_set(True)
    bpy.context.view_layer.objects.active = low
    assert bpy.ops.paradesc.bake_onto() == {"FINISHED"}
    assert pngs_in(folder) == names_of("ball_curvature", SIX)
    pixels = [decode16((folder / name).read_bytes())[0] for name in pngs_in(folder)]
    # The sphere has one curvature, on all tiles; the fine one's vertices differ by some thousandths of it.
    assert np.ptp([np.median(part) for part in pixels]) < 0.01 * 65535


def test_what_lies_beside_all_tiles_is_one_image_and_one_sentence(folder, settings, capfd):
    in_tiles(bpy.data.objects["ball"], (1, 1), (-1, 0))
    bpy.ops.paradesc.bake_image()
    assert pngs_in(folder) == ["ball_curvature.png"]
    assert "outside of the UDIM tiles" in capfd.readouterr().out


def test_cancelled_between_tiles_nothing_is_left(folder):
    for fraction in (0.0, 0.4, 0.9):
        batch = image_batch.ImageBatch(bpy.context)
        cancel_at(batch, fraction)
        assert pngs_in(folder) == []
        assert not bpy.data.images
