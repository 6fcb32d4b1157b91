"""Images and buffers that the panel's bake writes, and what it leaves when it cannot."""

import re

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.files import bake_files, maps  # noqa: E402
from paradesc_blender.bake import batch  # noqa: E402
from paradesc_blender.scene import targets  # noqa: E402
from scene import add_sphere, fingerprint, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def settings(tmp_path):
    add_sphere("ball")
    made = small_bake()
    made.texels = 64
    made.write_image, made.image_path = True, str(tmp_path / "curves.png")
    return made


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def pixels_of(path):
    image = bpy.data.images.load(str(path))
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(64, 64, -1)


def test_an_exr_beside_the_attributes_holds_the_values(settings, tmp_path, capfd):
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert f"Wrote {tmp_path / 'curves.exr'}" in capfd.readouterr().out
    assert names_in(tmp_path) == ["curves.exr"]  # the suffix follows the format
    values = pixels_of(tmp_path / "curves.exr")[..., 0]
    np.testing.assert_allclose(values[values != 0], 0.5, rtol=0.1)
    assert np.mean(values != 0) > 0.5
    assert "mean_curvature" in bpy.data.objects["ball"].data.attributes


def test_pngs_are_a_file_a_descriptor(settings, tmp_path):
    settings.image_format, settings.descriptors = ".png", {"mean_curvature", "curvedness"}
    bpy.ops.paradesc.bake()
    assert names_in(tmp_path) == ["curves_curvedness.png", "curves_mean_curvature.png"]


def test_several_meshes_have_files_of_their_own(settings, tmp_path):
    add_sphere("a b")
    add_sphere("a_b")
    settings.write_buffers, settings.buffers_path = True, str(tmp_path / "buffers")
    bpy.ops.paradesc.bake()
    folders = [f"buffers_{word}" for word in ("a_b", "a_b_2", "ball")]
    assert names_in(tmp_path) == [*folders, "curves_a_b.exr", "curves_a_b_2.exr", "curves_ball.exr"]
    assert {"buffers.npz", "charts.png", "normal.png"} <= set(names_in(tmp_path / folders[0]))


def test_a_file_that_cannot_be_brought_to_its_place_leaves_the_mesh_as_it_was(settings, tmp_path, monkeypatch):
    def refuse(_files):
        raise PermissionError(13, "Permission denied", "curves.exr")

    monkeypatch.setattr(bake_files.Files, "commit", refuse)
    target = bpy.data.objects["ball"]
    before = fingerprint(target)
    with pytest.raises(RuntimeError, match="cannot be moved to its place"):
        bpy.ops.paradesc.bake()
    assert fingerprint(target) == before
    assert names_in(tmp_path) == []


def test_without_attributes_the_mesh_stays_as_it_is(settings, tmp_path):
    settings.write_attributes = False
    target = bpy.data.objects["ball"]
    before = fingerprint(target)
    bpy.ops.paradesc.bake()
    assert fingerprint(target) == before
    assert names_in(tmp_path) == ["curves.exr"]


def test_nothing_to_write_is_said_by_the_poll(settings):
    settings.write_attributes = settings.write_image = False
    assert "nothing to write" in targets.obstacle(bpy.context)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"image_path": "//curves.exr"}, "Save the .blend first"),
        ({"image_path": " "}, "has no path"),
        ({"image_path": "/no/such/folder/curves.exr"}, "There is no folder"),
        ({"write_buffers": True, "buffers_path": "/no/such/folder/buffers"}, "There is no folder"),
        ({"write_buffers": True, "backend": "reference"}, "The backend reference bakes no buffers"),
    ],
    ids=str,
)
def test_files_that_cannot_be_written_are_one_sentence_before_anything_is_computed(settings, tmp_path, change, words):
    settings.buffers_path = str(tmp_path / "buffers")
    for name, value in change.items():
        setattr(settings, name, value)
    before = fingerprint(bpy.data.objects["ball"])
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.paradesc.bake()
    assert fingerprint(bpy.data.objects["ball"]) == before
    assert names_in(tmp_path) == []


def test_an_image_needs_a_uv_map_of_the_mesh(settings, tmp_path):
    layers = bpy.data.objects["ball"].data.uv_layers
    layers.remove(layers[0])
    with pytest.raises(RuntimeError, match="has no UV map, and an image needs one"):
        bpy.ops.paradesc.bake()
    assert names_in(tmp_path) == []


def test_an_image_that_fails_leaves_the_old_one_and_no_half_one(settings, tmp_path, monkeypatch):
    (tmp_path / "curves.exr").write_bytes(b"old")

    def full(path, _baked, _shown=None):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(maps, "write_exr", full)
    before = fingerprint(bpy.data.objects["ball"])
    with pytest.raises(RuntimeError, match="No space left"):
        bpy.ops.paradesc.bake()
    assert (tmp_path / "curves.exr").read_bytes() == b"old"
    assert names_in(tmp_path) == ["curves.exr"]
    assert fingerprint(bpy.data.objects["ball"]) == before


def test_cancelled_between_two_meshes_no_file_is_left(settings, tmp_path):
    add_sphere("other")
    (tmp_path / "curves_other.exr").write_bytes(b"old")
    made = batch.Batch(bpy.context)
    made.step()
    made.step(wait=True)
    part, whole = names_in(tmp_path)
    assert re.fullmatch(r"[.]curves_other[.]exr[.][0-9a-f]{8}[.]part", part)
    assert whole == "curves_other.exr"
    made.step()
    made.close()
    assert names_in(tmp_path) == ["curves_other.exr"]
    assert (tmp_path / "curves_other.exr").read_bytes() == b"old"


def test_blender_knows_of_every_path_that_it_may_be_relative():
    scene = bpy.context.scene
    groups = [getattr(scene, name) for name in dir(scene) if name.startswith("paradesc")]
    found = [item for group in groups for item in group.bl_rna.properties if item.subtype in ("FILE_PATH", "DIR_PATH")]
    assert {item.identifier for item in found} == {"image_path", "buffers_path", "cache_folder"}
    if hasattr(found[0], "is_path_supports_blend_relative"):  # since 4.5; without, // is warned of
        assert all(item.is_path_supports_blend_relative for item in found)
