"""The record of Bake to Image for the panel: the images that were made, what shows them, and when it is forgotten."""

from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from image_operator_test import folder, pngs_in, settings  # noqa: E402, F401
from mathutils import Matrix  # noqa: E402
from panel_test import drawn_by  # noqa: E402
from udim_operator_test import SIX, in_tiles  # noqa: E402

from paradesc_blender.bake import image_viewing  # noqa: E402
from paradesc_blender.scene import image_preview, image_results, record  # noqa: E402
from paradesc_blender.ui import image_result, panel, result  # noqa: E402
from scene import add_sphere, saved_scene  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def ball():
    return bpy.data.objects["ball"]


def baked():
    bpy.ops.paradesc.bake_image()
    return image_results.found(ball())


def test_a_mesh_knows_what_was_made_of_it_also_after_saving(folder, tmp_path):  # noqa: F811
    made = baked()
    assert (made.names, made.size, made.uv_map, made.cage) == (["ball_curvature.png"], 96, "UVMap", 0.0)
    assert image_result.result_sentence(made) == f"ball_curvature.png, 96², {made.seconds:.1f} s"
    assert 0 < made.seconds < 600  # that of the clock, in whose unit it is said
    saved_scene(tmp_path / "later.blend")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "later.blend"))
    assert image_results.found(ball()) == made


def test_it_is_forgotten_when_the_image_is_gone(folder):  # noqa: F811
    made = baked()
    bpy.data.images.remove(made.images[0])
    assert image_results.found(ball()) is None
    assert not bpy.ops.paradesc.show_image.poll()


def test_several_images_are_counted_and_those_that_are_left_named(folder, settings):  # noqa: F811
    settings.descriptors = {"cavity", "convexity"}
    made = baked()
    assert image_result.result_sentence(made).startswith("2 images, 96², ")
    bpy.data.images.remove(bpy.data.images["ball_cavity.png"])
    assert image_result.result_sentence(image_results.found(ball())).startswith("ball_edges.png, 96², ")


def test_images_are_named_by_what_they_hold_and_the_telling_one_is_shown(folder, settings, monkeypatch):  # noqa: F811
    settings.descriptors = {"cavity", "convexity"}  # a sphere has no cavity
    seen = []
    monkeypatch.setattr(image_preview, "reveal", lambda _target, image, *_words: seen.append(image.name))
    made = baked()
    assert [made.label(image) for image in made.images] == ["Cavity", "Edge Wear"]
    assert seen == ["ball_edges.png"]


def drawn_lines():
    shown = drawn_by(panel.PARADESC_PT_bake)
    return " ".join(shown["label"]), shown["operator"]


def test_an_image_that_is_white_has_buttons_for_other_radii(folder, settings):  # noqa: F811
    looks = bpy.context.scene.paradesc_looks
    settings.descriptors, settings.radius_percent = {"convexity"}, 4.0
    looks.span, looks.minimum, looks.maximum = "fixed", 0.0, 0.01  # all of a sphere is above
    made = baked()
    assert made.extremes(made.images[0])["bright"] == 1.0
    assert made.percent == pytest.approx(4.0, rel=1e-5)
    said, buttons = drawn_lines()
    assert "Most of it is white" in said
    assert {"Finer", "Broader"} <= set(buttons)
    fit, radius = result.next_radius(settings.radius_fit, made.percent, 1)
    bpy.ops.paradesc.bake_image(mask="edge_wear", fit=fit, radius=radius)  # what Broader does
    assert image_results.found(ball()).percent == pytest.approx(8.0, rel=1e-5)


@pytest.mark.parametrize("invert", [False, True])
def test_an_image_without_hollows_says_nothing(folder, settings, invert):  # noqa: F811
    settings.descriptors, bpy.context.scene.paradesc_looks.invert = {"cavity"}, invert  # a sphere has none
    made = baked()
    assert max(made.extremes(made.images[0]).values()) == 1.0
    assert "Most of it" not in drawn_lines()[0]


