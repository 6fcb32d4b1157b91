"""What is the user's stays the user's: whatever writes replaces only what is ours and as we left it.

Every writer is driven twice through one test: first beside things of the user's that have the names it wants, all of
which have to stay as they are to the last bit; then again, when its own things are replaced and do not pile up.
"""

import unicodedata
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from mesh_io_test import made_up_results  # noqa: E402

from paradesc.bake import batch, pieces  # noqa: E402
from paradesc.files import cache, file_names, marks  # noqa: E402
from paradesc.scene import mesh_io, sculpt_masks, viewports  # noqa: E402
from paradesc.settings import preset_folders  # noqa: E402
from paradesc.show import recolor  # noqa: E402
from scene import add_sphere, small_bake  # noqa: E402

NAME = "mean_curvature"
MEMBERS = {"FLOAT": ("value", 1), "INT": ("value", 1), "FLOAT_VECTOR": ("vector", 3)}
MEMBERS |= {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4)}

pytestmark = pytest.mark.usefixtures("registered")


# ---- Everything that there is


def attributes_of(mesh):
    """The values of every attribute and UV map that people see, by name."""
    found = {}
    for attribute in mesh.attributes:
        seen = attribute.name[0] != "." and attribute.name != "material_index"  # which "faces" has
        if seen and attribute.data_type in MEMBERS:
            member, width = MEMBERS[attribute.data_type]
            values = np.empty(len(attribute.data) * width, np.int32 if attribute.data_type == "INT" else np.float32)
            attribute.data.foreach_get(member, values)
            found["attribute", mesh.name, attribute.name] = (attribute.data_type, attribute.domain, values.tobytes())
    if sculpt_masks.is_painted(mesh):
        found["sculpt mask", mesh.name] = sculpt_masks.values(mesh).tobytes()
    for layer in mesh.uv_layers:
        values = np.empty(2 * len(layer.data), np.float32)
        layer.data.foreach_get("uv", values)
        found["UV map", mesh.name, layer.name] = values.tobytes()
    return found


def weights_of(target):
    """The weights of every vertex group, by name."""
    names = {group.index: group.name for group in target.vertex_groups}
    found = {("vertex group", target.name, name): [] for name in names.values()}
    for vertex in target.data.vertices:
        for one in vertex.groups:
            found["vertex group", target.name, names[one.group]].append((vertex.index, one.weight))
    return found


def node_tree(tree):
    """The nodes of a tree with what they are set to."""
    return {
        node.name: (node.bl_idname, [str(getattr(socket, "default_value", None)) for socket in node.inputs])
        for node in tree.nodes
    }


def everything(folder):
    """The contents of all that a writer could change, by kind and name."""
    found: dict[tuple, Any] = {}
    for mesh in bpy.data.meshes:
        found |= attributes_of(mesh)
    for target in bpy.data.objects:
        if target.type == "MESH":
            found |= weights_of(target)
            slots = [(item.link, item.material) for item in target.material_slots]
            found |= {("slot", target.name, index): item for index, item in enumerate(slots)}
            found["faces", target.data.name] = [face.material_index for face in target.data.polygons]
        found["object", target.name] = (target.data.name, tuple(target.location))
        found |= {("modifier", target.name, item.name): item.type for item in target.modifiers}
    found |= {("material", item.name): node_tree(item.node_tree) for item in bpy.data.materials if item.use_nodes}
    found |= {("node group", item.name): node_tree(item) for item in bpy.data.node_groups}
    for image in bpy.data.images:
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        settings = (image.colorspace_settings.name, image.alpha_mode, image.filepath)
        found["image", image.name] = (*settings, tuple(image.size), pixels.tobytes())
    for path in folder.rglob("*"):
        if path.is_file() and path.suffix not in (".blend", ".blend1"):
            found["file", str(path.relative_to(folder))] = path.read_bytes()
    return found


def kinds(found):
    """How much there is of each kind; what is made again may have another number behind its name."""
    return Counter(key[0] for key in found)


# ---- The writers


@dataclass
class Writer:
    """One thing that writes, and what the user has made before where it would write."""

    write: Any  # called with the object
    taken: Any  # called with the object, makes the user's things
    fails: str = ""  # where the user's thing leaves no room, the sentence says so
    changes: set = field(default_factory=set)  # what a click is asked to change, by kinds as above or by names
    again: Any = None  # the second click, where it has to be another one


