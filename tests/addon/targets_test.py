"""Which meshes a bake takes, in which mode and shape, and what it refuses, inside Blender without a window."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import bmesh  # noqa: E402

from paradesc.bridge import InputError  # noqa: E402
from paradesc_blender.scene import mesh_io, record, targets  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene, small_bake  # noqa: E402

MODES = ["EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"]


@pytest.fixture(autouse=True)
def small(registered):
    small_bake()


def add_spheres(*names):
    """Spheres side by side, all selected, the last one active."""
    made = [add_sphere(name) for name in names]
    for index, item in enumerate(made):
        item.location.x = 5.0 * index
    return made


def mean_curvature(target):
    return attribute_values(target.data, "mean_curvature")


def state():
    """The modes and the selection that a person sees."""
    objects = bpy.context.view_layer.objects
    return objects.active.name, [(item.name, item.mode, item.select_get()) for item in objects]


# ---- Which ones


def test_selected_meshes_are_chosen_the_active_one_first():
    first, second, third = add_spheres("first", "second", "third")
    third.select_set(False)
    bpy.context.view_layer.objects.active = second
    assert targets.chosen(bpy.context) == [second, first]


def test_a_script_may_name_the_objects():
    first, second = add_spheres("first", "second")
    with bpy.context.temp_override(active_object=first, object=first, selected_objects=[first]):
        assert targets.chosen(bpy.context) == [first]
        assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert ["mean_curvature" in item.data.attributes for item in (first, second)] == [True, False]


def test_without_a_selection_the_active_mesh_is_chosen():
    first, second = add_spheres("first", "second")
    first.select_set(False)
    second.select_set(False)
    assert targets.chosen(bpy.context) == [second]


def test_what_is_no_mesh_is_left_out():
    (ball,) = add_spheres("ball")
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "POINT"))
    bpy.context.collection.objects.link(lamp)
    lamp.select_set(True)
    bpy.context.view_layer.objects.active = lamp
    assert targets.chosen(bpy.context) == [ball]
    ball.select_set(False)
    assert targets.obstacle(bpy.context) == "Select a mesh object first"


# ---- Modes


@pytest.mark.parametrize("mode", MODES)
def test_mode_selection_and_active_object_are_as_before(mode):
    first, second, _ = add_spheres("first", "second", "third")
    second.select_set(False)
    bpy.context.view_layer.objects.active = first
    bpy.ops.object.mode_set(mode=mode)
    before = state()
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert state() == before
    bpy.ops.object.mode_set(mode="OBJECT")
    np.testing.assert_allclose(mean_curvature(first), 0.5, rtol=0.1)
    assert "mean_curvature" not in second.data.attributes


def refusing(*_words):
    raise InputError("No room.")


@pytest.mark.parametrize("mode", MODES)
def test_mode_is_as_before_after_an_error_too(mode, monkeypatch):
    add_spheres("ball")
    monkeypatch.setattr(mesh_io, "places", refusing)
    bpy.ops.object.mode_set(mode=mode)
    before = state()
    with pytest.raises(RuntimeError, match="No room"):
        bpy.ops.paradesc.bake()
    assert state() == before


def test_several_meshes_in_edit_mode_are_all_baked_and_stay_there():
    first, second, third = add_spheres("first", "second", "third")
    third.select_set(False)
    bpy.context.view_layer.objects.active = first
    bpy.ops.object.mode_set(mode="EDIT")
    second.select_set(False)  # in edit mode all the same
    before = state()
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert state() == before
    bpy.ops.object.mode_set(mode="OBJECT")
    assert ["mean_curvature" in item.data.attributes for item in (first, second, third)] == [True, True, False]


def test_selected_vertices_of_edit_mode_stay_selected():
    (ball,) = add_spheres("ball")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    edited = bmesh.from_edit_mesh(ball.data)
    edited.verts.ensure_lookup_table()
    edited.verts[7].select_set(True)
    bmesh.update_edit_mesh(ball.data)
    bpy.ops.paradesc.bake()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert [vertex.index for vertex in ball.data.vertices if vertex.select] == [7]


@pytest.mark.parametrize("value", [0.0, 1.0])
@pytest.mark.parametrize("mode", ["EDIT", "SCULPT"])
def test_the_shape_key_that_is_edited_is_measured(mode, value):
    (ball,) = add_spheres("ball")
    bpy.context.scene.paradesc_animation.source = "auto"
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Half")
    key.value = value
    key.data.foreach_set("co", (0.5 * mesh_io.read_positions(ball.data)).ravel())
    ball.active_shape_key_index = 1
    bpy.ops.object.mode_set(mode=mode)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    np.testing.assert_allclose(mean_curvature(ball), 1.0, rtol=0.1)
    assert record.read(ball.data)["notes"] == 'The shape key "Half" was measured, at its full value.'


def test_sculpt_mode_gives_the_mesh_as_sculpted_so_far():
    (ball,) = add_spheres("ball")
    bpy.ops.object.mode_set(mode="SCULPT")
    positions = mesh_io.read_positions(ball.data)
    ball.data.vertices.foreach_set("co", (0.5 * positions).ravel())
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    np.testing.assert_allclose(mean_curvature(ball), 1.0, rtol=0.1)
    assert np.array_equal(mesh_io.read_positions(ball.data), 0.5 * positions)


def test_dynamic_topology_is_refused_by_a_sentence():
    (ball,) = add_spheres("ball")
    bpy.ops.object.mode_set(mode="SCULPT")
    bpy.ops.sculpt.dynamic_topology_toggle()
    assert ball.use_dynamic_topology_sculpting
    assert targets.obstacle(bpy.context).startswith("Turn off Dyntopo")
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.bake()
    bpy.ops.sculpt.dynamic_topology_toggle()
    assert targets.obstacle(bpy.context) == ""


@pytest.mark.parametrize("mode", ["POSE", "EDIT"])
def test_modes_of_other_objects_have_to_be_left(mode):
    add_spheres("ball")
    bpy.ops.object.armature_add()
    bpy.ops.object.mode_set(mode=mode)
    assert targets.obstacle(bpy.context) == f"Leave {mode.lower()} mode first"


# ---- Shapes


def add_keys(target):
    """A key "small" of half the size, and one that is shown."""
    target.shape_key_add(name="Basis")
    small, shown = target.shape_key_add(name="small"), target.shape_key_add(name="shown")
    positions = mesh_io.read_positions(target.data)
    small.data.foreach_set("co", (0.5 * positions).ravel())
    shown.data.foreach_set("co", (2.0 * positions).ravel())
    shown.value = 1.0
    target.active_shape_key_index = 1
    return small


def test_of_shape_keys_the_basis_is_measured_and_another_one_shown_is_said():
    (ball,) = add_spheres("ball")
    add_keys(ball)
    bpy.ops.paradesc.bake()
    np.testing.assert_allclose(mean_curvature(ball), 0.5, rtol=0.1)
    assert "the basis was measured" in record.read(ball.data)["notes"]


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT", "SCULPT"])
def test_the_active_shape_key_is_measured_on_request(mode):
    (ball,) = add_spheres("ball")
    add_keys(ball)
    bpy.context.scene.paradesc.shape_key = "active"
    bpy.ops.object.mode_set(mode=mode)
    bpy.ops.paradesc.bake()
    bpy.ops.object.mode_set(mode="OBJECT")
    np.testing.assert_allclose(mean_curvature(ball), 1.0, rtol=0.1)
    assert [key.name for key in ball.data.shape_keys.key_blocks] == ["Basis", "small", "shown"]
    assert ball.active_shape_key_index == 1
    assert ball.data.shape_keys.key_blocks["shown"].value == 1.0


def test_custom_normals_are_measured_on_request_and_stay():
    (ball,) = add_spheres("ball")
    mesh = ball.data
    if hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth = True
    inward = -mesh_io.read_positions(mesh) / 2.0
    mesh.normals_split_custom_set_from_vertices(inward.tolist())
    before = mesh_io.read_corner_normals(mesh)
    bpy.context.scene.paradesc.normals = "mesh"
    bpy.ops.paradesc.bake()
    np.testing.assert_allclose(mean_curvature(ball), -0.5, rtol=0.1)
    np.testing.assert_allclose(mesh_io.read_corner_normals(mesh), before, atol=1e-6)


# ---- Scale


def test_object_space_does_without_the_scale_and_says_so_where_it_is_uneven():
    (ball,) = add_spheres("ball")
    ball.scale = (2.0, 2.0, 2.0)
    bpy.ops.paradesc.bake()
    np.testing.assert_allclose(mean_curvature(ball), 0.5, rtol=0.1)
    assert "scaled" not in record.read(ball.data)["warnings"]
    ball.scale = (2.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    bpy.ops.paradesc.bake()
    np.testing.assert_allclose(mean_curvature(ball), 0.5, rtol=0.1)
    assert "measure in World, or apply the scale" in record.read(ball.data)["warnings"]


def test_world_space_counts_the_scale_of_parents_and_mirroring():
    (ball,) = add_spheres("ball")
    parent = bpy.data.objects.new("parent", None)
    bpy.context.collection.objects.link(parent)
    ball.parent, parent.scale, ball.scale = parent, (2.0, 2.0, 2.0), (1.0, -1.0, 1.0)
    bpy.context.view_layer.update()
    bpy.context.scene.paradesc.space = "world"
    bpy.ops.paradesc.bake()
    np.testing.assert_allclose(mean_curvature(ball), 0.25, rtol=0.1)
    stored = record.read(ball.data)
    assert stored["settings"]["space"] == "world"
    assert "scaled" not in stored["warnings"]


def test_world_space_is_what_applying_the_scale_gives():
    first, second = add_spheres("first", "second")
    bpy.context.scene.paradesc.space = "world"
    first.scale = (1.3, 1.0, 0.7)
    second.data.vertices.foreach_set("co", (mesh_io.read_positions(second.data) * first.scale).ravel())
    bpy.context.view_layer.update()
    bpy.ops.paradesc.bake()
    # The same positions except for the last bit of a float.
    np.testing.assert_allclose(mean_curvature(first), mean_curvature(second), rtol=1e-3)


# ---- Other files


def link_sphere(tmp_path):
    """The sphere of another file, linked, selected and active."""
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {add_sphere("ball")})
    empty_scene()
    small_bake()
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects, wanted.meshes = ["ball"], ["ball"]
    show_only(wanted.objects[0])
    return wanted.objects[0]


def show_only(target):
    for item in bpy.context.view_layer.objects:
        item.select_set(False)
    bpy.context.collection.objects.link(target)
    target.select_set(True)
    bpy.context.view_layer.objects.active = target


def reloaded_attributes(tmp_path, name):
    """The names that the object's mesh has after the file was saved and opened again."""
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    return set(bpy.data.objects[name].data.attributes.keys())


