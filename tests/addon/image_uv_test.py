"""Bake to Image on meshes whose UV map is missing or of no use: they get one of ours, and theirs stay as they are."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from image_operator_test import pixels_of, pngs_in  # noqa: E402

from paradesc.bridge import InputError, draw_uv_image  # noqa: E402
from paradesc.core import uv_faults  # noqa: E402
from paradesc_blender.bake import image_batch  # noqa: E402
from paradesc_blender.scene import image_results, mesh_io, unwrap, uv_maps  # noqa: E402
from scene import add_sphere, cancel_at, fingerprint, saved_scene, select, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
NAME = uv_maps.NAME


@pytest.fixture
def settings(tmp_path):
    """A sphere without a UV map, in a file that is saved."""
    add_sphere("ball", uv_map=False)
    made = small_bake("cpu")
    made.texels = 128
    saved_scene(tmp_path / "scene.blend")
    return made


def ball():
    return bpy.data.objects["ball"]


def add_map(name, uvs):
    """Gives the ball one more map, and makes it the active one."""
    layers = ball().data.uv_layers
    layer = layers.new(name=name, do_init=False)
    unwrap.write_uvs(layer, np.asarray(uvs, np.float32))
    layers.active = layer
    return layer.name


def map_names():
    return ball().data.uv_layers.keys()


def uvs_of(name):
    return unwrap.read_uvs(ball().data.uv_layers[name])


def over_each_other():
    """Every face over the whole square, as Blender's Reset has it."""
    return np.tile([(0, 0), (1, 0), (1, 1), (0, 1)], (len(ball().data.polygons), 1))


def test_a_mesh_without_a_map_gets_one_that_its_image_lies_over(settings, tmp_path, capfd):
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    assert map_names() == [NAME]
    assert ball().data.uv_layers.active.name == NAME
    made = image_results.found(ball())
    assert made.uv_map == NAME
    assert made.notes == f'New UV map "{NAME}": the mesh has no UV map.'
    assert made.notes in capfd.readouterr().out
    assert pngs_in(tmp_path) == ["ball_curvature.png"]


def test_the_map_that_is_made_covers_every_face_once(settings):
    name = uv_maps.make(ball())
    arrays = mesh_io.read_object(ball(), False, False)
    corners = arrays.corner_uvs[arrays.triangle_corners]
    assert name == NAME
    assert (np.abs(uv_faults.uv_areas(arrays.corner_uvs, arrays.triangle_corners)) > 0).all()
    texels = draw_uv_image(corners, arrays.triangle_vertices, np.ones(len(arrays.positions), np.float32), 1024)
    covered, area = np.isfinite(texels).mean(), uv_maps.texel_centers.uv_area(arrays)
    assert covered == pytest.approx(area, rel=0.02)  # texels count by their centers, and borders are a part of them


def test_a_second_bake_takes_the_same_map(settings):
    bpy.ops.paradesc.bake_image()
    before = uvs_of(NAME)
    bpy.ops.paradesc.bake_image()
    assert map_names() == [NAME]
    np.testing.assert_array_equal(uvs_of(NAME), before)


@pytest.mark.parametrize(
    ("kind", "reason"),
    [("squeezed", "has a UV map without area"), ("stacked", "has a UV map with most faces over each other")],
)
def test_a_map_of_no_use_stays_and_the_image_lies_over_another(settings, kind, reason):
    uvs = over_each_other() if kind == "stacked" else np.zeros((len(ball().data.loops), 2))
    add_map("mine", uvs)
    bpy.ops.paradesc.bake_image()
    assert map_names() == ["mine", NAME]
    assert ball().data.uv_layers.active.name == "mine"
    assert ball().data.uv_layers["mine"].active_render
    np.testing.assert_array_equal(uvs_of("mine"), np.asarray(uvs, np.float32))
    made = image_results.found(ball())
    assert made.uv_map == NAME
    assert made.notes == f'New UV map "{NAME}": the mesh {reason}.'
    first = pixels_of(made.images[0])
    bpy.ops.paradesc.bake_image()
    assert map_names() == ["mine", NAME]
    assert image_results.found(ball()).notes == f'Over the UV map "{NAME}": the mesh {reason}.'
    np.testing.assert_array_equal(pixels_of(made.images[0]), first)