def bake(target):
    mesh_io.write_results(target, made_up_results(target, (NAME, "cavity")))


def attribute(name, kind="FLOAT", domain="POINT"):
    """Makes the user's attribute, with values of his own."""

    def make(target):
        made = target.data.attributes.new(name, kind, domain)
        member, width = MEMBERS[kind]
        values = np.arange(len(made.data) * width) % 7
        made.data.foreach_set(member, values.astype(np.int32 if kind == "INT" else np.float32))

    return make


def group(name):
    """Makes the user's vertex group."""
    return lambda target: target.vertex_groups.new(name=name).add([1, 2, 3], 0.25, "REPLACE")


def uv_map(name):
    """Gives the user's UV map a name."""

    def make(target):
        target.data.uv_layers[0].name = name

    return make


def painted(name, write=bake):
    """Makes what we make, and paints over it as the user would."""

    def make(target):
        write(target)
        attribute = target.data.attributes[name]
        member, width = MEMBERS[attribute.data_type]
        values = np.empty(len(attribute.data) * width, np.float32)
        attribute.data.foreach_get(member, values)
        values[3] = 0.625
        attribute.data.foreach_set(member, values)

    return make


def click(name, **words):
    """Bakes, if nothing is there, and clicks one of the buttons that copy values."""

    def write(target):
        if NAME not in target.data.attributes:
            bake(target)
        assert getattr(bpy.ops.paradesc, name)(**words) == {"FINISHED"}

    return write


def converted_to_whole(name, write):
    """Makes what we make, and converts it to another type as the user would."""

    def make(target):
        write(target)
        target.data.attributes.remove(target.data.attributes[name])
        attribute(name, "INT")(target)

    return make


def pack(target):
    bpy.context.scene.paradesc_looks.pack_red = NAME
    click("pack")(target)


def painted_group(target):
    click("vertex_group")(target)
    target.vertex_groups[NAME].add([3], 0.625, "REPLACE")


def baked_then(make):
    """Bakes, then makes the user's thing."""

    def both(target):
        bake(target)
        make(target)

    return both


def sculpt_mask(target):
    sculpt_masks.write(target, np.full(len(target.data.vertices), 0.25, np.float32))


def materials(target):
    """Gives the faces two materials, of which the object has one itself."""
    for name in ("skin", "cloth"):
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        target.data.materials.append(made)
    target.material_slots[1].link = "OBJECT"
    target.material_slots[1].material = bpy.data.materials["skin"]
    target.data.polygons.foreach_set("material_index", np.arange(len(target.data.polygons)) % 2)


def tuned_material(target):
    """Makes one of our materials, and tunes it."""
    click("make_material", kind="flat")(target)
    target.data.materials[0].node_tree.nodes["Emission"].inputs["Strength"].default_value = 3.0


def tuned_nodes(target):
    """Makes one of our groups of geometry nodes, and tunes it."""
    click("add_geometry_nodes")(target)
    target.modifiers[0].node_group.nodes["Map Range"].inputs["To Max"].default_value = 3.0


def instead_of_the_last(write):
    """Takes away the modifier that the last click has added, and clicks again."""

    def both(target):
        target.modifiers.remove(target.modifiers[-1])
        write(target)

    return both


def bake_image(target):
    """Bakes a texture of a few texels."""
    settings = small_bake("cpu")
    settings.texels, settings.descriptors = 16, {NAME}
    for item in bpy.context.view_layer.objects:
        item.select_set(item == target)
    bpy.context.view_layer.objects.active = target
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}


def file(name, content=b"the user's own"):
    """Makes the user's file beside the .blend."""
    return lambda _target: (Path(bpy.data.filepath).parent / name).write_bytes(content)


def image_of(name):
    return next(image for image in bpy.data.images if Path(image.filepath).name == name)


def edited_file(_target):
    """Bakes a texture, which another program then writes again."""
    bake_image(_target)
    path = Path(bpy.data.filepath).parent / "sphere_curvature.png"
    path.write_bytes(path.read_bytes() + b"written by another program")
    bpy.data.images.remove(image_of("sphere_curvature.png"))


