"""The user's attributes are kept: every writer replaces only those that the add-on wrote and nobody changed.

Every writer is driven twice through one test: first beside things of the user's that have the names it wants, all of
which have to stay as they are to the last bit; then again, when its own things are replaced and do not pile up.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from mesh_io_test import made_up_results  # noqa: E402

from live_values import switch  # noqa: E402
from paradesc_blender.animation import sessions  # noqa: E402
from paradesc_blender.scene import arrays, delivery  # noqa: E402
from paradesc_blender.show import recolor  # noqa: E402
from scene import add_sphere, select, subdivide  # noqa: E402
from writers import NAME, WRITERS, attribute, bake, everything, kinds  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_the_users_stays_as_it_is(name, target, folder):
    writer = WRITERS[name]
    writer.taken(target)
    before = everything(folder)
    if writer.fails:
        with pytest.raises(RuntimeError, match=writer.fails):
            writer.write(target)
        after = everything(folder)
        assert {key: after.get(key) for key in before} == before
        return
    writer.write(target)
    after = everything(folder)
    changed = {key for key, content in before.items() if after.get(key) != content}
    assert {key for key in changed if not writer.changes & {key[0], key[-1]}} == set()
    assert after.keys() > before.keys()  # and what was asked for is there


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_ours_is_replaced_and_does_not_pile_up(name, target, folder):
    writer = WRITERS[name]
    if not writer.fails:
        writer.taken(target)
    writer.write(target)
    once = kinds(everything(folder))
    (writer.again or writer.write)(target)
    assert kinds(everything(folder)) == once


# ---- Attributes


def test_buttons_are_grey_where_all_was_deleted(target):
    bake(target)
    for name in (NAME, "cavity"):
        gone(target.data, name)
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.corner_colors()


def test_ours_stays_ours_when_the_mesh_is_edited(target):
    bake(target)
    subdivide()
    names = target.data.attributes.keys()
    bake(target)
    assert target.data.attributes.keys() == names


def own_cavity(mesh, name="cavity"):
    """Makes the user's attribute; gives its values."""
    kind, width = ("FLOAT_COLOR", 4) if "color" in name else ("FLOAT", 1)
    values = np.linspace(0.1, 0.5, width * len(mesh.vertices), dtype=np.float32)
    arrays.set_values(mesh.attributes.new(name, kind, "POINT"), values)
    return values


@pytest.mark.parametrize("name", ["cavity", "cavity_color"])
def test_what_is_made_in_place_of_deleted_results_stays_when_the_faces_have_changed(name, target):
    bake(target)
    for one in ("cavity", "cavity_color"):
        gone(target.data, one)
    subdivide()
    values = own_cavity(target.data, name)
    for _ in range(2):
        bake(target)
        assert np.array_equal(arrays.attribute_values(target.data.attributes[name]).ravel(), values)
        assert "cavity_2" in recolor.baked_names(target.data)
    assert "cavity_3" not in target.data.attributes


@pytest.mark.parametrize("name", ["", "cavity", "cavity_color", "coverage"])
def test_what_a_joined_mesh_brings_stays(name, target):
    bake(target)
    other = add_sphere("other", steps=4)
    values = own_cavity(other.data, name) if name else []
    moved = {f"{name.removesuffix('_color')}_2"} if name else set()
    select(other, target)
    bpy.ops.object.join()
    for change in (lambda: None, subdivide):  # after the first bake all vertices are covered
        change()
        bake(target)
        names = target.data.attributes.keys()
        assert {one for one in names if one.endswith(("_2", "_3"))} == moved
    assert not name or np.isin(values, arrays.attribute_values(target.data.attributes[name])).all()


@pytest.mark.parametrize("name", [NAME, "coverage"])
def test_live_values_leave_what_a_joined_mesh_brings(name, target):
    switch(target)
    other = add_sphere("other", steps=4)
    values = own_cavity(other.data, name)
    select(other, target)
    bpy.ops.object.join()
    bpy.context.scene.frame_set(2)
    assert target.paradesc_live.mode == "LIVE"
    assert np.isin(values, arrays.attribute_values(target.data.attributes[name])).all()
    assert f"{name}_2" in target.data.attributes


@pytest.mark.parametrize("invert", [False, True])
def test_ours_stays_ours_where_zero_is_white(invert, target):
    bpy.context.scene.paradesc_looks.invert = invert
    bpy.context.scene.paradesc.descriptors = {"cavity", "mean_curvature"}
    for _ in range(2):
        bpy.ops.paradesc.bake()
        names = target.data.attributes.keys()
        subdivide()
    assert target.data.attributes.keys() == names


def test_ours_stays_ours_beside_new_parts_that_have_no_values(target):
    bake(target)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.mesh.bevel(offset=0.3, segments=2)
    bpy.ops.object.mode_set(mode="OBJECT")
    names = target.data.attributes.keys()
    bake(target)
    assert target.data.attributes.keys() == names


def test_the_sentence_says_what_stays_and_where_the_values_are(target):
    attribute(NAME)(target)
    (sentence,) = delivery.deliver(target, made_up_results(target))
    assert f'"{NAME}" is not from a bake' in sentence
    assert f'"{NAME}_2"' in sentence


def gone(mesh, name):
    mesh.attributes.remove(mesh.attributes[name])


def renamed(mesh, name):
    mesh.attributes[name].name = "mine"


def converted(mesh, name):
    bpy.context.scene.view_layers[0].objects.active = bpy.data.objects["sphere"]
    mesh.attributes.active_index = mesh.attributes.keys().index(name)
    bpy.ops.geometry.attribute_convert(domain="CORNER", data_type="BYTE_COLOR")


@pytest.mark.parametrize("which", [NAME, f"{NAME}_color"])
@pytest.mark.parametrize("change", [gone, renamed, converted])
def test_menus_and_buttons_leave_out_what_was_deleted_or_renamed(change, which, target):
    bake(target)
    change(target.data, which)
    assert recolor.baked_names(target.data) == ["cavity"]
    assert recolor.shown_name(target.data) in ("", "cavity")
    with pytest.raises(TypeError, match="not found in"):
        bpy.ops.paradesc.show(name=NAME)
    bpy.ops.paradesc.show(name="cavity")
    for name in ("corner_colors", "vertex_group", "export_copies", "make_material", "recolor", "pack"):
        bpy.context.scene.paradesc_looks.pack_red = "cavity"
        assert getattr(bpy.ops.paradesc, name)() == {"FINISHED"}, name
    bake(target)
    assert NAME in recolor.baked_names(target.data) or f"{NAME}_2" in recolor.baked_names(target.data)


def test_objects_that_nobody_has_made_live_get_no_settings(target):
    other = add_sphere("other", steps=2)
    assert switch(target) == ""
    bpy.context.scene.frame_set(2)
    assert not sessions.is_live(other)
    assert not other.is_property_set("paradesc_live")
