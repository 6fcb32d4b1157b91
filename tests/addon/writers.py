"""All that writes something, what users have made before where it would write, and all that there is to be changed."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mesh_io_test import made_up_results

from paradesc_blender.scene import carrying, delivery, sculpt_masks
from scene import add_sphere, select, small_bake

NAME = "mean_curvature"
MEMBERS = {"FLOAT": ("value", 1), "INT": ("value", 1), "FLOAT_VECTOR": ("vector", 3)}
MEMBERS |= {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4)}


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
    delivery.deliver(target, made_up_results(target, (NAME, "cavity")))


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
    select(target)
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


def others(write, called, *names):
    """Gives the object a name, and does the same with other objects of these names, one after another."""

    def make(target):
        target.name = called
        for name in names:
            write(add_sphere(name, steps=3))

    return make


def bake_from_elsewhere(target):
    """Bakes a texture from another .blend in the same folder, whose object has the same name."""
    bake_image(target)
    path = Path(bpy.data.filepath)
    bpy.data.images.remove(image_of("sphere_curvature.png"))
    bpy.ops.wm.save_as_mainfile(filepath=str(path.with_name("other.blend")), check_existing=False)
    target.data.vertices[0].co *= 2.0


def in_unsaved_file(write):
    """In a file that is not saved, Blender packs images."""

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
    select(target)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}


def carrying_group(target):
    """The nodes that carry the values of what modifiers make."""
    return target.modifiers[-1].node_group


def remeshed_and(change):
    """The user's change of these nodes."""

    def make(target):
        remeshed(target)
        change(carrying_group(target))

    return make


def muted(group):
    group.nodes["Switch"].mute = True


def with_a_node(group):
    group.nodes.new("GeometryNodeSetPosition")


def of_an_own_object(group):
    group.nodes[carrying.CARRIER].inputs["Object"].default_value = add_sphere("mine", steps=2)


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
    select(target)
    scene.paradesc_animation.overwrite = True
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    target.paradesc_live.mode = "CACHE"
    assert target.paradesc_live.sentence == ""
    target.paradesc_live.mode = "OFF"


CHANGES = (muted, with_a_node, of_an_own_object)
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
        click("sculpt_mask"), sculpt_mask, "allow replacing it", again=click("sculpt_mask", replace=True)
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
    "image of another object": Writer(bake_image, others(bake_image, "Wall.001", "Wall 001")),
    "image of two other objects": Writer(bake_image, others(bake_image, "Wall.001", "Wall 001", "wall_001")),
    "image of another .blend": Writer(bake_image, bake_from_elsewhere),
    "packed image": Writer(bake_image_here, in_unsaved_file(packed_and_painted)),
    "packed image of another object": Writer(
        lambda _target: bake_image(bpy.data.objects["Wall.001"]),
        in_unsaved_file(others(bake_image, "Wall.001", "Wall 001")),
    ),
    **{f"carried values, {change.__name__}": Writer(remeshed, remeshed_and(change)) for change in CHANGES},
    "carried values of a long name": Writer(remeshed, long_name),
    "live values": Writer(live, attribute(NAME)),
    "live values over what was painted": Writer(live, painted(f"{NAME}_color"), changes={"coverage"}),
    "values painted over after live ones": Writer(bake, painted(f"{NAME}_color", live), changes={"coverage"}),
    "live coverage": Writer(live, attribute("coverage")),
    "played values": Writer(frames, attribute(NAME)),
    "frames of another object": Writer(frames, others(frames, "Crate", "crate", "Cr ate")),
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