def painted_image(target):
    """Bakes a texture, and paints on it in Blender without saving it."""
    bake_image(target)
    image = image_of("sphere_curvature.png")
    pixels = np.full(len(image.pixels), 0.25, np.float32)
    image.pixels.foreach_set(pixels)
    image.update()
    assert image.is_dirty


def texture_of(*names):
    """Bakes the textures of other objects of these names, one after another."""

    def make(target):
        target.name = "Wall.001"
        for name in names:
            bake_image(add_sphere(name, steps=3))

    return make


def bake_from_elsewhere(target):
    """Bakes a texture from another .blend in the same folder, whose object has the same name."""
    bake_image(target)
    path = Path(bpy.data.filepath)
    bpy.data.images.remove(image_of("sphere_curvature.png"))
    bpy.ops.wm.save_as_mainfile(filepath=str(path.with_name("other.blend")), check_existing=False)
    target.data.vertices[0].co *= 2.0


def in_unsaved_file(write):
    """What Blender does in a file that is not saved: it packs images."""

    def make(target):
        name = target.name
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        write(add_sphere(name, steps=3))

    return make


def packed_and_painted(target):
    bake_image(target)
    image = bpy.data.images["sphere_curvature"]
    image.pixels.foreach_set(np.full(len(image.pixels), 0.25, np.float32))
    image.pack()
    assert not image.is_dirty


def bake_image_here(_target):
    bake_image(bpy.data.objects["sphere"])


def remeshed(target):
    """Bakes what Remesh makes, whose vertices are none of the object's."""
    if "Remesh" not in target.modifiers:
        target.modifiers.new("Remesh", "REMESH").voxel_size = 1.0
    settings = small_bake("cpu")
    settings.descriptors = {NAME}
    bpy.context.scene.paradesc_animation.source = "evaluated"
    bpy.context.view_layer.objects.active = target
    for item in bpy.context.view_layer.objects:
        item.select_set(item == target)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}


def result_of(target):
    return bpy.data.objects[f"{target.name}_paradesc"]


def remeshed_and(change):
    """The user's change of the result object."""

    def make(target):
        remeshed(target)
        change(result_of(target))

    return make


def sculpted(result):
    result.data.vertices[0].co.z += 0.5


def with_material(result):
    result.data.materials.append(bpy.data.materials.new("mine"))


def with_attribute(result):
    attribute("mine")(result)


def called_otherwise(result):
    result.name = "mine"


def painted_result(result):
    colors = result.data.attributes[f"{NAME}_color"]
    colors.data[0].color = (0.25, 0.5, 0.75, 1.0)


def long_name(target):
    """An object whose name leaves no room for an ending."""
    target.name = "x" * 60


def live(target):
    """Switches live values on, and off again."""
    bpy.context.scene.paradesc.descriptors = {NAME}
    target.paradesc_live.mode = "LIVE"
    assert target.paradesc_live.sentence == ""
    target.paradesc_live.mode = "OFF"


def frames(target):
    """Bakes two frames into the cache, and plays one."""
    small_bake("cpu")
    scene = bpy.context.scene
    scene.frame_end, scene.paradesc.descriptors = 2, {NAME}
    for item in bpy.context.view_layer.objects:
        item.select_set(item == target)
    bpy.context.view_layer.objects.active = target
    scene.paradesc_animation.overwrite = True
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    target.paradesc_live.mode = "CACHE"
    assert target.paradesc_live.sentence == ""
    target.paradesc_live.mode = "OFF"


def frames_of(*names):
    """Bakes the frames of other objects of these names, one after another."""

    def make(target):
        target.name = "Crate"
        for name in names:
            frames(add_sphere(name, steps=4))

    return make


