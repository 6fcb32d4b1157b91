"""The first things an artist meets: grey masks of the shown surface, a fitted radius, notes apart from warnings."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")
import bmesh  # noqa: E402

from paradesc.core import fitting, job, source_kinds  # noqa: E402
from paradesc_blender.animation import sessions  # noqa: E402
from paradesc_blender.scene import record, targets  # noqa: E402
from paradesc_blender.settings import presets  # noqa: E402
from paradesc_blender.ui import panel, report_panel, result  # noqa: E402
from scene import add_sphere, attribute_values, saved_scene, select  # noqa: E402


@pytest.fixture(autouse=True)
def new_scene(registered):
    """A scene as an artist finds it."""
    scene = bpy.context.scene
    scene.paradesc.property_unset("descriptors")
    scene.paradesc_animation.property_unset("source")


@pytest.fixture
def monkey():
    """A monkey with Subdivision, as an artist would have it."""
    bpy.ops.mesh.primitive_monkey_add()
    target = bpy.context.active_object
    target.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.context.view_layer.update()
    return target


def arrays_of(target, source):
    return targets.read(target, job.Settings(), targets.ReadRequest(source=source)).arrays


def test_one_click_bakes_both_grey_masks_of_the_surface_that_is_shown(monkey):
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    mesh = monkey.data
    assert {"cavity_color", "convexity_color"} <= {item.name for item in mesh.color_attributes}
    colors = attribute_values(mesh, "cavity_color")
    np.testing.assert_allclose(colors[:, :2], colors[:, 1:3], atol=1e-5)
    assert np.ptp(colors[:, 0]) > 0.3
    found = attribute_values(mesh, "cavity").copy()
    bpy.context.scene.paradesc_animation.source = "evaluated"
    bpy.ops.paradesc.bake()
    np.testing.assert_array_equal(attribute_values(mesh, "cavity"), found)
    bpy.context.scene.paradesc_animation.source = "original"
    bpy.ops.paradesc.bake()
    assert not np.array_equal(attribute_values(mesh, "cavity"), found)


def test_what_is_measured_is_a_note_and_no_warning(monkey):
    bpy.ops.paradesc.bake()
    stored = record.read(monkey.data)
    assert "Measured with its modifiers: 7,958 vertices" in stored["notes"]
    assert stored["warnings"] == ""
    assert re.fullmatch(r"Cavity, Edge Wear · \d+\.\d+ s", result.result_sentence(stored))
    assert report_panel.stored_report(monkey) == stored


@pytest.mark.parametrize("state", ["plain", "hidden", "shown", "key", "muted", "active key", "absolute key", "basis"])
def test_as_shown_takes_modifiers_and_shape_keys_only_where_they_show(state):
    target = add_sphere()
    shape = "basis"
    if state in ("hidden", "shown"):
        target.modifiers.new("Cast", "CAST").show_viewport = state == "shown"
    if "key" in state or state in ("muted", "basis"):
        target.shape_key_add(name="Basis")
        key = target.shape_key_add(name="Key", from_mix=False)
        key.value, key.mute = 1.0, state == "muted"
        if state in ("absolute key", "basis"):
            target.data.shape_keys.use_relative = False
            key.value = float(state == "basis")  # which absolute keys ignore
            target.data.shape_keys.eval_time = key.frame if state == "absolute key" else 0
        shape = "active" if state == "active key" else "basis"
    bpy.context.view_layer.update()
    shows = state in ("shown", "key", "absolute key")
    assert targets.shown_source(target, shape) == ("evaluated" if shows else "original")


def test_in_edit_mode_the_edited_mesh_is_measured_and_a_note_says_so(monkey):
    bpy.ops.object.mode_set(mode="EDIT")
    read = targets.read(monkey, job.Settings(), targets.ReadRequest(source="auto"))
    assert len(read.arrays.positions) == len(monkey.data.vertices)
    assert "without its modifiers" in read.notes[0]


def test_the_same_command_line_as_before_measures_the_base_mesh(monkey):
    assert targets.ReadRequest().source == "original"
    assert len(arrays_of(monkey, "original").positions) < len(arrays_of(monkey, "auto").positions)
    assert "auto" not in source_kinds.NAMES


@pytest.mark.parametrize("name", ["cavity", "convexity", "ambient_openness", "mean_curvature"])
def test_masks_are_grey_and_values_with_a_sign_have_two_colors(name):
    add_sphere()
    bpy.context.scene.paradesc.descriptors = {name}
    bpy.ops.paradesc.bake()
    drawn = record.read(bpy.context.active_object.data)["drawn"][name]["map"]
    assert drawn == ("auto" if name == "mean_curvature" else "grey")


def test_each_mask_of_the_panel_is_a_preset_that_it_recognizes():
    group = bpy.context.scene.paradesc
    assert presets.masks_of(group.descriptors) == ["cavity", "edge_wear"]  # of a new scene
    for name in presets.MASKS:
        bpy.ops.paradesc.preset(name=name)
        assert presets.masks_of(group.descriptors) == [name]
    group.descriptors = {"cavity", "shape_index"}
    assert presets.masks_of(group.descriptors) == []


def test_shift_bakes_several_masks_and_one_stays():
    group = bpy.context.scene.paradesc
    for extend, name, expected in (
        (False, "openness", ["openness"]),
        (True, "cavity", ["cavity", "openness"]),
        (True, "openness", ["cavity"]),
        (True, "cavity", ["cavity"]),
    ):
        bpy.ops.paradesc.mask(name=name, extend=extend)
        assert presets.masks_of(group.descriptors) == expected


def test_the_operator_takes_a_mask_and_a_radius_of_its_own():
    target = add_sphere()
    assert bpy.ops.paradesc.bake(mask="edge_wear", radius=7.5) == {"FINISHED"}
    settings = record.read(target.data)["settings"]
    assert settings["descriptors"] == ["convexity"]
    assert settings["radius"] == pytest.approx(0.075)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}  # neither stays for the next time
    assert record.read(target.data)["settings"]["radius"] == pytest.approx(0.075)  # but in the panel


@pytest.mark.parametrize(("name", "factor"), [("cavity", 1.0), ("convexity", 1.0), ("ambient_openness", 4.0)])
@pytest.mark.parametrize(("size", "size_factor"), [("medium", 1.0), ("broad", 2.5)])
def test_the_radius_of_masks_fits_the_mesh_by_itself(name, factor, size, size_factor):
    target = add_sphere(steps=60)
    group = bpy.context.scene.paradesc
    group.descriptors, group.radius_fit = {name}, size
    bpy.ops.paradesc.bake()
    stored = record.read(target.data)
    edges = stored["mesh_report"]["mean_edge"] / stored["mesh_report"]["diagonal"]
    found = stored["field_report"]["radius"] / stored["mesh_report"]["diagonal"]
    assert found == pytest.approx(1.5 * edges * factor * size_factor, rel=0.01)  # three digits are kept
    assert group.radius_percent == pytest.approx(100 * found, rel=1e-5)  # which the panel shows
    assert group.radius_fit == size  # and the next mesh gets its own


@pytest.mark.parametrize("steps", [1, 4])
def test_coarse_meshes_have_a_radius_of_four_percent_at_most_and_no_warning(steps):
    target = add_sphere(steps=steps)
    bpy.ops.paradesc.bake()
    stored = record.read(target.data)
    edge = 100 * stored["mesh_report"]["mean_edge"] / stored["mesh_report"]["diagonal"]
    assert stored["settings"]["radius"] == pytest.approx(0.01 * min(1.5 * edge, 4.0), rel=0.01)
    assert stored["warnings"] == ""


def test_a_mask_that_is_black_nearly_everywhere_gives_way_to_the_other():
    target = add_sphere(steps=8)  # it has no cavity, and its ends are edges as soon as they are pointed
    for vertex in target.data.vertices:
        vertex.co.z *= 3
    bpy.ops.paradesc.bake()
    assert target.data.color_attributes.active_color.name == "convexity_color"
    target.data.flip_normals()
    bpy.ops.paradesc.bake()
    assert target.data.color_attributes.active_color.name == "cavity_color"


def rods(count=8, thickness=0.04):
    """Thin upright rods on which every place is near an edge."""
    bm = bmesh.new()
    for index in range(count):
        made = bmesh.ops.create_cube(bm, size=1.0)["verts"]
        bmesh.ops.scale(bm, vec=(thickness, thickness, 1.0), verts=made)
        bmesh.ops.translate(bm, vec=(index / count, 0, 0), verts=made)
    bmesh.ops.subdivide_edges(bm, edges=bm.edges[:], cuts=12, use_grid_fill=True)
    mesh = bpy.data.meshes.new("rods")
    bm.to_mesh(mesh)
    target = bpy.data.objects.new("rods", mesh)
    bpy.context.collection.objects.link(target)
    select(target)
    return target


def test_the_radius_is_halved_where_parts_are_thinner(monkeypatch):
    target = rods()
    bpy.ops.paradesc.bake()
    found = record.read(target.data)["settings"]["radius"]
    monkeypatch.setattr(fitting, "HALVINGS", 0)
    bpy.ops.paradesc.bake()
    whole = record.read(target.data)["settings"]["radius"]
    assert whole / found in (2, 4, 8)


def test_values_that_are_no_masks_have_the_usual_radius():
    target = add_sphere(steps=60)
    bpy.context.scene.paradesc.descriptors = {"mean_curvature", "cavity"}
    bpy.ops.paradesc.bake()
    assert record.read(target.data)["settings"]["radius"] == pytest.approx(0.02)


@pytest.mark.parametrize("member", ["radius_percent", "radius_absolute", "radius_edges"])
def test_a_radius_that_is_typed_stays(member):
    target = add_sphere(steps=8)
    group = bpy.context.scene.paradesc
    group.radius_unit = {"radius_percent": "diagonal", "radius_absolute": "absolute"}.get(member, "mean-edge")
    assert group.radius_fit == "medium"
    setattr(group, member, 3.0)
    assert group.radius_fit == "typed"
    for mask in presets.MASKS:
        bpy.ops.paradesc.mask(name=mask)
        bpy.ops.paradesc.bake()
        radius = record.read(target.data)["settings"]["radius"]
        assert radius == pytest.approx(0.03 if member == "radius_percent" else 3.0)
    bpy.ops.paradesc.fit_radius()
    assert group.radius_fit == "medium"


def test_a_typed_radius_below_the_edges_gets_a_button_below_its_warning():
    add_sphere(steps=2)
    bpy.context.scene.paradesc.radius_percent = 2.0
    bpy.ops.paradesc.bake()
    stored = record.read(bpy.context.active_object.data)
    assert "values show single faces" in stored["warnings"]
    assert stored["field_report"]["radius"] < stored["mesh_report"]["mean_edge"]  # which the panel looks at
    bpy.ops.paradesc.fit_radius()
    bpy.ops.paradesc.bake()
    assert record.read(bpy.context.active_object.data)["warnings"] == ""


def test_a_mesh_without_faces_has_no_radius_and_one_sentence():
    bpy.context.collection.objects.link(made := bpy.data.objects.new("empty", bpy.data.meshes.new("empty")))
    bpy.context.view_layer.objects.active = made
    with pytest.raises(RuntimeError, match="no faces"):
        bpy.ops.paradesc.fit_radius()


def drawn_lines(target):
    """The lines of the panel about live values."""
    lines = []
    layout = SimpleNamespace(column=lambda **_: layout, label=lambda text, **_: lines.append(text))
    widget = SimpleNamespace(widget=SimpleNamespace(points=11))
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0), ui_styles=[widget])
    place = {"active_object": target, "selected_objects": [target]}
    panel.draw_live(SimpleNamespace(**place, region=SimpleNamespace(width=400), preferences=preferences), layout)
    return lines


def test_the_switch_beside_the_button_is_live_mode():
    target = add_sphere()
    live = target.paradesc_live
    live.follows = True
    assert live.mode == "LIVE"
    seconds = sessions.session_at(target).seconds
    lines = drawn_lines(target)
    assert lines == [f"Live: {1e3 * sum(seconds.values()):.0f} ms a frame"]
    live.follows = False
    assert live.mode == "OFF"
    live.mode = "CACHE"
    assert not live.follows


# ---- Files that Blender saves by itself


def used(scene):
    scene.paradesc.samples = 64


def looked_at(scene):
    assert scene.paradesc.samples > 0


@pytest.mark.parametrize("before", [used, looked_at])
def test_a_recovered_file_keeps_the_defaults_of_today(before, tmp_path):
    before(bpy.context.scene)
    bpy.app.handlers.save_pre.clear()  # Blender saves for recovery without calling any
    path = saved_scene(tmp_path / "recovered.blend")
    bpy.ops.wm.open_mainfile(filepath=str(path))
    scene = bpy.context.scene
    assert (scene.paradesc.descriptors, scene.paradesc.texels) == ({"cavity", "convexity"}, 1024)
    assert scene.paradesc_animation.source == "auto"


def test_a_new_file_keeps_its_own(tmp_path):
    bpy.context.scene.paradesc.samples = 64
    bpy.ops.wm.open_mainfile(filepath=str(saved_scene(tmp_path / "new.blend")))
    scene = bpy.context.scene
    assert (scene.paradesc.samples, scene.paradesc.descriptors) == (64, {"cavity", "convexity"})
    assert scene.paradesc_animation.source == "auto"


def test_a_typed_radius_stays_when_the_bake_is_redone_with_something_else_changed(monkey):
    settings = bpy.context.scene.paradesc
    assert settings.radius_percent != pytest.approx(5)
    # Redo takes the bake back, so the scene has the radius of before, and the operator what it showed.
    assert bpy.ops.paradesc.bake(fit="typed", radius=5, shown_radius=5, invert=True) == {"FINISHED"}
    assert (settings.radius_fit, settings.radius_percent) == ("typed", pytest.approx(5))


def test_a_fitted_radius_that_is_shown_is_fitted_again_when_the_bake_is_redone(monkey):
    settings = bpy.context.scene.paradesc
    assert bpy.ops.paradesc.bake(fit="broad", radius=5, shown_radius=5, invert=True) == {"FINISHED"}
    assert settings.radius_fit == "broad"


@pytest.mark.parametrize("operator", ["bake", "bake_image"])
def test_a_position_that_is_no_number_is_named(monkey, operator):
    monkey.modifiers.clear()
    monkey.data.vertices[7].co.z = np.nan
    with pytest.raises(RuntimeError, match="The z of vertex 7 is nan"):
        getattr(bpy.ops.paradesc, operator)()