def test_an_image_that_tells_something_and_one_of_no_mask_say_nothing(folder, settings):  # noqa: F811
    settings.descriptors = {"convexity"}
    made = baked()
    assert {*made.extremes(made.images[0])} == {"dark", "bright"}
    assert "Most of it" not in drawn_lines()[0]
    settings.descriptors = {"mean_curvature"}
    made = baked()
    assert made.extremes(made.images[0]) == {}


def test_the_record_of_an_earlier_version_has_no_extremes(folder):  # noqa: F811
    baked()
    stored = ball().data[record.PROPERTY][image_results.MEMBER]
    for name in ("percent", "drawn"):
        del stored[name]
    made = image_results.found(ball())
    assert (made.percent, made.drawn) == (0.0, {})
    assert "Most of it" not in drawn_lines()[0]


def test_a_packed_image_is_named_by_all_that_it_holds(folder, settings):  # noqa: F811
    settings.image_packed = True
    made = baked()
    assert made.label(made.images[0]) == "Cavity, Edge Wear, Openness"


def test_a_bake_of_vertices_and_one_to_images_keep_what_the_other_left(folder):  # noqa: F811
    made = baked()
    bpy.ops.paradesc.bake()
    assert image_results.found(ball()) == made
    assert baked().names == made.names
    assert "mean_curvature" in ball().data["paradesc"]["attributes"]


def test_a_texture_is_shown_and_hidden_and_nothing_of_the_file_changes(folder):  # noqa: F811
    baked()
    ball().data.materials.append(bpy.data.materials.new("mine"))
    before = len(bpy.data.materials), list(ball().data.attributes.keys())
    assert image_preview.shown(ball()) == ""  # nobody looks in background mode
    assert bpy.ops.paradesc.show_image() == {"FINISHED"}
    assert image_preview.shown(ball()) == "ball_curvature.png"
    assert before == (len(bpy.data.materials), list(ball().data.attributes.keys()))
    assert bpy.ops.paradesc.show_image() == {"FINISHED"}
    assert image_preview.shown(ball()) == ""


def test_a_texture_is_not_shown_on_a_new_object_with_an_old_name(folder):  # noqa: F811
    baked()
    bpy.ops.paradesc.show_image()
    old, mesh = ball(), ball().data
    image_name = image_preview.shown(old)
    bpy.data.objects.remove(old)
    new = add_sphere("ball")  # whose mesh cannot have the name of the old one, which is kept until the file is saved
    assert new.name == "ball"
    assert image_preview.shown(new) == ""
    bpy.data.objects.remove(new)
    back = bpy.data.objects.new("ball", mesh)  # as an undo brings it
    assert image_preview.shown(back) == image_name


def test_a_texture_that_has_become_one_of_tiles_is_not_drawn_as_one_image(folder):  # noqa: F811
    made = baked()
    bpy.ops.paradesc.show_image()
    made.images[0].source = "TILED"
    assert image_preview.shown(ball()) == ""


def test_what_is_drawn_lies_where_the_mesh_as_it_is_shown_has_it(folder):  # noqa: F811
    modifier = ball().modifiers.new("wide", "SUBSURF")
    modifier.levels = 1
    mesh = ball().evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points, places = image_preview.triangles_of(mesh, "UVMap")
    assert len(points) == len(places) == 3 * 2 * len(mesh.polygons)
    assert points.min() == min(min(vertex.co) for vertex in mesh.vertices)
    corner = next(corner for corner in mesh.loops if corner.index == 7)
    along = np.linalg.norm(places - np.array(mesh.uv_layers["UVMap"].data[7].uv), axis=1)
    np.testing.assert_allclose(points[np.argmin(along)], mesh.vertices[corner.vertex_index].co, atol=1e-6)
    assert image_preview.triangles_of(mesh, "no such map")[0].shape == (0, 3)


@pytest.mark.parametrize("scale", [(-2, 1, 1), (1, 1, -2), (-2, -1, -1)])
def test_a_texture_is_drawn_nearer_to_the_eye_on_mirrored_objects_too(scale):
    matrix = Matrix.LocRotScale((1, 2, 3), None, scale)
    assert image_preview.largest_scale(matrix) == pytest.approx(2, rel=1e-6)  # of 32-bit floats


