"""After an import an armature or an empty is the active object: the panel is about the mesh that the button bakes."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from panel_test import context, drawn_by  # noqa: E402

from paradesc_blender.scene import record, targets  # noqa: E402
from paradesc_blender.show import overlay, recolor  # noqa: E402
from paradesc_blender.ui import image_result, live_panel, panel, report_panel  # noqa: E402
from scene import add_sphere, select, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
PARENTS = ["ARMATURE", "EMPTY"]


@pytest.fixture(params=PARENTS)
def rig(request):
    """The active object, which carries the meshes of a file."""
    small_bake()
    bpy.context.scene.paradesc.descriptors = {"cavity"}
    data = bpy.data.armatures.new("rig") if request.param == "ARMATURE" else None
    made = bpy.data.objects.new("rig", data)
    bpy.context.collection.objects.link(made)
    return made


def carried(rig, name="body"):
    """A mesh below an empty below what carries it, as glTF has them."""
    middle = bpy.data.objects.new("node", None)
    bpy.context.collection.objects.link(middle)
    middle.parent = rig
    made = add_sphere(name)
    made.parent = middle
    bpy.context.view_layer.update()
    return made


@pytest.mark.parametrize("selected", [True, False], ids=["all selected", "parent alone"])
def test_the_panel_shows_what_the_button_has_baked(rig, selected):
    body = carried(rig)
    select(*([body] if selected else []), rig)
    assert targets.obstacle(bpy.context) == ""
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert "cavity" in record.attributes_of(body.data)
    shown = drawn_by(panel.PARADESC_PT_bake)
    assert any(line.startswith("Cavity · ") for line in shown["label"])
    assert {"follows", "contrast", "brightness", "invert"} <= set(shown["prop"])
    assert "paradesc_blender.show" in shown["operator"] or "Cavity" in shown["operator"]
    assert report_panel.PARADESC_PT_report.poll(context())
    assert live_panel.PARADESC_PT_live.poll(context())


def test_levels_the_list_of_masks_and_the_legend_are_of_that_mesh(rig):
    body = carried(rig)
    select(body, rig)
    bpy.ops.paradesc.bake()
    bpy.context.scene.paradesc_looks.invert = True
    assert record.read(body.data)["drawn"]["cavity"]["invert"]
    assert [name for name, _, _ in recolor.name_items(None, bpy.context)] == ["cavity"]
    assert bpy.ops.paradesc.show(name="cavity") == {"FINISHED"}
    assert overlay.name_in("SOLID", "VERTEX", body) == "cavity"
    assert targets.first(bpy.context) == body


def test_an_image_has_its_line_and_its_buttons(rig):
    body = carried(rig)
    select(rig)
    bpy.context.scene.paradesc.texels = 64
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    found = image_result.image_results.found(body)
    assert image_result.result_sentence(found) in " ".join(drawn_by(panel.PARADESC_PT_bake)["label"])
    assert bpy.ops.paradesc.show_image() == {"FINISHED"}


def test_the_only_mesh_is_taken_and_of_several_none_that_is_not_selected(rig):
    body, shoe = carried(rig), carried(rig, "shoe")
    select(rig)
    assert targets.chosen(bpy.context) == []
    assert targets.first(bpy.context) is None
    select(shoe, rig)
    assert targets.chosen(bpy.context) == [shoe]
    shoe.parent = None
    select(rig)
    assert targets.chosen(bpy.context) == [body]


def test_a_selected_mesh_counts_though_no_object_is_active(rig):
    body = carried(rig)
    select(body)
    bpy.context.view_layer.objects.active = None
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert any(line.startswith("Cavity · ") for line in drawn_by(panel.PARADESC_PT_bake)["label"])
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}


def test_without_a_window_nobody_looks_at_an_object():
    assert targets.first(object()) is None
