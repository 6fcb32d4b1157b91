"""High to low in Blender: one button for selected objects and for pairs by name, and the command line."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from maps_test import decode16  # noqa: E402

import scene  # noqa: E402
from paradesc.core import transfer  # noqa: E402
from paradesc_blender.bake import image_batch  # noqa: E402
from paradesc_blender.scene import mesh_io, pairs  # noqa: E402
from paradesc_blender.ui import panel  # noqa: E402
from scene import add_sphere, cancel_at, empty_scene, fingerprint, saved_scene, small_bake  # noqa: E402

SIZE = 96


@pytest.fixture
def settings(registered):
    """A coarse and a fine sphere, both selected and the coarse one active, and settings that take a moment."""
    add_sphere("fine", steps=20)
    add_sphere("coarse", steps=4)
    made = small_bake("cpu")
    made.texels = SIZE
    return made


def select(*names):
    """Selects the objects of these names, the last one as the active one."""
    scene.select(*(bpy.data.objects[name] for name in names))


def values_of(content):
    """The values that the pixels of a PNG stand for."""
    pixels, texts = decode16(content)
    low, high = texts["Description"].split("= ")[1].split(" * ")[0].split(" + (")
    top = float(high.split(" - ")[0])
    return float(low) + (top - float(low)) * pixels[:, :, 0] / 65535


def add_monkeys():
    """Blender's monkey, and a subdivided one with waves along its normals: their names."""
    bpy.ops.mesh.primitive_monkey_add()
    low = bpy.context.object
    low.name = "monkey_low"
    high = low.copy()
    high.data, high.name = low.data.copy(), "monkey_high"
    bpy.context.collection.objects.link(high)
    select("monkey_high")
    high.modifiers.new("s", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="s")
    mesh = high.data
    normals = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("normal", normals)
    points = mesh_io.read_positions(mesh)
    points += 0.01 * np.sin(30 * points[:, :1]) * normals.reshape(-1, 3)
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.update()
    return low.name, high.name


def baked():
    """The results of what the button would do, without images."""
    batch = image_batch.ImageBatch(bpy.context, onto=True)
    while not batch.done:
        batch.step(None)
    return [piece.textures.results for piece in batch.written]


# ---- The button


def test_one_click_brings_the_other_selected_mesh_onto_the_active_one(settings, capfd):
    bpy.data.objects["coarse"].data["paradesc"] = {"attributes": []}  # which then says what was made
    before = [fingerprint(bpy.data.objects[name]) for name in ("coarse", "fine")]
    assert bpy.ops.paradesc.bake_onto() == {"FINISHED"}
    assert [fingerprint(bpy.data.objects[name]) for name in ("coarse", "fine")] == before
    (image,) = bpy.data.images
    assert image.name == "coarse_curvature"
    found = values_of(image.packed_file.data)
    np.testing.assert_allclose(found, 0.5, atol=2e-3)
    assert 'Measured on "fine", at most 0.' in capfd.readouterr().out


def test_what_the_button_says_and_whether_it_is_there(settings):
    assert panel.onto_text(pairs.chosen(bpy.context)) == "Bake onto coarse"
    select("coarse")
    assert pairs.chosen(bpy.context) == {}
    assert not bpy.ops.paradesc.bake_onto.poll()
    with pytest.raises(RuntimeError, match="Select the detailed meshes and then the low-poly one"):
        bpy.ops.paradesc.bake_onto()
    select("fine", "coarse")
    bpy.ops.object.mode_set(mode="EDIT")
    assert pairs.chosen(bpy.context) == {}


def test_names_tell_pairs_before_the_selection_does(settings):
    for name in ("a_low", "b_low", "a_high", "a_high_2", "b_high"):
        add_sphere(name, steps=4)

    def chosen():
        found = pairs.chosen(bpy.context)
        return {low.name: sorted(high.name for high in highs) for low, highs in found.items()}

    select("a_low")
    assert chosen() == {"a_low": ["a_high", "a_high_2"]}
    select("b_high", "a_high_2", "coarse")
    assert chosen() == {"a_low": ["a_high", "a_high_2"], "b_low": ["b_high"]}
    assert panel.onto_text(pairs.chosen(bpy.context)) == "Bake onto 2 Meshes"
    select("fine", "coarse")
    assert chosen() == {"coarse": ["fine"]}


def test_several_pairs_have_textures_of_their_own(settings, tmp_path):
    saved_scene(tmp_path / "scene.blend")
    for name, steps in (("a_low", 4), ("b_low", 5), ("a_high", 10), ("b_high", 12)):
        add_sphere(name, steps=steps)
    select("a_high", "b_low")
    assert bpy.ops.paradesc.bake_onto() == {"FINISHED"}
    assert sorted(path.name for path in tmp_path.glob("*.png")) == ["a_low_curvature.png", "b_low_curvature.png"]


