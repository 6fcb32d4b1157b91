"""Adds textures to a material: labelled nodes in a frame, linked to those inputs of our groups that take masks."""

from dataclasses import dataclass

import bpy

from paradesc.bridge import InputError
from paradesc.core import legend

from . import node_groups
from .images import MARK, OBJECT

FRAME = "Paradesc"
# The custom properties of our nodes. Those on image nodes say whose mask the node holds, and which image it had.
OWN, LEFT = "paradesc_node", "paradesc_node_left"
# The custom property of our nodes that give a mask from vertex values.
OF_VERTICES = "paradesc_mask_of"
# The inputs of our groups that take a mask, and their descriptors.
TAKEN = {"Cavity": "cavity", "Edges": "convexity", "Edge Wear": "convexity"}
CHANNELS = ("Red", "Green", "Blue")
# Nodes stand so far from each other, in the node editor's units.
NODE_WIDTH, NODE_HEIGHT = 300.0, 320.0


@dataclass
class Texture:
    """An image of one descriptor, or of several in its channels."""

    image: bpy.types.Image
    holds: tuple[str, ...]  # the names of the values
    uv_map: str = ""  # the UV map it lies over; "": the one that renders use
    repeats: bool = False  # whether the UV map reaches beyond the image

    @property
    def key(self) -> str:
        """The object and values of the texture, by which a node of an earlier bake is found."""
        return f"{self.image.get(OBJECT, '')}: {', '.join(self.holds)}"

    @property
    def label(self) -> str:
        """The names of the values, in words."""
        return ", ".join(legend.label(name) for name in self.holds)


def fault(target: bpy.types.Object) -> str:
    """One sentence about why the object's active material cannot get textures, or ""."""
    if target.active_material is not None:
        return node_groups.linked(target.active_material)
    if target.data.library is not None or target.data.override_library is not None:
        return f'The mesh "{target.data.name}" is linked and has no material; make it local first.'
    return ""


def add_to_material(target: bpy.types.Object, textures: list[Texture], active: int = 0) -> bpy.types.Material:
    """Adds textures to the object's active material. An object without a material gets one that shows the texture."""
    if fault(target):
        raise InputError(fault(target))
    material = target.active_material
    if material is None:
        material = target.active_material = bpy.data.materials.new(target.name)
        material[MARK] = target.name
    if material.node_tree is None:  # never since Blender 5
        material.use_nodes = True
    tree = material.node_tree
    nodes = [image_node(tree, texture) for texture in textures]
    for node, texture in zip(nodes, textures, strict=True):
        link_masks(tree, node, texture)
    for node in tree.nodes:
        node.select = node in nodes
    tree.nodes.active = nodes[active]
    if material.get(MARK):
        show(tree, nodes[active])
    return material


def show(tree: bpy.types.NodeTree, node: bpy.types.Node) -> None:
    """Links the image to the base color of the material's shader, unless something else is linked there."""
    shader = next((item for item in tree.nodes if item.type == "BSDF_PRINCIPLED"), None)
    if shader is not None and not shader.inputs["Base Color"].is_linked:
        tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])


# ---- Nodes


def image_node(tree: bpy.types.NodeTree, texture: Texture) -> bpy.types.Node:
    """The node with this image: an existing one, else our unchanged node of the same mask, else a new one."""
    found = [node for node in tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    node = next((node for node in found if node.image == texture.image), None)
    if node is not None:
        return node
    node = next((node for node in found if node.get(OWN) == texture.key and is_as_left(node)), None)
    if node is None:
        node = add(tree, "ShaderNodeTexImage", texture.label, 1)
        node.extension = "REPEAT" if texture.repeats else "EXTEND"  # or a border takes from the opposite one
        if texture.uv_map:
            own = add(tree, "ShaderNodeUVMap", texture.uv_map, 0, beside=node)
            own.uv_map = texture.uv_map
            tree.links.new(own.outputs["UV"], node.inputs["Vector"])
    node.image, node[OWN], node[LEFT] = texture.image, texture.key, texture.image.name
    return node


def is_as_left(node: bpy.types.Node) -> bool:
    """Returns whether our node still has the image that we gave it, or none because that image is gone."""
    return node.image is None or node.image.name == node.get(LEFT)


def add(
    tree: bpy.types.NodeTree, kind: str, label: str, column: int, beside: bpy.types.Node | None = None
) -> bpy.types.Node:
    """Adds a node in a column of our frame, below the existing ones or beside one of them."""
    frame = next((node for node in tree.nodes if node.type == "FRAME" and OWN in node), None)
    rows = [place_of(node) for node in tree.nodes if frame is not None and node.parent == frame]
    if rows:
        left, lowest = min(x for x, _ in rows), min(y for _, y in rows) - NODE_HEIGHT
    else:
        left, lowest = min((place_of(node)[0] for node in tree.nodes), default=0.0) - 3 * NODE_WIDTH, NODE_HEIGHT
    if frame is None:
        frame = tree.nodes.new("NodeFrame")
        frame.label, frame[OWN] = FRAME, "frame"
    if beside is not None:
        x, lowest = place_of(beside)
        place = x + (column - 1) * NODE_WIDTH, lowest
    else:
        place = left, lowest
    node = tree.nodes.new(kind)
    node.location, node.label, node[OWN] = place, label, label
    node.parent = frame
    return node


def place_of(node: bpy.types.Node) -> tuple[float, float]:
    """The location of a node in its tree. A node in a frame stores its location relative to the frame."""
    x, y = node.location
    while node.parent is not None:
        node = node.parent
        x, y = x + node.location.x, y + node.location.y
    return x, y


# ---- Links


def link_masks(tree: bpy.types.NodeTree, node: bpy.types.Node, texture: Texture) -> None:
    """Links a texture's masks to inputs of our groups that have no link, or only a mask from vertices."""
    inputs = [
        (socket, TAKEN[socket.name])
        for group in node_groups.nodes_of_ours(tree)
        for socket in group.inputs
        if TAKEN.get(socket.name) in texture.holds
    ]
    outputs = outputs_of(tree, node, texture) if inputs else {}
    for socket, name in inputs:
        former = socket.links[0].from_node if socket.is_linked else None
        if former is None or OF_VERTICES in former:
            tree.links.new(outputs[name], socket)
            if former is not None and not any(output.is_linked for output in former.outputs):
                tree.nodes.remove(former)


def outputs_of(tree: bpy.types.NodeTree, node: bpy.types.Node, texture: Texture) -> dict[str, bpy.types.NodeSocket]:
    """The output for each value of a texture. With several values, the channels are separated by a node."""
    if len(texture.holds) == 1:
        return {texture.holds[0]: node.outputs["Color"]}
    after = [link.to_node for link in node.outputs["Color"].links]
    apart = next((one for one in after if one.bl_idname == "ShaderNodeSeparateColor"), None)
    if apart is None:
        apart = add(tree, "ShaderNodeSeparateColor", texture.label, 2, beside=node)
        tree.links.new(node.outputs["Color"], apart.inputs[0])
    return {name: apart.outputs[channel] for name, channel in zip(texture.holds, CHANNELS, strict=True)}
