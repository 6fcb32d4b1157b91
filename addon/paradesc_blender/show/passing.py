"""Inserts a node between the inputs of a material's shader and their sources, and removes it again."""

from collections.abc import Iterable, Iterator

import bpy

from ..scene.node_groups import MARK
from ..scene.source_meshes import curves_of

# The values that pass through a node: its output by the name of the input, which is that of the shader's input as well.
Passed = dict[str, str]


def base_shader(material: bpy.types.Material | None) -> bpy.types.Node | None:
    """The Principled BSDF that a material shows, the one nearest to its output."""
    tree = None if material is None else material.node_tree
    output = None if tree is None else tree.get_output_node("ALL")
    return None if output is None else next((node for node in upstream(output) if node.type == "BSDF_PRINCIPLED"), None)


def upstream(node: bpy.types.Node) -> Iterator[bpy.types.Node]:
    """The node and all nodes that it depends on, the nearest first."""
    found = [node]
    for one in found:
        yield one
        before = [link.from_node for socket in one.inputs for link in socket.links]
        found += [other for other in before if other not in found]


def own_nodes(tree: bpy.types.NodeTree | None, mark: str) -> list[bpy.types.Node]:
    """The nodes of our groups whose mark begins with this, whether linked or not."""
    groups = [(node, getattr(node, "node_tree", None)) for node in (tree.nodes if tree is not None else ())]
    return [node for node, group in groups if group is not None and str(group.get(MARK, "")).startswith(mark)]


def passes(node: bpy.types.Node, passed: Passed) -> bool:
    """Tells whether shader inputs that the node was inserted for depend on it, directly or through nodes of ours."""
    return any(
        link.to_socket.name == name for name, output in there(node, passed) for link in node.outputs[output].links
    )


def there(node: bpy.types.Node, passed: Passed) -> list[tuple[str, str]]:
    """The values that a node can still pass on; somebody may have removed sockets from its group."""
    return [(name, output) for name, output in passed.items() if name in node.inputs and output in node.outputs]


def put(shader: bpy.types.Node, node: bpy.types.Node, passed: Passed) -> None:
    """Inserts the node before the shader's inputs, except those that it feeds already."""
    for name, output in there(node, passed):
        socket = shader.inputs[name]
        if not (socket.links and socket.links[0].from_node == node):
            bring(socket, node.inputs[name])
            node.id_data.links.new(node.outputs[output], socket)


def take_out(node: bpy.types.Node, passed: Passed) -> None:
    """Reconnects the inputs that the node feeds to its sources. The node stays, without these links."""
    for name, output in there(node, passed):
        for link in list(node.outputs[output].links):
            socket = link.to_socket
            node.id_data.links.remove(link)
            bring(node.inputs[name], socket)


def bring(source: bpy.types.NodeSocket, socket: bpy.types.NodeSocket) -> None:
    """Gives a socket the value, the link and the animation of another, and the drivers that read it.

    Blender 3.4 does not count muted links.
    """
    links = source.id_data.links
    socket.default_value = source.default_value
    animate(source.id_data.animation_data, *(one.path_from_id("default_value") for one in (source, socket)))
    redirect(source, socket)
    for link in list(socket.links):
        links.remove(link)
    for link in source.links:
        links.new(link.from_socket, socket).is_muted = link.is_muted


def animate(animation: bpy.types.AnimData | None, source: str, path: str) -> None:
    """Moves drivers and keyframes from one data path to another; an action that others use as well is copied."""
    if animation is None:
        return
    if any(curve.data_path == source for curve in curves_of(animation)):
        strips = (strip for track in animation.nla_tracks for strip in track.strips)
        for user in [one for one in (animation, *strips) if one.action is not None and is_shared(one.action)]:
            user.action = user.action.copy()
    for curve in (*animation.drivers, *curves_of(animation)):
        if curve.data_path == source:
            curve.data_path = path


def redirect(source: bpy.types.NodeSocket, socket: bpy.types.NodeSocket) -> None:
    """Makes drivers, wherever they are in the file, read one socket's value in place of another's."""
    tree = source.id_data
    owners = {tree: "", **{item: "node_tree." for item in bpy.data.materials if item.node_tree == tree}}
    users = bpy.data.user_map(subset=set(owners))
    for owner, start in owners.items():
        for target in read_by_drivers(users.get(owner, ())):
            path, value, rest = target.data_path.rpartition(".default_value")
            if target.id == owner and value and resolved(owner, path) == source:
                target.data_path = start + socket.path_from_id("default_value") + rest


def read_by_drivers(blocks: Iterable[bpy.types.ID]) -> Iterator[bpy.types.DriverTarget]:
    """The targets that the drivers of datablocks and of their own node trees read."""
    for block in blocks:
        for one in (block, getattr(block, "node_tree", None)):
            animation = getattr(one, "animation_data", None)
            for curve in animation.drivers if animation is not None else ():
                yield from (target for variable in curve.driver.variables for target in variable.targets)


def resolved(block: bpy.types.ID, path: str) -> object:
    """The member of a datablock at a path; None if there is none."""
    try:
        return block.path_resolve(path)
    except ValueError:
        return None


def is_shared(action: bpy.types.Action) -> bool:
    """Returns whether an action has several users, or is linked from another file."""
    return action.users - action.use_fake_user > 1 or action.library is not None