CHANGES = (sculpted, with_material, with_attribute, called_otherwise, painted_result)
MADE = "not made here, or was changed since"
COLORS = f"{NAME}_corner_color"
WRITERS = {
    "corner colors": Writer(click("corner_colors"), attribute(COLORS, "BYTE_COLOR", "CORNER"), MADE),
    "corner colors painted over": Writer(click("corner_colors"), painted(COLORS, click("corner_colors")), MADE),
    "packed channels": Writer(pack, attribute("paradesc_packed", "FLOAT_COLOR"), MADE),
    "packed channels painted over": Writer(pack, painted("paradesc_packed", pack), MADE),
    "packed channels of another type": Writer(pack, converted_to_whole("paradesc_packed", pack), MADE),
    "copies for glTF": Writer(click("export_copies"), attribute(f"_{NAME}"), MADE),
    "copies for glTF painted over": Writer(click("export_copies"), painted(f"_{NAME}", click("export_copies")), MADE),
    "vertex group": Writer(click("vertex_group"), baked_then(group(NAME)), MADE),
    "vertex group painted over": Writer(click("vertex_group"), painted_group, MADE),
    "sculpt mask": Writer(
        click("sculpt_mask"), sculpt_mask, "allow to replace it", again=click("sculpt_mask", replace=True)
    ),
    "material": Writer(click("make_material"), materials, changes={"faces"}),
    "material of another kind": Writer(click("make_material"), tuned_material, changes={"slot"}),
    "cavity material": Writer(click("make_material", kind="cavity"), tuned_material, changes={"slot"}),
    "geometry nodes": Writer(
        click("add_geometry_nodes"), tuned_nodes, again=instead_of_the_last(click("add_geometry_nodes"))
    ),
    "image file": Writer(bake_image, file("sphere_curvature.png")),
    "image file in other case": Writer(bake_image, file("Sphere_Curvature.PNG")),
    "image file that was edited": Writer(bake_image, edited_file),
    "image that was painted on": Writer(bake_image, painted_image),
    "image of another object": Writer(bake_image, texture_of("Wall 001")),
    "image of two other objects": Writer(bake_image, texture_of("Wall 001", "wall_001")),
    "image of another .blend": Writer(bake_image, bake_from_elsewhere),
    "packed image": Writer(bake_image_here, in_unsaved_file(packed_and_painted)),
    "packed image of another object": Writer(
        lambda _target: bake_image(bpy.data.objects["Wall.001"]), in_unsaved_file(texture_of("Wall 001"))
    ),
    **{f"result object, {change.__name__}": Writer(remeshed, remeshed_and(change)) for change in CHANGES},
    "result object of a long name": Writer(remeshed, long_name),
    "live values": Writer(live, attribute(NAME)),
    "live values over what was painted": Writer(live, painted(f"{NAME}_color"), changes={"coverage"}),
    "live coverage": Writer(live, attribute("coverage")),
    "played values": Writer(frames, attribute(NAME)),
    "frames of another object": Writer(frames, frames_of("crate", "Cr ate")),
    "recolor": Writer(click("recolor"), painted(f"{NAME}_color", click("recolor")), "painted over"),
    "attribute": Writer(bake, attribute(NAME)),
    "attribute of another type": Writer(bake, attribute(NAME, "INT", "FACE")),
    "colors": Writer(bake, attribute(f"{NAME}_color", "FLOAT_COLOR")),
    "coverage": Writer(bake, attribute("coverage")),
    "mask": Writer(bake, attribute("paradesc_mask")),
    "UV map": Writer(bake, uv_map(NAME)),
    "vertex group of a descriptor": Writer(bake, group(NAME)),
    "vertex group of colors": Writer(bake, group(f"{NAME}_color")),
    "vertex group of the coverage": Writer(bake, group("coverage")),
    "values painted over": Writer(bake, painted(NAME)),
    "colors painted over": Writer(bake, painted(f"{NAME}_color")),
    "coverage painted over": Writer(bake, painted("coverage")),
}


@pytest.fixture
def target():
    return add_sphere(steps=3)


@pytest.fixture
def folder(tmp_path):
    """The folder of the saved file."""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"), check_existing=False)
    return tmp_path


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_the_users_stays_as_it_is(name, target, folder: Path):
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


# ---- What else follows


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


def settings_of(scene):
    """Every setting and color, and whether it is stored."""
    groups = (scene.paradesc, scene.paradesc_looks)
    names = [(group, item.identifier) for group in groups for item in group.bl_rna.properties]
    return {
        (type(group).__name__, name): (str(getattr(group, name)), group.is_property_set(name))
        for group, name in names
        if name != "rna_type"
    }