def test_a_displaced_monkey_lies_over_the_uv_map_of_the_plain_one(settings):
    low, high = add_monkeys()
    select(high, low)
    settings.radius_percent, settings.texels = 3.0, 128
    (results,) = baked()
    found = results.transfer
    assert found.sources == ["monkey_high"]
    assert found.missed < 0.01 * found.texels
    image = found.images["mean_curvature"][:, :, 0]
    assert np.isfinite(image).sum() > 0.99 * found.texels
    # At vertices the value is that of the nearest place along the normal, which is found by trying all triangles.
    fine, coarse = (mesh_io.read_object(bpy.data.objects[name], False, False) for name in (high, low))
    at_fine = found.measured["mean_curvature"]
    normals = transfer.smooth_normals(coarse.positions.astype(np.float64), coarse.triangle_vertices)
    for vertex in range(0, len(coarse.positions), 25):
        expected = tried_all(fine, at_fine, coarse.positions[vertex].astype(np.float64), normals[vertex], found.cage)
        assert results.values["mean_curvature"][vertex] == pytest.approx(expected, rel=1e-3, abs=1e-3, nan_ok=True)


def tried_all(arrays, values, point, normal, cage):
    """The value where a line meets a mesh nearest to its point, by solving for all triangles at once."""
    normal = normal / np.linalg.norm(normal)
    corners = arrays.positions.astype(np.float64)[arrays.triangle_vertices]
    sides = np.stack(
        [corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], np.broadcast_to(-normal, (len(corners), 3))], 2
    )
    facing = np.cross(sides[:, :, 0], sides[:, :, 1]) @ normal > 0
    u, v, away = np.linalg.solve(sides[facing], (point - corners[facing][:, 0])[:, :, None])[:, :, 0].T
    met = (u >= 0) & (v >= 0) & (u + v <= 1) & (np.abs(away) <= cage)
    if not met.any():
        return np.nan
    best = np.flatnonzero(met)[np.argmin(np.abs(away[met]))]
    at = values[arrays.triangle_vertices[facing][best]].astype(np.float64)
    return at @ [1 - u[best] - v[best], u[best], v[best]]


def test_a_cage_that_is_too_small_is_a_warning_with_numbers_and_a_remedy(settings, capfd):
    settings.cage = 0.02
    assert bpy.ops.paradesc.bake_onto() == {"FINISHED"}
    assert 'texels of "coarse" met nothing within the cage distance 0.02' in capfd.readouterr().out
    assert bpy.ops.paradesc.bake_onto(cage=0.5) == {"FINISHED"}
    assert settings.cage == 0.5
    assert "met nothing" not in capfd.readouterr().out


def test_what_cannot_be_baked_is_one_sentence_and_leaves_no_image(settings):
    bpy.data.objects["fine"].location = (50, 0, 0)
    with pytest.raises(RuntimeError, match=r'No texel of "coarse" meets "fine" within .*raise the cage distance\.'):
        bpy.ops.paradesc.bake_onto()
    assert not bpy.data.images


def test_cancelled_at_any_time_nothing_is_left(settings):
    for fraction in (0.0, 0.3, 0.75):
        cancel_at(image_batch.ImageBatch(bpy.context, onto=True), fraction)
        assert not bpy.data.images


def test_a_detailed_mesh_is_measured_as_it_is_shown(settings):
    shown = bpy.data.objects["fine"]
    shown.data = bpy.data.objects["coarse"].data.copy()
    shown.modifiers.new("s", "SUBSURF").levels = 3
    bpy.context.scene.paradesc_animation.source = "auto"
    (found,) = baked()
    assert len(found.transfer.measured["mean_curvature"]) == 6146
    assert found.transfer.missed == 0


def test_a_detailed_mesh_that_is_disabled_is_not_measured_without_its_modifiers(settings):
    bpy.context.scene.paradesc_animation.source = "auto"
    detailed = bpy.data.objects["fine"]
    detailed.name, bpy.data.objects["coarse"].name = "prop_high", "prop_low"
    detailed.modifiers.new("s", "SUBSURF")
    detailed.hide_viewport = True
    select("prop_low")
    with pytest.raises(RuntimeError, match=r'"prop_high" is disabled in viewports .*; enable it, or choose the source'):
        bpy.ops.paradesc.bake_onto()
    assert not bpy.data.images


# ---- The command line

WORDS = ("--radius", "0.08", "--samples", "32", "--backend", "cpu", "--texels", "48", "--quiet")


@pytest.fixture
def pair(registered, tmp_path):
    """A file with two pairs, and one with the detailed sphere alone."""
    for name, steps in (("a_low", 4), ("a_high", 20), ("b_low", 5), ("b_high", 16)):
        add_sphere(name, steps=steps)
    bpy.data.objects["b_low"].location = bpy.data.objects["b_high"].location = (9, 0, 0)
    both = saved_scene(tmp_path / "both.blend")
    empty_scene()
    made = add_sphere("a_low", steps=20)  # a name that is taken in the other file
    made.parent = bpy.data.objects.new("holder", None)
    bpy.context.collection.objects.link(made.parent)
    alone = saved_scene(tmp_path / "alone.blend")
    return both, alone


