"""Builds the same node trees in Blender 3.4 and later, whose interfaces of groups differ."""

import bpy

SOCKETS = {"color": "NodeSocketColor", "float": "NodeSocketFloat", "geometry": "NodeSocketGeometry"}
# The custom property of our node groups and materials that says what they are, whatever their name.
MARK = "paradesc_kind"


def new_group(kind: str, name: str) -> bpy.types.NodeTree:
    """An empty group of a tree type such as "ShaderNodeTree"."""
    group = bpy.data.node_groups.new(name, kind)
    group[MARK] = name
    return group


def found_group(kind: str, name: str) -> bpy.types.NodeTree | None:
    """Our group that was made under this name earlier, if it is still there and local."""
    for group in bpy.data.node_groups:
        if group.bl_idname == kind and group.get(MARK) == name and group.library is None:
            return group
    return None


def add_socket(
    group: bpy.types.NodeTree, name: str, kind: str, default: object = None, *, output: bool = False
) -> None:
    """Adds an input or output to a group; a float's default comes with its bounds: (default, minimum, maximum)."""
    if hasattr(group, "interface"):
        side = "OUTPUT" if output else "INPUT"
        socket = group.interface.new_socket(name=name, in_out=side, socket_type=SOCKETS[kind])
    else:
        socket = (group.outputs if output else group.inputs).new(SOCKETS[kind], name)
    if kind == "float" and default is not None:
        socket.default_value, socket.min_value, socket.max_value = default
    elif default is not None:
        socket.default_value = default


def add_node(tree: bpy.types.NodeTree, kind: str, place: tuple[float, float], **members: object) -> bpy.types.Node:
    """Adds a node and sets its members."""
    node = tree.nodes.new(kind)
    node.location = place
    for name, value in members.items():
        setattr(node, name, value)
    return node


def add_math(
    tree: bpy.types.NodeTree, kind: str, operation: str, place: tuple[float, float], *inputs: object
) -> bpy.types.NodeSocket:
    """Adds a math node for numbers and sockets; gives its result."""
    node = add_node(tree, kind, place, operation=operation)
    for index, value in enumerate(inputs):
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, node.inputs[index])
        else:
            node.inputs[index].default_value = value
    return node.outputs[0]


def add_map_range(
    tree: bpy.types.NodeTree,
    place: tuple[float, float],
    value: bpy.types.NodeSocket,
    *ends: bpy.types.NodeSocket,
    label: str = "",
) -> bpy.types.NodeSocket:
    """Adds a node that maps the value from between the two ends to between 0 and 1; gives the result."""
    node = add_node(tree, "ShaderNodeMapRange", place, clamp=True, label=label)
    for socket, name in zip((value, *ends), ("Value", "From Min", "From Max"), strict=True):
        tree.links.new(socket, node.inputs[name])
    return node.outputs["Result"]


def add_mix(
    tree: bpy.types.NodeTree,
    place: tuple[float, float],
    factor: bpy.types.NodeSocket,
    first: bpy.types.NodeSocket,
    second: bpy.types.NodeSocket,
) -> bpy.types.NodeSocket:
    """Adds a mix of two colors; gives the result."""
    node = add_node(tree, "ShaderNodeMix", place, data_type="RGBA")
    ends = [socket for socket in node.inputs if socket.type == "RGBA"]
    for start, end in ((factor, node.inputs[0]), (first, ends[0]), (second, ends[1])):
        tree.links.new(start, end)
    return next(socket for socket in node.outputs if socket.type == "RGBA")


def add_modifier(target: bpy.types.Object, tree: bpy.types.NodeTree, name: str) -> bpy.types.NodesModifier:
    """Adds a modifier with this group of geometry nodes at the end of the stack."""
    modifier = target.modifiers.new(name, "NODES")
    made = modifier.node_group  # Blender 3.4 makes one of its own
    modifier.node_group = tree
    if made is not None and made.users == 0:
        bpy.data.node_groups.remove(made)
    return modifier