def test_tiles_are_not_shown_and_one_sentence_says_so(folder):  # noqa: F811
    in_tiles(ball())
    made = baked()
    assert made.names == ["ball_curvature.<UDIM>.png"]
    with pytest.raises(RuntimeError, match="Viewports show no tiles"):
        bpy.ops.paradesc.show_image()


def test_tiles_have_no_button_to_show_them(folder):  # noqa: F811
    in_tiles(ball())
    baked()
    buttons = drawn_by(panel.PARADESC_PT_bake)["operator"]
    assert "Show on Mesh" not in buttons
    assert {"Open", "Folder"} <= set(buttons)


def test_packed_images_are_saved_as_the_bake_made_them(settings, tmp_path):  # noqa: F811
    made = baked()
    assert bpy.ops.paradesc.save_images(directory=str(tmp_path)) == {"FINISHED"}
    assert pngs_in(tmp_path) == ["ball_curvature.png"]
    assert (tmp_path / "ball_curvature.png").read_bytes() == made.images[0].packed_file.data
    (tmp_path / "ball_curvature.png").write_bytes(b"mine")
    with pytest.raises(RuntimeError, match="it exists already"):
        bpy.ops.paradesc.save_images(directory=str(tmp_path))
    assert (tmp_path / "ball_curvature.png").read_bytes() == b"mine"


def test_without_a_folder_packed_images_go_beside_the_blend_never_where_blender_was_started(
    settings,  # noqa: F811
    tmp_path,
    monkeypatch,
):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    baked()
    for words in ({}, {"directory": "//below"}):
        with pytest.raises(RuntimeError, match=r"Save the [.]blend first"):
            bpy.ops.paradesc.save_images(**words)
    saved_scene(tmp_path / "scene.blend")
    assert bpy.ops.paradesc.save_images() == {"FINISHED"}
    assert (tmp_path / "ball_curvature.png").is_file()
    assert pngs_in(tmp_path / "elsewhere") == []


def test_there_is_nothing_to_save_of_images_that_are_files(folder):  # noqa: F811
    baked()
    with pytest.raises(RuntimeError, match="its images are files"):
        bpy.ops.paradesc.save_images(directory=str(folder))


def test_packed_tiles_are_saved_one_by_one(settings, tmp_path):  # noqa: F811
    in_tiles(ball())
    baked()
    bpy.ops.paradesc.save_images(directory=str(tmp_path))
    assert pngs_in(tmp_path) == [f"ball_curvature.{tile}.png" for tile in SIX]


def test_packing_says_nothing_on_the_console(settings, capfd):  # noqa: F811
    baked()
    baked()
    found = capfd.readouterr()
    assert "not available" not in found.out + found.err


def test_the_folder_is_that_of_the_file(folder, monkeypatch):  # noqa: F811
    baked()
    asked = []
    monkeypatch.setattr(image_viewing, "open_folder", lambda path: asked.append(path))
    assert bpy.ops.paradesc.open_image_folder() == {"FINISHED"}
    assert asked == [Path(folder)]


def test_a_mesh_without_images_has_no_line_and_grey_buttons():
    add_sphere("ball")
    assert image_results.found(ball()) is None
    assert image_results.found(None) is None
    for name in ("show_image", "open_image", "open_image_folder", "save_images"):
        assert not getattr(bpy.ops.paradesc, name).poll()


def test_the_line_has_its_buttons_and_says_what_happened_to_the_map(settings):  # noqa: F811
    ball().data.uv_layers.remove(ball().data.uv_layers[0])
    made = baked()
    found = drawn_by(panel.PARADESC_PT_bake)
    assert {"Show on Mesh", "Open", "Save"} <= set(found["operator"])
    said = " ".join(found["label"])
    assert f"ball_curvature, 96², {made.seconds:.1f} s" in said
    assert made.notes in said
