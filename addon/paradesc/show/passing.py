"""Puts a node between inputs of a material's shader and what they had before, and takes it out again."""

from collections.abc import Iterator

import bpy

from ..scene.node_groups import MARK

# The values that go through a node: names of the shader's inputs, and of the node's inputs, with those of its outputs.
Passed = dict[str, str]


def base_shader(material: bpy.types.Material | None) -> bpy.types.Node | None:
    """The Principled BSDF that a material shows, the one nearest to its output."""
    tree = None if material is None else material.node_tree
    output = None if tree is None else tree.get_output_node("ALL")
    return None if output is None else next((node for node in upstream(output) if is_shader(node)), None)


def is_shader(node: bpy.types.Node) -> bool:
    """Whether it has the colors of a surface as its inputs."""
    return node.type == "BSDF_PRINCIPLED"


def upstream(node: bpy.types.Node) -> Iterator[bpy.types.Node]:
    """The node and all that it takes something from, the nearest first."""
    found = [node]
    for one in found:
        yield one
        before = [link.from_node for socket in one.inputs for link in socket.links]
        found += [other for other in before if other not in found]


def own_nodes(tree: bpy.types.NodeTree | None, mark: str) -> list[bpy.types.Node]:
    """The nodes of our groups whose mark begins so, connected or not."""
    groups = [(node, getattr(node, "node_tree", None)) for node in (tree.nodes if tree is not None else ())]
    return [node for node, group in groups if group is not None and str(group.get(MARK, "")).startswith(mark)]


def passes(node: bpy.types.Node, passed: Passed) -> bool:
    """Whether the inputs that it stands before take something of it, be it by way of another node of ours."""
    return any(
        link.to_socket.name == name for name, output in there(node, passed) for link in node.outputs[output].links
    )


def there(node: bpy.types.Node, passed: Passed) -> list[tuple[str, str]]:
    """The values that a node still lets through; somebody may have taken sockets from its group."""
    return [(name, output) for name, output in passed.items() if name in node.inputs and output in node.outputs]


def put(shader: bpy.types.Node, node: bpy.types.Node, passed: Passed) -> None:
    """Lets what the shader's inputs have go through the node; those that come from it already stay."""
    for name, output in there(node, passed):
        socket = shader.inputs[name]
        if not (socket.links and socket.links[0].from_node == node):
            bring(socket, node.inputs[name])
            node.id_data.links.new(node.outputs[output], socket)


def take_out(node: bpy.types.Node, passed: Passed) -> None:
    """Gives whatever takes something through the node what it had before; the node stays, without these links."""
    for name, output in there(node, passed):
        for link in list(node.outputs[output].links):
            socket = link.to_socket
            node.id_data.links.remove(link)
            bring(node.inputs[name], socket)


def bring(source: bpy.types.NodeSocket, socket: bpy.types.NodeSocket) -> None:
    """Gives a socket the value and the link that another has; Blender 3.4 does not count muted ones as linked."""
    links = source.id_data.links
    socket.default_value = source.default_value
    for link in list(socket.links):
        links.remove(link)
    for link in source.links:
        links.new(link.from_socket, socket).is_muted = link.is_muted
