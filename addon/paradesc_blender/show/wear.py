"""Inserts dirt and worn edges, by the masks of a bake, between a material's colors and its shader, and removes them.

Colors and levels of looks are not in this file: they are inputs of the group and of the materials in the assets.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import bpy
from mathutils import Vector

from paradesc.bridge import InputError

from ..scene import large_faces, record
from ..scene.image_nodes import OF_VERTICES, OWN, is_as_left
from ..scene.node_groups import MARK, add_node, linked
from . import slots, tuned
from .assets import append, shared_group
from .passing import base_shader, own_nodes, passes, put, take_out, upstream

GROUP = "Paradesc Wear"
PASSED = {"Base Color": "Color", "Roughness": "Roughness", "Metallic": "Metallic"}
# The group's inputs for masks, and their descriptors.
MASKS = {"Cavity": "cavity", "Edges": "convexity"}
# The group's inputs that depend on the material and the object. All others define the look.
GIVEN = {*PASSED, *MASKS, "Proportions"}
AS_IS = "AS_IS"
# The materials in the assets, by look.
LOOKS = {"PAINTED_METAL": "Painted Metal", "OLD_STONE": "Old Stone", "DUSTY_PLASTIC": "Dusty Plastic"}
# The diagonal of objects for which the lengths in those materials were chosen.
DIAGONAL = 2 * 3**0.5
# The custom property of the group's nodes with the values to which we set their inputs.
LEFT = tuned.PROPERTY
# The custom property of a mesh that had no material slot before it got one for a look.
OWN_SLOT = "paradesc_wear_slot"
# The custom property of a material that did not use nodes before, with the names of the nodes that it had all the same.
FORMER_NODES = "paradesc_nodes"

Values = dict[str, float | list[float]]


# ---- Looks


def values_of(node: bpy.types.Node) -> Values:
    """The inputs of a node of the group that define the look."""
    found = {socket.name: tuned.plain(socket.default_value) for socket in node.inputs if socket.name not in GIVEN}
    return {name: list(value) if isinstance(value, tuple) else value for name, value in found.items()}


def look_values(tree: bpy.types.NodeTree, look: str) -> Values:
    """The input values of a look: the group's defaults, or those in the material of the assets."""
    if look == AS_IS:
        fresh = add_node(tree, "ShaderNodeGroup", (0, 0), node_tree=shared_group(GROUP))
        found = values_of(fresh)
        tree.nodes.remove(fresh)
        return found
    material = append("materials", LOOKS[look])
    found = values_of(own_nodes(material.node_tree, GROUP)[0])
    bpy.data.materials.remove(material)
    return found


def left_values(node: bpy.types.Node) -> Values:
    """The values to which we set the inputs; empty if somebody else added the node."""
    return record.kept(node, LEFT)


def tuned_inputs(node: bpy.types.Node) -> list[str]:
    """The inputs that somebody has changed since we set them."""
    left = left_values(node)
    return [name for name, value in values_of(node).items() if value != left.get(name, value)]


def dress(node: bpy.types.Node, values: Values) -> None:
    """Sets the inputs that nobody has tuned, and remembers their values."""
    kept = tuned_inputs(node)
    for name, value in values.items():
        if name in node.inputs and name not in kept:
            node.inputs[name].default_value = value
    now, left = values_of(node), left_values(node)
    node[LEFT] = {name: left[name] if name in kept else value for name, value in now.items()}


# ---- Adding


def fault(target: bpy.types.Object) -> str:
    """One sentence about why the object's active material cannot get wear, or ""."""
    material = target.active_material
    if material is None:
        return ""
    if linked(material):
        return linked(material)
    if slots.DESCRIPTOR in material:
        return f'The material "{material.name}" shows values; choose one of your own.'
    if material.node_tree is not None and base_shader(material) is None:
        return f'The material "{material.name}" has no Principled BSDF in use, and wear needs one.'
    return ""


def needs_image(target: bpy.types.Object, source: str) -> bool:
    """Returns whether an object's masks need images: its faces are too large, and no other mesh shares its material.

    An object that cannot get wear needs none, so that others with its mesh get theirs.
    """
    if fault(target):
        return False
    target.update_from_editmode()
    material = target.active_material
    users = [item for item in bpy.data.objects if material in [slot.material for slot in item.material_slots]]
    sharing = [item.data for item in users if material is not None]
    return large_faces.are_too_large(target, source) and all(mesh == target.data for mesh in sharing)