def test_mirrored_halves_may_share_a_map(settings):
    half = 0.5 * over_each_other()
    # Each place is shared by two faces.
    count = len(ball().data.polygons)
    side = int(np.ceil(np.sqrt(count / 2)))
    face = np.repeat(np.arange(count) // 2, 4)
    add_map("mine", (half * 2 + np.column_stack([face % side, face // side])) / side)
    bpy.ops.paradesc.bake_image()
    assert map_names() == ["mine"]
    assert image_results.found(ball()).uv_map == "mine"


def test_of_several_maps_the_choice_is_the_users(settings):
    uvs = np.zeros((len(ball().data.loops), 2))
    add_map("one", uvs)
    add_map("other", uvs)
    before = fingerprint(ball())
    with pytest.raises(RuntimeError, match=r'"ball" has a UV map without area; unwrap it \(U in edit mode\)'):
        bpy.ops.paradesc.bake_image()
    assert fingerprint(ball()) == before


def test_a_cancelled_bake_takes_its_map_away(settings, tmp_path):
    before = fingerprint(ball())
    for fraction in (0.0, 0.3, 0.95):
        cancel_at(image_batch.ImageBatch(bpy.context), fraction)
        assert map_names() == []
        assert fingerprint(ball()) == before
    assert pngs_in(tmp_path) == []


def test_a_bake_that_fails_takes_its_map_away(settings, monkeypatch):
    def fails(*_words):
        raise InputError("It is full.")

    monkeypatch.setattr(image_batch, "write_whole", fails)
    with pytest.raises(RuntimeError, match="It is full"):
        bpy.ops.paradesc.bake_image()
    assert map_names() == []


@pytest.mark.parametrize("failing", ["both", "first"])
def test_objects_that_share_a_mesh_keep_the_map_that_one_of_them_needs(settings, monkeypatch, failing):
    low, other = ball(), bpy.data.objects.new("other_low", ball().data)
    low.name = "ball_low"
    bpy.context.collection.objects.link(other)
    highs = [add_sphere(name, uv_map=False) for name in ("ball_high", "other_high")]
    select(*highs, other, low)
    bpy.context.view_layer.update()
    run = image_batch.image_files.run

    def fails(stem, *words, **more):
        if failing == "both" or stem == "ball_low":
            raise InputError("no")
        return run(stem, *words, **more)

    monkeypatch.setattr(image_batch.image_files, "run", fails)
    if failing == "both":
        with pytest.raises(RuntimeError, match="no"):
            bpy.ops.paradesc.bake_onto()
        assert low.data.uv_layers.keys() == []
    else:
        assert bpy.ops.paradesc.bake_onto() == {"FINISHED"}
        assert low.data.uv_layers.keys() == [image_results.found(other).uv_map] == [NAME]


def test_a_mesh_that_cannot_be_read_over_its_new_map_loses_it(settings, monkeypatch):
    def fails(*_words):
        raise InputError("It cannot be read.")

    monkeypatch.setattr(uv_maps.targets, "read", fails)
    with pytest.raises(RuntimeError, match="cannot be read"):
        bpy.ops.paradesc.bake_image()
    assert map_names() == []


def test_a_map_is_made_in_edit_mode_too(settings):
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    assert ball().mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert map_names() == [NAME]


def test_modifiers_that_add_faces_carry_the_map(settings):
    ball().modifiers.new("wide", "SUBSURF").levels = 1
    bpy.context.scene.paradesc_animation.source = "auto"
    bpy.ops.paradesc.bake_image()
    assert map_names() == [NAME]
    # The sphere of the catmull-clark surface has a curvature everywhere, and nearly the same.
    values = pixels_of(bpy.data.images[0])[:, :, 0]
    assert np.ptp(np.percentile(values, (5, 95))) < 0.2


@pytest.mark.parametrize("adds_faces", [False, True])
def test_an_image_lies_over_the_map_as_modifiers_move_it(settings, adds_faces):
    bpy.data.objects.remove(ball())
    target = add_sphere("ball")
    warp = target.modifiers.new("warp", "UV_WARP")
    warp.uv_layer, warp.center, warp.scale = target.data.uv_layers[0].name, (0, 0), (0.5, 0.5)
    if adds_faces:
        target.modifiers.new("triangles", "TRIANGULATE")
    bpy.context.scene.paradesc_animation.source, settings.image_outside = "auto", "transparent"
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    (image,) = bpy.data.images
    covered = pixels_of(image)[::-1, :, 3] > 0
    assert covered[:64, :64].all()
    assert covered.mean() < 0.6, "the map is that before the modifier"  # its gutter is wide in so small an image