def linked(tmp_path):
    return link_sphere(tmp_path)


def overridden_object(tmp_path):
    made = link_sphere(tmp_path).override_create()
    show_only(made)
    return made


def overridden_mesh(tmp_path):
    mesh = link_sphere(tmp_path).data.override_create()
    made = bpy.data.objects.new("own", mesh)
    show_only(made)
    return made


@pytest.mark.parametrize("make", [linked, overridden_object, overridden_mesh])
def test_meshes_of_other_files_are_refused_and_made_local_on_request(tmp_path, make):
    target = make(tmp_path)
    assert "make it local" in targets.obstacle(bpy.context)
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.bake()
    assert bpy.ops.paradesc.make_local() == {"FINISHED"}
    assert targets.obstacle(bpy.context) == ""
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    name = bpy.context.view_layer.objects.active.name if make is linked else target.name
    key = (name, None)
    np.testing.assert_allclose(mean_curvature(bpy.data.objects[key]), 0.5, rtol=0.1)
    assert "mean_curvature" in reloaded_attributes(tmp_path, key)


def test_live_of_an_overridden_object_can_be_chosen():
    group = bpy.types.Object.bl_rna.properties["paradesc_live"]
    chosen = [group, *(group.fixed_type.properties[name] for name in ("mode", "follows"))]
    assert all(member.is_overridable for member in chosen)