def add(target: bpy.types.Object, look: str = "", of_images: bool = False) -> list[str]:
    """Adds wear to the active material, or gives an object without material one of the looks; returns notes.

    look: one of LOOKS or AS_IS; "" keeps the look of existing wear, and means AS_IS for new wear. of_images: whether
    images of the masks will be linked to it.
    """
    sentence = fault(target)
    if sentence:
        raise InputError(sentence)
    material = target.active_material
    if material is not None and look in LOOKS and is_other_look(material, LOOKS[look]):
        return exchange(target, LOOKS[look], of_images)
    if material is None:
        return [assign(target, LOOKS.get(look, LOOKS["PAINTED_METAL"]), of_images), *notes_on_others(target)]
    if material.node_tree is None or not (bpy.app.version >= (5, 0, 0) or material.use_nodes):  # since 5 all have nodes
        give_nodes(material)
    node, is_new = wear_node(material)
    if is_new:
        fit(material, node, target)
    connect(material, node, {} if of_images else MASKS, target.data)
    if is_new or look:
        dress(node, look_values(material.node_tree, look or AS_IS))
    notes = notes_on_others(target)
    kept = tuned_inputs(node) if look else []
    if kept:
        notes.append(f'The wear of "{material.name}" keeps the values that you tuned: {", ".join(kept)}.')
    return notes


def notes_on_others(target: bpy.types.Object) -> list[str]:
    """A sentence about materials of an object that have no wear yet, if there are any."""
    others = {slot.material for slot in target.material_slots if slot.material and not has_wear(slot.material)}
    if not others:
        return []
    return [
        f'"{target.name}" has materials without wear: {len(others)}. Make the slot of one active to add it there, '
        "too."
    ]


def give_nodes(material: bpy.types.Material) -> None:
    """Makes a material use nodes: those that were switched off, else new ones with the settings of its panel."""
    is_ours = material.node_tree is None or OWN in material.node_tree
    material.use_nodes = True
    if is_ours:
        material.node_tree[OWN] = True
        shader = base_shader(material)
        shader.inputs["Base Color"].default_value = material.diffuse_color
        for name in ("Metallic", "Roughness"):
            shader.inputs[name].default_value = getattr(material, name.lower())
    material[FORMER_NODES] = material.node_tree.nodes.keys()


def wear_node(material: bpy.types.Material) -> tuple[bpy.types.Node, bool]:
    """The group's node in a material, and whether it was just added."""
    found = own_nodes(material.node_tree, GROUP)
    if found:
        return next((node for node in found if passes(node, PASSED)), found[0]), False
    place = free_place(material.node_tree, base_shader(material))
    return add_node(material.node_tree, "ShaderNodeGroup", place, node_tree=shared_group(GROUP), width=220), True


def free_place(tree: bpy.types.NodeTree, shader: bpy.types.Node) -> tuple[float, float]:
    """A free place for a node to the left of a shader; the user's nodes are not moved."""
    left = shader.location.x - 300
    beside = [node.location for node in tree.nodes if -400 < node.location.x - left < 240]
    return left, min([shader.location.y, *(place.y - 360 for place in beside)])


def connect(material: bpy.types.Material, node: bpy.types.Node, masks: dict[str, str], mesh: bpy.types.Mesh) -> None:
    """Links the node to the shader, and vertex masks to those of its inputs that have no link."""
    shader = base_shader(material)
    if not passes(node, PASSED):
        put(shader, node, PASSED)
    for row, (name, descriptor) in enumerate(masks.items()):
        if name in node.inputs and not node.inputs[name].is_linked:
            place = (node.location.x - 240, node.location.y - 120 - 180 * row)
            material.node_tree.links.new(mask_source(material.node_tree, mesh, descriptor, place), node.inputs[name])


def mask_source(
    tree: bpy.types.NodeTree, mesh: bpy.types.Mesh, descriptor: str, place: tuple[float, float]
) -> bpy.types.NodeSocket:
    """The output of a node that gives a mask between 0 and 1, from the grey color attribute of a bake."""
    name = mask_name(mesh, descriptor)
    node = add_node(tree, "ShaderNodeAttribute", place, attribute_name=name, label=name)
    node[OF_VERTICES] = descriptor
    return node.outputs["Color"]


def mask_name(mesh: bpy.types.Mesh, descriptor: str) -> str:
    """The color attribute with a mask of a mesh; it has a number in its name if the usual name was taken."""
    return f"{record.attribute_of(mesh, descriptor)}_color"


def fit(material: bpy.types.Material, node: bpy.types.Node, target: bpy.types.Object) -> None:
    """Adapts noise and bumps to the size of an object."""
    corners = [Vector(corner) for corner in target.bound_box]
    sides = [max(values) - min(values) for values in zip(*corners, strict=True)]
    diagonal = Vector(sides).length
    if diagonal > 0:
        if "Proportions" in node.inputs:
            node.inputs["Proportions"].default_value = [side / diagonal for side in sides]
        if is_look(material):
            for bump in [one for one in material.node_tree.nodes if one.type == "BUMP"]:
                bump.inputs["Distance"].default_value *= diagonal / DIAGONAL


