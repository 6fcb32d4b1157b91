"""Builds the same node trees in Blender 3.4 and later versions, which differ in the interfaces of groups."""

import bpy

SOCKETS = {"float": "NodeSocketFloat", "geometry": "NodeSocketGeometry"}
# The custom property that says what a node group or material of ours is, whatever its name.
MARK = "paradesc_kind"


def new_group(kind: str, name: str) -> bpy.types.NodeTree:
    """A new, empty group of a tree type such as "ShaderNodeTree"."""
    group = bpy.data.node_groups.new(name, kind)
    group[MARK] = name
    return group


def linked(material: bpy.types.Material) -> str:
    """One sentence about why the nodes of a material cannot be changed in this file, or ""."""
    if material.library is None and material.override_library is None:
        return ""
    return f'The material "{material.name}" is linked from another file; make it local first.'


def nodes_of_ours(tree: bpy.types.NodeTree | None) -> list[bpy.types.Node]:
    """The nodes in a tree that use one of our groups."""
    nodes = [] if tree is None else tree.nodes
    return [node for node in nodes if getattr(node, "node_tree", None) is not None and MARK in node.node_tree]


def add_socket(group: bpy.types.NodeTree, name: str, kind: str, *, output: bool = False) -> None:
    """Adds an input or output to a group."""
    if hasattr(group, "interface"):
        group.interface.new_socket(name=name, in_out="OUTPUT" if output else "INPUT", socket_type=SOCKETS[kind])
    else:
        (group.outputs if output else group.inputs).new(SOCKETS[kind], name)


def input_of(group: bpy.types.NodeTree, name: str) -> object:
    """The interface item of a group's input, which holds the default value."""
    if hasattr(group, "interface"):
        inputs = [item for item in group.interface.items_tree if getattr(item, "in_out", "") == "INPUT"]
    else:
        inputs = group.inputs
    return next(item for item in inputs if item.name == name)


def add_node(tree: bpy.types.NodeTree, kind: str, place: tuple[float, float], **members: object) -> bpy.types.Node:
    """Adds a node and sets its members."""
    node = tree.nodes.new(kind)
    node.location = place
    for name, value in members.items():
        setattr(node, name, value)
    return node


def add_modifier(target: bpy.types.Object, tree: bpy.types.NodeTree, name: str) -> bpy.types.NodesModifier:
    """Adds a modifier with this group of geometry nodes at the end of the stack."""
    modifier = target.modifiers.new(name, "NODES")
    made = modifier.node_group  # Blender 3.4 makes one of its own
    modifier.node_group = tree
    if made is not None and made.users == 0:
        bpy.data.node_groups.remove(made)
    return modifier
