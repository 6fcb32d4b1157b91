"""Carries values to the mesh that modifiers make, by a Geometry Nodes modifier of ours at the end of the stack.

The values lie on a carrier, an object in no scene whose mesh is the one that was measured. The modifier stores them by
the vertices' numbers while the other modifiers make as many. Else the values of the object's own vertices stay, as
Blender mixes them, which is right in every pose; where modifiers lose own vertices, the carrier's nearest place counts.
The modifier changes no position and no face, so what is measured is the same with and without it.
"""

import hashlib
from collections.abc import Iterable

import bpy

from . import record
from .arrays import kind_of
from .node_groups import MARK, add_modifier, add_node, add_socket, new_group

KIND = "Paradesc Values"
MODIFIER = "Paradesc"
# The name of the node that has the carrier.
CARRIER = "Values"
# The type of the sockets, and of the switch, for each type of an attribute.
SOCKETS = {"FLOAT": ("VALUE", "FLOAT"), "FLOAT_VECTOR": ("VECTOR", "VECTOR"), "FLOAT_COLOR": ("RGBA", "RGBA")}
# The custom property of a group with what we made it of.
LEFT = "paradesc_left"
NEAREST = "GeometryNodeSampleNearestSurface"
# The counts that tell whether the modifiers make the vertices and faces that were measured.
COUNTS = ("Point Count", "Face Corner Count")


def is_ours(modifier: bpy.types.Modifier) -> bool:
    """Whether a modifier carries values and its nodes are as we left them."""
    group = modifier.node_group if modifier.type == "NODES" else None
    if group is None or group.get(MARK) != KIND or group.library is not None:
        return False
    return group.get(LEFT) == structure(group) and is_carrier(held_by(group))


def is_carrier(item: bpy.types.Object | None) -> bool:
    """Whether this is an object that only holds the values of another one."""
    return item is not None and item.get(MARK) == KIND