def assign(target: bpy.types.Object, name: str, of_images: bool) -> str:
    """Gives an object without material one of the looks. Objects with vertex masks of the same names share one."""
    local = [item for item in bpy.data.materials if item.library is None]
    ours = [item for item in local if item.get(MARK) == name and tuned.is_as_left(item)]
    masks = {descriptor: mask_name(target.data, descriptor) for descriptor in MASKS.values()}
    material = next((item for item in ours if reads_only(item, masks)), None)
    if material is None or of_images:
        material = append("materials", name)
        material[MARK] = name
        for node in vertex_masks(material):
            node.attribute_name = node.label = masks[node[OF_VERTICES]]
        fit(material, own_nodes(material.node_tree, GROUP)[0], target)
        tuned.leave(material)
    target.data.pop(OWN_SLOT, None)  # left from a slot that somebody has removed
    if not target.material_slots:
        target.data[OWN_SLOT] = True
    target.active_material = material
    return f'"{target.name}" had no active material, and now has "{material.name}".'


def vertex_masks(material: bpy.types.Material) -> list[bpy.types.Node]:
    """The nodes of ours that give a mask from vertex values."""
    return [node for node in material.node_tree.nodes if OF_VERTICES in node]


def reads_only(material: bpy.types.Material, masks: dict[str, str]) -> bool:
    """Returns whether a material has no image, and takes its masks from these attributes, named by descriptor."""
    right = all(node.attribute_name == masks[node[OF_VERTICES]] for node in vertex_masks(material))
    return right and not any(node.type == "TEX_IMAGE" for node in material.node_tree.nodes)


def is_other_look(material: bpy.types.Material, name: str) -> bool:
    """Returns whether a material is another look than this one, and nobody has changed it."""
    return is_look(material) and material[MARK] != name and tuned.is_as_left(material)


def exchange(target: bpy.types.Object, name: str, of_images: bool) -> list[str]:
    """Gives an object another look in place of its own, whose colors would tint the other one; returns no notes."""
    take_away(target, target.active_material_index)
    assign(target, name, of_images)
    return []


def is_look(material: bpy.types.Material) -> bool:
    """Returns whether a material is a look that was given to an object without material."""
    return material.get(MARK) in LOOKS.values()


@contextmanager
def as_left(targets: Iterable[bpy.types.Object]) -> Iterator[None]:
    """Makes unchanged looks of these objects still count as unchanged after our own additions in the body."""
    found = {target.active_material for target in targets if target.active_material is not None}
    ours = [material for material in found if is_look(material) and tuned.is_as_left(material)]
    yield
    for material in ours:
        tuned.leave(material)


# ---- Removing


def has_wear(material: bpy.types.Material | None) -> bool:
    """Returns whether the colors of a material pass through the group."""
    nodes = own_nodes(material.node_tree, GROUP) if material is not None else []
    return any(passes(node, PASSED) for node in nodes)


def remove(target: bpy.types.Object) -> list[str]:
    """Removes wear from all materials of an object, and the looks that it was given; returns notes."""
    notes = []
    for index, slot in reversed(list(enumerate(target.material_slots))):
        material = slot.material
        if not has_wear(material):
            continue
        if linked(material):
            notes.append(f'The material "{material.name}" is linked from another file, so it is kept.')
        elif is_look(material):
            notes += take_away(target, index)
        else:
            notes += take_wear_out(material)
    return notes


def take_away(target: bpy.types.Object, index: int) -> list[str]:
    """Removes a look that an object was given; a material that somebody has tuned is kept."""
    material = target.material_slots[index].material
    if not tuned.is_as_left(material):
        return [f'The material "{material.name}" was changed since it was made, so it is kept.']
    if target.data.pop(OWN_SLOT, False) and len(target.material_slots) == 1:
        target.data.materials.clear()
    else:
        target.material_slots[index].material = None
    if not material.users:
        bpy.data.materials.remove(material)
    return []


def take_wear_out(material: bpy.types.Material) -> list[str]:
    """Removes wear from a material. Tuned wear stays in it, disconnected, until wear is added again."""
    tree = material.node_tree
    (node,) = [one for one in own_nodes(tree, GROUP) if passes(one, PASSED)][:1]
    others = [socket.name for socket in node.outputs if socket.is_linked and socket.name not in PASSED.values()]
    if others:
        return [f'The wear of "{material.name}" stays, because nodes of yours use its output {others[0]}.']
    take_out(node, PASSED)
    if tuned_inputs(node):
        return [f'The wear of "{material.name}" was tuned; it stays in the material, disconnected.']
    ours = [one for one in upstream(node) if OF_VERTICES in one or OWN in one]
    sources = [one for one in ours if OF_VERTICES in one or one.type != "TEX_IMAGE" or is_as_left(one)]
    tree.nodes.remove(node)
    for source in sources:
        if not any(socket.is_linked for socket in source.outputs):
            tree.nodes.remove(source)
    parents = [one.parent for one in tree.nodes]
    for frame in [one for one in tree.nodes if one.type == "FRAME" and OWN in one and one not in parents]:
        tree.nodes.remove(frame)
    if FORMER_NODES in material:
        if set(tree.nodes.keys()) <= set(material[FORMER_NODES]):  # otherwise the user has added nodes
            material.use_nodes = False
        del material[FORMER_NODES]
    return []
