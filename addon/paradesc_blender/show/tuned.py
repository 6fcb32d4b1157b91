"""Detects changes of a material or node group since we made it, by a fingerprint in a custom property."""

import hashlib

import bpy

PROPERTY = "paradesc_left"
# The members of nodes that we set. The others are either fixed by the node's type or concern its layout.
OF_NODE = ("name", "label", "mute", "attribute_name", "operation", "data_type", "domain", "blend_type", "clamp", "mode")
OF_NODE += ("use_clamp", "clamp_factor", "clamp_result", "interpolation_type", "distribution", "subsurface_method")
# The members of a material in its panel, besides its nodes. Blender itself changes some of the others.
OF_MATERIAL = ("name", "diffuse_color", "metallic", "roughness", "blend_method", "use_backface_culling", "pass_index")


def leave(block: bpy.types.Material | bpy.types.NodeTree) -> None:
    """Stores the fingerprint of a material or node group that was just made."""
    block[PROPERTY] = fingerprint(block)


def is_as_left(block: bpy.types.Material | bpy.types.NodeTree) -> bool:
    """Returns whether a material or node group has neither been renamed nor changed since it was made."""
    return block.get(PROPERTY) == fingerprint(block)


def fingerprint(block: bpy.types.Material | bpy.types.NodeTree) -> str:
    """A fingerprint of a material or node group. It leaves out a group's name, to which Blender may append numbers."""
    if isinstance(block, bpy.types.NodeTree):
        content = contents(block)
    else:
        own = [plain(getattr(block, name)) for name in OF_MATERIAL if hasattr(block, name)]
        content = [own, contents(block.node_tree) if block.node_tree is not None else []]
    return hashlib.sha256(repr(content).encode()).hexdigest()[:32]


def contents(tree: bpy.types.NodeTree) -> list[object]:
    """The nodes with their settings, the links, and the sockets of a node tree."""
    nodes = []
    for node in tree.nodes:  # named members, because Blender 3.4 may crash after its lists of members were read
        group, ramp = getattr(node, "node_tree", None), getattr(node, "color_ramp", None)
        own = [(name, getattr(node, name)) for name in OF_NODE if hasattr(node, name)]
        stops = [] if ramp is None else [(stop.position, tuple(stop.color)) for stop in ramp.elements]
        members = [node.bl_idname, own, None if group is None else group.name]
        nodes.append([members, [value_of(socket) for socket in node.inputs], stops])
    links = [
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    ]
    sockets = tree.interface.items_tree if hasattr(tree, "interface") else [*tree.inputs, *tree.outputs]
    return [nodes, sorted(links), [(item.name, value_of(item)) for item in sockets]]


def value_of(socket: bpy.types.NodeSocket) -> object:
    """The default value of a socket; None for those of geometry and shaders."""
    return plain(getattr(socket, "default_value", None))


def plain(value: object) -> object:
    """The value in a form whose representation is the same in every session."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return value.name if isinstance(value, bpy.types.ID) else tuple(value)