def tuned_settings(scene):
    """Settings as somebody has tuned them."""
    settings = scene.paradesc
    settings.samples, settings.radius_percent, settings.creases = 999, 4.0, "none"
    scene.paradesc_looks.color_map, scene.paradesc_looks.show_legend = "heat", False
    settings.property_unset("descriptors")


def without_faces(target):
    target.data.clear_geometry()


def nothing_to_write(target):
    bpy.context.scene.paradesc.write_attributes = False
    bpy.context.scene.paradesc.write_image = True
    bpy.context.scene.paradesc.image_path = ""


@pytest.mark.parametrize("spoil", [without_faces, nothing_to_write])
@pytest.mark.parametrize("words", [{"mask": "edge_wear"}, {"mask": "curvature", "radius": 7.0}, {"radius": 7.0}])
def test_a_bake_that_fails_leaves_all_settings_as_they_were(spoil, words, target):
    tuned_settings(bpy.context.scene)
    spoil(target)
    before = settings_of(bpy.context.scene)
    with pytest.raises(RuntimeError, match="Error"):
        bpy.ops.paradesc.bake(**words)
    assert settings_of(bpy.context.scene) == before


def test_a_bake_that_is_cancelled_leaves_all_settings_as_they_were(target, monkeypatch):
    tuned_settings(bpy.context.scene)
    before = settings_of(bpy.context.scene)
    step = batch.Batch.step
    monkeypatch.setattr(batch.Batch, "step", lambda made, wait=False: (made.cancel(), step(made, wait)))
    assert bpy.ops.paradesc.bake(mask="edge_wear", radius=7.0) == {"CANCELLED"}
    assert settings_of(bpy.context.scene) == before


def test_a_mask_chooses_its_descriptors_and_leaves_all_else(target):
    scene = bpy.context.scene
    tuned_settings(scene)
    before = settings_of(scene)
    assert bpy.ops.paradesc.mask(name="edge_wear") == {"FINISHED"}
    assert scene.paradesc.descriptors == {"convexity"}
    after = settings_of(scene)
    assert {key[1] for key, value in after.items() if before[key] != value} == {"descriptors"}
    assert bpy.ops.paradesc.bake(mask="cavity") == {"FINISHED"}
    assert (scene.paradesc.samples, scene.paradesc.radius_percent) == (999, 4.0)


def test_a_mask_brings_its_radius_where_nobody_has_chosen_one(target):
    settings = bpy.context.scene.paradesc
    settings.property_unset("descriptors")
    for name, radius in (("edge_wear", 1.5), ("openness", 5.0), ("cavity", 2.0)):
        bpy.ops.paradesc.mask(name=name)
        assert settings.radius_percent == radius
    settings.radius_unit = "absolute"
    bpy.ops.paradesc.mask(name="openness")
    assert (settings.radius_unit, settings.radius_percent) == ("absolute", 2.0)


def test_a_result_object_keeps_earlier_masks_and_where_it_was_moved(target):
    remeshed(target)
    result = result_of(target)
    values = result.data.attributes[NAME].data
    before = [item.value for item in values]
    result.location.x, settings = 9.0, bpy.context.scene.paradesc
    settings.descriptors = {"cavity"}
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert recolor.baked_names(result.data) == ["cavity", NAME]
    assert [item.value for item in result.data.attributes[NAME].data] == before
    assert result.location.x == 9.0


def test_a_result_object_that_was_not_moved_follows_its_object(target):
    remeshed(target)
    target.location.x = 5.0
    bpy.context.view_layer.update()
    remeshed(target)
    assert result_of(target).location.x == 5.0


def slots_and_faces(target):
    """What the faces of an object show: by slots, and by the materials in these."""
    slots = [(item.link, item.material.name) for item in target.material_slots]
    return slots, [slots[face.material_index] for face in target.data.polygons]


def test_removing_our_material_keeps_what_objects_have_in_slots_behind_it(target):
    bake(target)
    materials(target)
    click("make_material")(target)
    target.data.materials.append(bpy.data.materials["cloth"])
    target.material_slots[3].link = "OBJECT"
    target.material_slots[3].material = bpy.data.materials["skin"]
    assert bpy.ops.paradesc.remove_material() == {"FINISHED"}
    slots, _ = slots_and_faces(target)
    assert slots == [("DATA", "skin"), ("OBJECT", "skin"), ("OBJECT", "skin")]