def test_a_linked_object_that_overrides_follow_is_not_made_local(tmp_path):
    origin = link_sphere(tmp_path)
    made = origin.override_create()
    bpy.context.collection.objects.link(made)
    with pytest.raises(RuntimeError, match="Overrides follow"):
        bpy.ops.paradesc.make_local()
    assert origin.library is not None
    assert made.override_library.reference == origin


def test_nothing_to_make_local_is_said_by_the_poll():
    add_spheres("ball")
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.make_local()


# ---- What is no mesh


def of_kind(kind, name):
    """A text, a curve or a metaball of this name, selected beside what is."""
    content = bpy.data.metaballs.new(name) if kind == "META" else bpy.data.curves.new(name, kind)
    if kind == "FONT":
        content.body, content.extrude = "A", 0.1
    elif kind == "META":
        content.elements.new()
    else:
        spline = content.splines.new("POLY")
        spline.points.add(1)
        spline.points[1].co = (1.0, 0.0, 0.0, 1.0)
        content.bevel_depth = 0.1
    made = bpy.data.objects.new(name, content)
    bpy.context.collection.objects.link(made)
    made.select_set(True)
    return made


def test_what_a_bake_skips_is_named_at_the_end_of_its_line(capfd):
    (sphere,) = add_spheres("ball")
    for index in range(4):
        of_kind("FONT", f"text {index}")
    assert sorted(item.name for item in targets.skipped(bpy.context)) == [f"text {index}" for index in range(4)]
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert '; 4 skipped, not meshes: "text 0", "text 1", "text 2", …' in capfd.readouterr().out
    assert "mean_curvature" in sphere.data.attributes