def modifier_of(target: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """The modifier that carries the object's values; None if there is none that is as we left it."""
    return next((item for item in target.modifiers if is_ours(item)), None)


def carrier_of(target: bpy.types.Object) -> bpy.types.Mesh | None:
    """The mesh with the values that the object's modifier stores, if there are any."""
    modifier = modifier_of(target)
    return None if modifier is None else held_by(modifier.node_group).data


def held_by(group: bpy.types.NodeTree) -> bpy.types.Object | None:
    """The carrier whose values a group stores; None if somebody has deleted it."""
    return group.nodes[CARRIER].inputs["Object"].default_value


def carried_names(target: bpy.types.Object) -> list[str]:
    """The names of the attributes that the object's modifier stores."""
    mesh = carrier_of(target)
    return [] if mesh is None else record.attributes_of(mesh)


def carry(target: bpy.types.Object, mesh: bpy.types.Mesh, by_place: bool) -> None:
    """Makes this mesh that of the carrier, whose recorded attributes the modifier stores from now on.

    by_place: where the modifiers make other vertices, those of the nearest place count, not those that Blender mixes.
    Objects that share the mesh before modifiers get the same modifier, as their own vertices share the values. What
    others use as well, such as copies with a mesh of their own, stays theirs.
    """
    group = own_group(target)
    if group is None:
        group, carrier = new_group("GeometryNodeTree", KIND), new_carrier(target, mesh)
    else:
        carrier = held_by(group)
        set_mesh(carrier, mesh)
    build(group, carrier, by_place)
    group[LEFT] = structure(group)
    for item in [target, *(other for other in sharing(target.data) if other != target and other.modifiers)]:
        place(item, group)


def place(target: bpy.types.Object, group: bpy.types.NodeTree) -> None:
    """Makes a shown modifier with this group the last one of the object, the only one of ours."""
    for modifier in [item for item in target.modifiers if is_ours(item)]:
        is_last = modifier == target.modifiers[-1]
        if modifier.node_group == group and is_last and modifier.show_viewport and modifier.show_render:
            return
        remove_modifier(target, modifier, keep=group)
    add_modifier(target, group, MODIFIER).show_expanded = False


def release(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Lets every object with this mesh show its own attributes of these names again; the modifier goes if none is left.

    Values have just been written to the mesh itself, and those that were carried would hide them.
    """
    for target in sharing(mesh):
        carried = carried_names(target)
        kept = [name for name in carried if name not in names]
        if carried and not kept:
            remove_modifier(target, modifier_of(target))
        elif len(kept) < len(carried):
            held, nodes = carrier_of(target), modifier_of(target).node_group.nodes
            held = held.copy() if own_group(target) is None else held
            keep_only(held, kept)
            carry(target, held, by_place=any(node.bl_idname == NEAREST for node in nodes))


def keep_only(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Leaves a carrier's mesh these attributes alone: values are all that it is for."""
    for layer in list(mesh.uv_layers):
        mesh.uv_layers.remove(layer)
    kept = {*names, "position", "material_index", "sharp_face", "sharp_edge"}
    for name in [item.name for item in mesh.attributes if not item.name.startswith(".") and item.name not in kept]:
        mesh.attributes.remove(mesh.attributes[name])
    mesh.materials.clear()


# ---- Ours and nobody else's


def sharing(mesh: bpy.types.Mesh) -> list[bpy.types.Object]:
    """The objects of this file that have the mesh."""
    return [item for item in bpy.data.objects if item.data == mesh and item.library is None]


def own_group(target: bpy.types.Object) -> bpy.types.NodeTree | None:
    """The group that carries the object's values, if only objects with its mesh use it, and only it its carrier."""
    modifier = modifier_of(target)
    if modifier is None:
        return None
    group = modifier.node_group
    used = sum(
        one.type == "NODES" and one.node_group == group for item in sharing(target.data) for one in item.modifiers
    )
    return group if group.users == used and held_by(group).users == 1 else None


def new_carrier(target: bpy.types.Object, mesh: bpy.types.Mesh) -> bpy.types.Object:
    """An object in no collection: no view layer shows, selects, renders or exports it."""
    carrier = bpy.data.objects.new(f"{target.name} {CARRIER}", mesh)
    carrier[MARK] = KIND
    mesh.name = carrier.name
    return carrier


def set_mesh(carrier: bpy.types.Object, mesh: bpy.types.Mesh) -> None:
    """Gives a carrier its mesh; the former one goes unless something else uses it."""
    former, carrier.data = carrier.data, mesh
    if former.users == 0:
        bpy.data.meshes.remove(former)
    mesh.name = carrier.name


def remove_modifier(
    target: bpy.types.Object, modifier: bpy.types.NodesModifier, keep: bpy.types.NodeTree | None = None
) -> None:
    """Removes our modifier, and its group and carrier if nothing else uses them and the group is not to be kept."""
    group = modifier.node_group
    carrier = held_by(group)
    mesh = carrier.data
    target.modifiers.remove(modifier)
    if group == keep or group.users:
        return
    bpy.data.node_groups.remove(group)
    if carrier.users == 0:
        bpy.data.objects.remove(carrier)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)


# ---- Nodes


def structure(group: bpy.types.NodeTree) -> str:
    """What a group is made of, in words that stay when a newer Blender opens the file: its nodes have other sockets."""
    nodes = [(node.bl_idname, node.name, node.mute, name_in(node)) for node in group.nodes]
    ends = [(link.from_node, link.from_socket, link.to_node, link.to_socket) for link in group.links]
    links = sorted(tuple(end.name for end in link) for link in ends)
    return hashlib.sha256(repr((nodes, links)).encode()).hexdigest()[:32]


def name_in(node: bpy.types.Node) -> str:
    """The name of the attribute that a node reads or stores, or ""."""
    socket = node.inputs.get("Name")
    return "" if socket is None else socket.default_value


def build(group: bpy.types.NodeTree, carrier: bpy.types.Object, by_place: bool) -> None:
    """Fills a group with the nodes that store the carrier's recorded attributes; its former nodes go."""
    is_new = not group.nodes
    group.nodes.clear()
    if is_new:
        add_socket(group, "Geometry", "geometry")
        add_socket(group, "Geometry", "geometry", output=True)
    given = add_node(group, "NodeGroupInput", (-1000, 0)).outputs[0]
    info = add_node(group, "GeometryNodeObjectInfo", (-1000, -200), name=CARRIER, transform_space="ORIGINAL")
    info.inputs["Object"].default_value = carrier
    held = info.outputs["Geometry"]
    same = same_counts(group, given, held)
    index = add_node(group, "GeometryNodeInputIndex", (-400, -500)).outputs[0]
    for row, name in enumerate(record.attributes_of(carrier.data)):
        data_type = kind_of(carrier.data.attributes[name])[0]
        given = store(group, (200, -400 * row), given, name, data_type, (held, same, index), by_place)
    group.links.new(given, add_node(group, "NodeGroupOutput", (500, 0)).inputs[0])


def same_counts(
    group: bpy.types.NodeTree, first: bpy.types.NodeSocket, second: bpy.types.NodeSocket
) -> bpy.types.NodeSocket:
    """Whether two meshes have as many vertices and corners."""
    sizes = []
    for row, geometry in enumerate((first, second)):
        size = add_node(group, "GeometryNodeAttributeDomainSize", (-800, 200 - 200 * row), component="MESH")
        group.links.new(geometry, size.inputs[0])
        sizes.append(size.outputs)
    both = add_node(group, "FunctionNodeBooleanMath", (-400, 100), operation="AND")
    for row, name in enumerate(COUNTS):
        equal = add_node(
            group, "FunctionNodeCompare", (-600, 200 - 200 * row), data_type="INT", operation="EQUAL", label=name
        )
        for size, socket in zip(sizes, [item for item in equal.inputs if item.type == "INT"], strict=True):
            group.links.new(size[name], socket)
        group.links.new(equal.outputs[0], both.inputs[row])
    return both.outputs[0]


def store(
    group: bpy.types.NodeTree,
    place: tuple[float, float],
    geometry: bpy.types.NodeSocket,
    name: str,
    data_type: str,
    sources: tuple[bpy.types.NodeSocket, bpy.types.NodeSocket, bpy.types.NodeSocket],
    by_place: bool,
) -> bpy.types.NodeSocket:
    """Adds nodes that store one attribute of the carrier; sources: the carrier, whether counts agree, the index."""
    held, same, index = sources
    socket_type, switch_type = SOCKETS[data_type]
    link, (x, y) = group.links.new, place

    def value(sockets: Iterable[bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
        return next(item for item in sockets if item.type == socket_type and item.enabled and item.name == "Value")

    def only(sockets: Iterable[bpy.types.NodeSocket], kind: str = socket_type) -> list[bpy.types.NodeSocket]:
        return [item for item in sockets if item.type == kind and item.enabled]

    named = add_node(group, "GeometryNodeInputNamedAttribute", (x - 600, y), data_type=data_type)
    by_index = add_node(group, "GeometryNodeSampleIndex", (x - 400, y), data_type=data_type, domain="POINT")
    chosen = add_node(group, "GeometryNodeSwitch", (x - 200, y), input_type=switch_type)
    stored = add_node(group, "GeometryNodeStoreNamedAttribute", (x, y), data_type=data_type, domain="POINT")
    named.inputs["Name"].default_value = stored.inputs["Name"].default_value = name
    link(held, by_index.inputs["Geometry"])
    link(only(named.outputs)[0], value(by_index.inputs))
    link(index, by_index.inputs["Index"])
    other = named
    if by_place:
        other = add_node(group, NEAREST, (x - 400, y - 200), data_type=data_type)
        link(held, other.inputs["Mesh"])
        link(only(named.outputs)[0], value(other.inputs))
    link(same, only(chosen.inputs, "BOOLEAN")[0])
    for sampled, socket in zip((other, by_index), only(chosen.inputs), strict=True):
        link(only(sampled.outputs)[0], socket)
    link(geometry, stored.inputs["Geometry"])
    link(only(chosen.outputs)[0], value(stored.inputs))
    return stored.outputs["Geometry"]