def other_way(target):
    click("make_material", kind="flat")(target)


@pytest.mark.parametrize("between", [lambda _target: None, other_way])
def test_removing_our_material_keeps_what_faces_were_given_since(between, target):
    bake(target)
    materials(target)
    click("make_material")(target)
    target.data.polygons[0].material_index = 1
    between(target)
    bpy.ops.paradesc.remove_material()
    found = [face.material_index for face in target.data.polygons]
    assert found == [1, *(number % 2 for number in range(1, len(found)))]


def test_removing_our_material_finds_slots_that_were_moved(target):
    bake(target)
    materials(target)
    target.material_slots[1].link = "DATA"
    _, before = slots_and_faces(target)
    click("make_material")(target)
    target.active_material_index = 1
    bpy.ops.object.material_slot_move(direction="UP")
    bpy.ops.paradesc.remove_material()
    _, after = slots_and_faces(target)
    assert after == before


def test_a_material_of_ours_that_was_tuned_stays_and_is_saved(target):
    bake(target)
    tuned_material(target)
    target.data.materials[0].name = "mine"
    bpy.ops.paradesc.remove_material()
    assert bpy.data.materials["mine"].use_fake_user
    assert len(target.data.materials) == 0


def test_the_base_color_that_was_set_on_the_cavity_group_comes_back(target):
    bake(target)
    materials(target)
    material = target.data.materials[0]
    target.active_material_index = 0
    bpy.ops.paradesc.plug_cavity()
    node = next(node for node in material.node_tree.nodes if node.type == "GROUP")
    node.inputs["Base Color"].default_value = (0.25, 0.5, 0.75, 1.0)
    bpy.ops.paradesc.remove_material()
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    assert tuple(shader.inputs["Base Color"].default_value) == (0.25, 0.5, 0.75, 1.0)


def test_buttons_are_grey_where_all_was_deleted(target):
    bake(target)
    for name in (NAME, "cavity"):
        gone(target.data, name)
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.corner_colors()


def test_ours_stays_ours_when_the_mesh_is_edited(target):
    bake(target)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    names = target.data.attributes.keys()
    bake(target)
    assert target.data.attributes.keys() == names


def test_a_file_saved_under_another_name_goes_on_with_its_textures(target, folder):
    bake_image(target)
    path = Path(bpy.data.filepath)
    bpy.ops.wm.save_as_mainfile(filepath=str(path.with_name("file_v2.blend")), check_existing=False)
    bake_image(target)
    assert [one.name for one in folder.glob("*.png")] == ["sphere_curvature.png"]


def test_the_sentence_says_which_texture_stays(target, folder, capfd):
    file("sphere_curvature.png")(target)
    bake_image(target)
    said = capfd.readouterr().out
    assert 'the texture is "sphere_2_curvature"' in said
    assert "sphere_2_curvature.png, 16 × 16" in said


@pytest.fixture
def presets_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(preset_folders, "own_folder", lambda create=False: tmp_path)
    return tmp_path


@pytest.mark.parametrize("other", ["Mine.json", "mine.JSON"])
def test_a_preset_is_saved_beside_files_that_are_none_of_that_name(other, presets_folder):
    (presets_folder / other).write_text("a list of things to do")
    assert bpy.ops.paradesc.add_preset(name="Mine") == {"FINISHED"}
    bpy.ops.paradesc.add_preset(name="mine")
    assert (presets_folder / other).read_text() == "a list of things to do"
    assert len(list(presets_folder.iterdir())) == 3
    bpy.ops.paradesc.add_preset(name="Mine")
    assert len(list(presets_folder.iterdir())) == 3


class Screen(dict):
    """A screen with two 3D viewports between others."""

    def __init__(self):
        self.areas = [self.area("VIEW_3D", "MATERIAL"), self.area("CONSOLE"), self.area("VIEW_3D", "RANDOM")]
        self.areas.append(self.area("VIEW_3D", "VERTEX"))

    def area(self, kind, color_type=""):
        items = [SimpleNamespace(identifier=name) for name in ("MATERIAL", "RANDOM", "SINGLE", "VERTEX")]
        rna = SimpleNamespace(properties={"color_type": SimpleNamespace(enum_items=items)})
        shading = SimpleNamespace(type="SOLID", color_type=color_type, bl_rna=rna)
        return SimpleNamespace(type=kind, spaces=SimpleNamespace(active=SimpleNamespace(shading=shading)))

    def shown(self):
        return [area.spaces.active.shading.color_type for area in self.areas if area.type == "VIEW_3D"]


