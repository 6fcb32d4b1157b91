"""Tells whether a material or node group is as we left it, by a fingerprint in a custom property: else it is tuned."""

import hashlib

import bpy

PROPERTY = "paradesc_left"
# The members that we set on nodes that we make. Other kinds tell by being there; the rest is how they are laid out.
OF_NODE = ("name", "label", "mute", "attribute_name", "operation", "data_type", "domain", "blend_type", "clamp", "mode")
OF_NODE += ("use_clamp", "clamp_factor", "clamp_result", "interpolation_type", "distribution", "subsurface_method")
# The members of a material that its panel sets beside its nodes; others change as Blender goes on.
OF_MATERIAL = ("name", "diffuse_color", "metallic", "roughness", "blend_method", "use_backface_culling", "pass_index")


def leave(block: bpy.types.Material | bpy.types.NodeTree) -> None:
    """Keeps the fingerprint of what has just been made."""
    block[PROPERTY] = fingerprint(block)


def is_as_left(block: bpy.types.Material | bpy.types.NodeTree) -> bool:
    """Whether nobody has renamed or changed it since."""
    return block.get(PROPERTY) == fingerprint(block)


def fingerprint(block: bpy.types.Material | bpy.types.NodeTree) -> str:
    """A name for what a material or node group does; a group's own name, which gets numbers, is left out."""
    if isinstance(block, bpy.types.NodeTree):
        content = contents(block)
    else:
        own = [plain(getattr(block, name)) for name in OF_MATERIAL if hasattr(block, name)]
        content = [own, contents(block.node_tree) if block.node_tree is not None else []]
    return hashlib.sha256(repr(content).encode()).hexdigest()[:32]


def contents(tree: bpy.types.NodeTree) -> list[object]:
    """The nodes with their settings, the links, and the sockets of a group."""
    nodes = [[members(node), [value_of(socket) for socket in node.inputs], ramp(node)] for node in tree.nodes]
    links = [
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    ]
    if hasattr(tree, "interface"):
        sockets = list(tree.interface.items_tree)
    else:
        sockets = [*tree.inputs, *tree.outputs]
    return [nodes, sorted(links), [(item.name, value_of(item)) for item in sockets]]


def members(node: bpy.types.Node) -> list[object]:
    """What a node is set to. They are named, because Blender 3.4 may crash after its lists of members were read."""
    group = getattr(node, "node_tree", None)
    own = [(name, getattr(node, name)) for name in OF_NODE if hasattr(node, name)]
    return [node.bl_idname, own, None if group is None else group.name]


def value_of(socket: bpy.types.NodeSocket) -> object:
    """The value of a socket to which nothing is linked; None for those of geometry and shaders."""
    return plain(getattr(socket, "default_value", None))


def ramp(node: bpy.types.Node) -> list[tuple[float, tuple[float, ...]]]:
    """The stops of a node's color ramp."""
    found = getattr(node, "color_ramp", None)
    return [(stop.position, tuple(stop.color)) for stop in found.elements] if found is not None else []


def plain(value: object) -> object:
    """The value as something whose representation is the same from session to session."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return value.name if isinstance(value, bpy.types.ID) else tuple(value)