def test_two_objects_of_one_file(run, report, pair, tmp_path):
    ended = run("bake", pair[0], *WORDS, "--object", "a_low", "--from", "a_high", "--map", "x.exr", "-o", "x.npz",
        "--json", "report.json")  # fmt: skip
    assert ended.code == 0, ended.error
    (row,) = report()["objects"]
    assert row["object"] == "a_low"
    assert row["transfer"]["sources"] == ["a_high"]
    assert row["transfer"]["missed"] == 0 < row["transfer"]["texels"]
    with np.load(tmp_path / "x.npz") as arrays:
        np.testing.assert_allclose(arrays["mean_curvature"], 0.5, atol=2e-3)
        assert len(arrays["mean_curvature"]) == len(arrays["vertices"]) == 98
    assert (tmp_path / "x.exr").is_file()


def test_two_objects_of_two_files_and_the_output_has_only_one(run, report, pair, tmp_path):
    both, alone = pair
    words = (*WORDS, "--object", "a_low", "--from-file", alone, "-o", "out.blend", "--json", "report.json")
    for more in ((), ("--from", "a_low")):
        assert run("bake", both, *words, *more).code == 0
        assert report()["objects"][0]["transfer"]["sources"] == ["a_low.001"]
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert sorted(item.name for item in bpy.data.objects) == ["a_high", "a_low", "b_high", "b_low"]
    assert "mean_curvature" in bpy.data.objects["a_low"].data.attributes
    assert "mean_curvature" not in bpy.data.objects["a_high"].data.attributes


def test_other_files_are_imported_beside_what_is_open(run, report, pair, sphere_obj):
    words = ("bake", pair[0], *WORDS, "--object", "a_low", "--from-file", sphere_obj, "--json", "report.json")
    assert run(*words).code == 0
    assert report()["objects"][0]["transfer"]["sources"] == ["sphere"]


def test_pairs_are_found_by_their_names(run, report, pair, tmp_path):
    assert run("bake", pair[0], *WORDS, "--pairs", "--map", "x.png", "--json", "report.json").code == 0
    rows = {row["object"]: row["transfer"]["sources"] for row in report()["objects"]}
    assert rows == {"a_low": ["a_high"], "b_low": ["b_high"]}
    assert sorted(path.name for path in tmp_path.glob("*.png")) == ["x_a_low.png", "x_b_low.png"]
    assert run("bake", pair[0], *WORDS, "--pairs", "-o", "x.ply").code == 0
    assert b"element vertex 250\n" in (tmp_path / "x.ply").read_bytes()[:500]


def test_pairs_of_two_files_are_found_by_their_names_too(run, report, pair):
    both, alone = pair
    words = ("--pairs", "--object", "b_low", "--json", "report.json")
    assert run("bake", alone, *WORDS, "--pairs", "--from-file", both, "--json", "report.json").code == 0
    (row,) = report()["objects"]
    assert (row["object"], row["transfer"]["sources"]) == ("a_low", ["a_high"])
    ended = run("bake", both, *WORDS, *words, "--from-file", alone)
    assert ended.code == 3
    assert 'No mesh object is named as "b_low" with _high' in ended.error


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--cage", "1"), 2, "give --from, --from-file or --pairs"),
        (("--from", "a_high", "--cage", "-1"), 2, "The cage distance is -1"),
        (("--from", "a_high", "--pairs"), 2, "not both"),
        (("--from", "a_high", "--all"), 2, "instead of --all"),
        (("--from", "a_high", "--object", "a_low", "--object", "b_low"), 2, "--pairs"),
        (("--from", "a_high", "--corners", "c.json"), 2, "--corners is about the mesh that is measured"),
        (("--from", "a_high", "--material-maps"), 2, "Maps belong to the mesh that is measured"),
        (("--from", "a_hig", "--object", "a_low"), 3, 'There is no object "a_hig"; mesh objects: "a_low", "a_high"'),
        (("--from", "nobody", "--object", "a_low"), 3, 'There is no object "nobody"'),
        (("--from", "a_low", "--object", "a_low"), 2, "cannot be detailed and low-poly at once"),
        (("--from-file", "missing.obj", "--object", "a_low"), 3, 'There is no file "missing.obj"'),
        (("--from-file", "a.off", "--object", "a_low"), 3, 'Blender does not open "a.off"; save it as .ply, or give'),
        (("--from-file", "a.txt", "--object", "a_low"), 3, '"a.txt" is none of .blend, .obj, '),
        (("--pairs", "--object", "a_high"), 3, 'named as "a_high" with _high in place of _low'),
        (("--from", "b_high", "--object", "a_low"), 2, 'No texel of "a_low" meets "b_high"'),
    ],
    ids=str,
)
def test_what_makes_no_sense_is_one_sentence(run, pair, words, code, said):
    ended = run("bake", pair[0], *WORDS, *words, "--map", "x.exr")
    assert ended.code == code
    assert said in ended.error
    assert len(ended.error.strip().splitlines()) == 1