def test_every_viewport_gets_back_what_it_showed():
    screen = Screen()
    for _ in range(2):  # two bakes
        for _, shading in viewports.shadings(screen):
            viewports.show_attributes(screen, shading)
    assert screen.shown() == ["VERTEX"] * 3
    viewports.restore(screen)
    assert screen.shown() == ["MATERIAL", "RANDOM", "VERTEX"]


def test_a_viewport_that_was_set_since_stays_and_old_files_are_read():
    screen = Screen()
    for _, shading in viewports.shadings(screen):
        viewports.show_attributes(screen, shading)
    screen.areas[0].spaces.active.shading.color_type = "SINGLE"
    viewports.restore(screen)
    assert screen.shown() == ["SINGLE", "RANDOM", "VERTEX"]
    screen[viewports.FORMER] = "MATERIAL"
    viewports.restore(screen)
    assert screen.shown() == ["SINGLE", "RANDOM", "MATERIAL"]


def test_a_mark_says_whose_a_file_is_until_anything_in_it_changes(target, folder):
    bake_image(target)
    content = (folder / "sphere_curvature.png").read_bytes()
    assert marks.owner_of(content) == {"blend": "file.blend", "object": "sphere"}
    place = content.index(b"IDAT") + 20
    assert marks.owner_of(content[:place] + b"\0\1" + content[place + 2 :]) is None
    assert marks.owner_of(content + b"more") is None
    assert marks.owner_of(content[:-3]) is None
    again = marks.marked(content, {"blend": "b", "object": "Würfel"})
    assert marks.owner_of(again) == {"blend": "b", "object": "Würfel"}
    assert again.count(b"tEXtParadesc") == 1
    for odd in (b"", b"\x89PNG\r\n\x1a\n", b"\x89PNG\r\n\x1a\n" + b"\xff" * 40, b"GIF89a"):
        assert marks.owner_of(odd) is None


def test_names_that_some_file_system_takes_for_one_are_kept_apart():
    names = ["Wall_001", "wall_001", "Tür", unicodedata.normalize("NFD", "Tür"), "x" * 300, "x" * 301]
    found = file_names.distinct(names)
    assert len({unicodedata.normalize("NFC", name).casefold() for name in found}) == len(names)
    assert found[0] == "Wall_001"
    assert max(len(name.encode()) for name in found) < 200
    assert file_names.distinct(names) == found


def test_the_same_object_has_the_same_word_in_whatever_selection():
    for name in ("Wall 001", "Wall.001", "wall_001"):
        add_sphere(name, steps=1)
    whole = dict(zip(("Wall.001", "Wall 001"), pieces.file_words(["Wall.001", "Wall 001"]), strict=True))
    assert pieces.file_words(["Wall 001"]) == [whole["Wall 001"]]
    assert pieces.file_words(["Wall 001", "Wall.001"]) == [whole["Wall 001"], whole["Wall.001"]]


def test_frames_of_objects_that_differ_in_case_have_folders_apart(tmp_path):
    assert cache.object_folder(tmp_path, "Crate").name == "Crate"
    assert cache.object_folder(tmp_path, "crate", [tmp_path / "Crate"]).name.startswith("crate_")
    (tmp_path / "Crate").mkdir()
    assert cache.object_folder(tmp_path, "Crate").name == "Crate"
    assert cache.object_folder(tmp_path, "crate").name.startswith("crate_")
    for name in ("con", "AUX", "nul", "com1"):
        assert cache.object_folder(tmp_path, name).name.startswith(f"{name}_")


def test_the_sentence_says_what_stays_and_where_the_values_are(target):
    attribute(NAME)(target)
    (sentence,) = mesh_io.write_results(target, made_up_results(target))
    assert f'"{NAME}" is there' in sentence
    assert f'"{NAME}_2"' in sentence