def test_nothing_is_skipped_where_all_are_meshes(capfd):
    add_spheres("ball")
    assert targets.skipped(bpy.context) == []
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert "skipped" not in capfd.readouterr().out
    assert not bpy.ops.paradesc.convert_to_mesh.poll()


@pytest.mark.parametrize("kind", ["FONT", "CURVE", "META"])
def test_what_is_no_mesh_is_converted_in_place_and_can_be_baked(kind):
    (sphere,) = add_spheres("ball")
    sphere.select_set(False)
    made = of_kind(kind, "thing")
    made.location.x = 3.0
    bpy.context.view_layer.objects.active = made
    assert targets.obstacle(bpy.context) == "Convert the selected objects to meshes first"
    assert bpy.ops.paradesc.convert_to_mesh() == {"FINISHED"}
    (converted,) = bpy.context.view_layer.objects.selected
    assert (converted.type, converted.name, converted.location.x) == ("MESH", "thing", 3.0)
    assert bpy.context.view_layer.objects.active == converted
    assert targets.obstacle(bpy.context) == ""
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert "mean_curvature" in converted.data.attributes


@pytest.mark.parametrize("kind", ["FONT", "CURVE"])
def test_objects_that_share_the_data_of_what_is_converted_stay_as_they_are(kind):
    made = of_kind(kind, "thing")
    other = bpy.data.objects.new("other", made.data)
    bpy.context.collection.objects.link(other)
    bpy.context.view_layer.update()
    assert bpy.ops.paradesc.convert_to_mesh() == {"FINISHED"}
    assert (made.type, other.type) == ("MESH", kind)
    assert len(made.data.polygons) > 0


def test_meshes_stay_selected_and_active_when_others_are_converted():
    (sphere,) = add_spheres("ball")
    of_kind("FONT", "text")
    of_kind("CURVE", "wire")
    bpy.context.view_layer.objects.active = sphere
    sphere.select_set(True)
    assert bpy.ops.paradesc.convert_to_mesh() == {"FINISHED"}
    assert sorted(item.name for item in targets.chosen(bpy.context)) == ["ball", "text", "wire"]
    assert targets.chosen(bpy.context)[0] == sphere


def test_a_curve_without_a_surface_stays_a_curve_and_is_named(capfd):
    add_spheres("ball")
    wire = of_kind("CURVE", "wire")
    wire.data.bevel_depth = 0.0
    assert bpy.ops.paradesc.convert_to_mesh() == {"CANCELLED"}
    assert "no faces" in capfd.readouterr().out
    assert wire.type == "CURVE"
