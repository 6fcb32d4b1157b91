"""Carries values to the mesh that modifiers make, by a Geometry Nodes modifier of ours at the end of the stack.

The values are stored on a carrier: an object in no scene, whose mesh is the measured mesh. As long as the other
modifiers make the same number of vertices, the modifier copies the carrier's values by the vertices' numbers. Otherwise
the values of the object's own vertices stay, as Blender interpolates them, which is right in every pose. If modifiers
remove own vertices, each vertex takes the value of the carrier's nearest place. The modifier changes no position and no
face, so the measured surface is the same with and without it.
"""

import hashlib
from collections.abc import Iterable

import bpy
import numpy as np

from . import record
from .arrays import attribute_values, kind_of
from .node_groups import MARK, add_modifier, add_node, add_socket, new_group

KIND = "Paradesc Values"
MODIFIER = "Paradesc"
# The name of the node with the carrier.
CARRIER = "Values"
# The type of the sockets, and of the switch, for each type of an attribute.
SOCKETS = {"FLOAT": ("VALUE", "FLOAT"), "FLOAT_VECTOR": ("VECTOR", "VECTOR"), "FLOAT_COLOR": ("RGBA", "RGBA")}
# The custom property with the digest of a group's structure as we made it.
LEFT = "paradesc_left"
# The custom property with the attributes that a group stores, and how.
STORED = "paradesc_stored"
NEAREST = "GeometryNodeSampleNearestSurface"
# The counts that tell whether the modifiers made the vertices and faces that were measured.
COUNTS = ("Point Count", "Face Corner Count")


def is_ours(modifier: bpy.types.Modifier) -> bool:
    """Returns whether a modifier is our carrying modifier with its nodes as we left them, and can be removed."""
    group = modifier.node_group if modifier.type == "NODES" else None
    is_fixed = modifier.id_data.override_library is not None and modifier.is_override_data
    return group is not None and is_own(group) and not is_fixed


def is_own(group: bpy.types.NodeTree) -> bool:
    """Returns whether the nodes are ours, unedited, and read a carrier of ours; the carrier may have been deleted."""
    return is_left(group) and (held_by(group) is None or is_carrier(held_by(group)))


def is_left(group: bpy.types.NodeTree) -> bool:
    """Returns whether a node group is ours and nobody has edited it. It may be linked from another file."""
    return group.get(MARK) == KIND and group.get(LEFT) == structure(group)


def is_carrier(item: bpy.types.Object | None) -> bool:
    """Returns whether an object is a carrier, which only holds the values of another object."""
    return item is not None and item.get(MARK) == KIND


def modifier_of(target: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """The modifier that carries the object's values; None if it is missing or was edited."""
    return next((item for item in target.modifiers if is_ours(item)), None)


def carrier_of(target: bpy.types.Object) -> bpy.types.Mesh | None:
    """The carrier's mesh, which holds the values that the object's modifier stores; None without one."""
    modifier = modifier_of(target)
    carrier = None if modifier is None else held_by(modifier.node_group)
    return None if carrier is None else carrier.data


def held_by(group: bpy.types.NodeTree) -> bpy.types.Object | None:
    """The carrier from which a group reads its values; None if it was deleted."""
    return group.nodes[CARRIER].inputs["Object"].default_value


def own_carrier(target: bpy.types.Object) -> bpy.types.Mesh:
    """The mesh of the object's carrier, which must exist. If copies with other meshes use it too, a copy replaces it."""
    mesh = carrier_of(target)
    if own_group(target) is None:
        group, mesh = modifier_of(target).node_group, mesh.copy()
        mesh.name = f"{target.name} {CARRIER}"
        carry(target, mesh, counts_of(group), looks_up_places(group))
    return mesh


def carried_names(target: bpy.types.Object) -> list[str]:
    """The names of the attributes that the object's modifier stores."""
    mesh = carrier_of(target)
    return [] if mesh is None else record.attributes_of(mesh)


def carried_values(target: bpy.types.Object, mesh: bpy.types.Mesh) -> dict[str, np.ndarray]:
    """The values of these attributes on the object's evaluated mesh."""
    found = {name: mesh.attributes[name] for name in carried_names(target) if name in mesh.attributes}
    return {name: attribute_values(item) for name, item in found.items() if item.domain == "POINT"}


def emptied(target: bpy.types.Object) -> bpy.types.Mesh:
    """An empty mesh for carry(): that of the object's carrier if nothing else uses it, else a new one."""
    group = own_group(target)
    if group is None:
        return bpy.data.meshes.new(f"{target.name} {CARRIER}")
    mesh = held_by(group).data
    mesh.clear_geometry()
    for name in list(mesh.keys()):
        del mesh[name]
    return mesh


def carry(target: bpy.types.Object, mesh: bpy.types.Mesh, counts: tuple[int, int], by_place: bool) -> None:
    """Makes this the carrier's mesh. From now on the modifier stores the attributes in its record.

    counts: of vertices and corners of the measured mesh; of other meshes own vertices keep their values, or, by_place,
    the nearest place counts, because modifiers lose own vertices.

    Objects with the same mesh before modifiers get the same modifier, as they share the values of their own vertices
    too. A group or carrier that other objects use as well, such as copies with their own mesh, is not changed.
    """
    own = own_group(target)
    if own is None:
        carrier = bpy.data.objects.new(f"{target.name} {CARRIER}", mesh)  # in no collection, so nothing shows it
        carrier[MARK] = KIND
    else:
        carrier = held_by(own)
    kinds = [(name, kind_of(mesh.attributes[name])[0]) for name in record.attributes_of(mesh)]
    group = group_for(own, kinds, by_place)
    group.nodes[CARRIER].inputs["Object"].default_value = carrier
    for name, count in zip(COUNTS, counts, strict=True):
        of_type(group.nodes[name].inputs, "INT")[1].default_value = count
    for item in [target, *(other for other in sharing(target.data) if other != target and other.modifiers)]:
        place(item, group)
    sweep()


def counts_of(group: bpy.types.NodeTree) -> tuple[int, int]:
    """The counts in the nodes of a group."""
    points, corners = (of_type(group.nodes[name].inputs, "INT")[1].default_value for name in COUNTS)
    return points, corners


def looks_up_places(group: bpy.types.NodeTree) -> bool:
    """Returns whether a group takes values of the nearest places, because modifiers lose own vertices."""
    return any(node.bl_idname == NEAREST for node in group.nodes)


def place(target: bpy.types.Object, group: bpy.types.NodeTree) -> None:
    """Makes our modifier with this group the object's last one, visible, and the only one of ours."""
    for modifier in [item for item in target.modifiers if is_ours(item)]:
        if modifier == target.modifiers[-1]:
            modifier.node_group, modifier.show_viewport, modifier.show_render = group, True, True
            return
        target.modifiers.remove(modifier)
    add_modifier(target, group, MODIFIER).show_expanded = False


def release(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Stops carrying these attributes to the objects with this mesh; the modifier goes if no attribute is left.

    The values have just been written to the mesh itself, where carried values of the same names would hide them.
    """
    for target in sharing(mesh):
        modifier, carried = modifier_of(target), carried_names(target)
        gone = [name for name in carried if name in names]
        if modifier is not None and len(gone) == len(carried):
            target.modifiers.remove(modifier)
        elif gone:
            held, group = carrier_of(target), modifier.node_group
            held = held.copy() if own_group(target) is None else held
            for name in gone:
                held.attributes.remove(held.attributes[name])
            carry(target, held, counts_of(group), looks_up_places(group))
    sweep()


# ---- Ours and nobody else's


def sharing(mesh: bpy.types.Mesh) -> list[bpy.types.Object]:
    """The objects of this file that have the mesh."""
    return [item for item in bpy.data.objects if item.data == mesh and item.library is None]


def own_group(target: bpy.types.Object) -> bpy.types.NodeTree | None:
    """The group with the object's values, if only objects with its mesh use it, and nothing else its carrier."""
    modifier = modifier_of(target)
    if modifier is None or modifier.node_group.library is not None:
        return None
    group = modifier.node_group
    used = sum(
        one.type == "NODES" and one.node_group == group for item in sharing(target.data) for one in item.modifiers
    )
    carrier = held_by(group)
    return group if group.users == used and carrier is not None and carrier.users == 1 else None


def sweep() -> None:
    """Removes our groups that no modifier uses any more, with their carriers unless those are used otherwise."""
    for group in [one for one in bpy.data.node_groups if not one.users and one.library is None and is_own(one)]:
        carrier = held_by(group)
        bpy.data.node_groups.remove(group)
        if carrier is not None and carrier.users == 0:
            mesh = carrier.data
            bpy.data.objects.remove(carrier)
            if mesh.users == 0:
                bpy.data.meshes.remove(mesh)


# ---- Nodes


def group_for(own: bpy.types.NodeTree | None, kinds: list[tuple[str, str]], by_place: bool) -> bpy.types.NodeTree:
    """A group that stores these attributes, by name and type: the object's own, a copy of another, or a new one."""
    wanted = repr((kinds, by_place))
    if own is not None and own.get(STORED) == wanted:
        return own
    alike = (group for group in bpy.data.node_groups if group.get(STORED) == wanted and is_left(group))
    found = next(alike, None)
    group = new_group("GeometryNodeTree", KIND) if found is None else found.copy()
    if found is None:
        build(group, kinds, by_place)
        group[STORED], group[LEFT] = wanted, structure(group)
    return group


def structure(group: bpy.types.NodeTree) -> str:
    """A digest of a group's nodes and links, without sockets that are not linked: a newer Blender may change those."""
    named = {node.name: node.inputs["Name"].default_value for node in group.nodes if "Name" in node.inputs}
    nodes = [(node.bl_idname, node.name, node.mute, named.get(node.name, "")) for node in group.nodes]
    ends = [(link.from_node, link.from_socket, link.to_node, link.to_socket) for link in group.links]
    links = sorted(tuple(end.name for end in link) for link in ends)
    return hashlib.sha256(repr((nodes, links)).encode()).hexdigest()[:32]


def build(group: bpy.types.NodeTree, kinds: list[tuple[str, str]], by_place: bool) -> None:
    """Fills an empty group with nodes that store these attributes of the carrier."""
    add_socket(group, "Geometry", "geometry")
    add_socket(group, "Geometry", "geometry", output=True)
    given = add_node(group, "NodeGroupInput", (-1000, 0)).outputs[0]
    info = add_node(group, "GeometryNodeObjectInfo", (-1000, -200), name=CARRIER, transform_space="ORIGINAL")
    same = same_counts(group, given)
    index = add_node(group, "GeometryNodeInputIndex", (-400, -500)).outputs[0]
    for row, (name, data_type) in enumerate(kinds):
        sources = (info.outputs["Geometry"], same, index)
        given = store(group, (200, -400 * row), given, name, data_type, sources, by_place)
    group.links.new(given, add_node(group, "NodeGroupOutput", (500, 0)).inputs[0])


def same_counts(group: bpy.types.NodeTree, geometry: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """Returns whether a mesh has as many vertices and corners as the one that was measured."""
    size = add_node(group, "GeometryNodeAttributeDomainSize", (-800, 200), component="MESH")
    both = add_node(group, "FunctionNodeBooleanMath", (-400, 100), operation="AND")
    group.links.new(geometry, size.inputs[0])
    for row, name in enumerate(COUNTS):
        place = (-600, 200 - 200 * row)
        equal = add_node(group, "FunctionNodeCompare", place, name=name, data_type="INT", operation="EQUAL")
        group.links.new(size.outputs[name], of_type(equal.inputs, "INT")[0])
        group.links.new(equal.outputs[0], both.inputs[row])
    return both.outputs[0]


def of_type(sockets: Iterable[bpy.types.NodeSocket], kind: str) -> list[bpy.types.NodeSocket]:
    """The sockets of this type that a node uses; some have others of each type, which they hide."""
    return [socket for socket in sockets if socket.type == kind and socket.enabled]


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
        return of_type(sockets, socket_type)[0]

    named = add_node(group, "GeometryNodeInputNamedAttribute", (x - 600, y), data_type=data_type)
    by_index = add_node(group, "GeometryNodeSampleIndex", (x - 400, y), data_type=data_type, domain="POINT")
    chosen = add_node(group, "GeometryNodeSwitch", (x - 200, y), input_type=switch_type)
    stored = add_node(group, "GeometryNodeStoreNamedAttribute", (x, y), data_type=data_type, domain="POINT")
    named.inputs["Name"].default_value = stored.inputs["Name"].default_value = name
    link(held, by_index.inputs["Geometry"])
    link(value(named.outputs), value(by_index.inputs))
    link(index, by_index.inputs["Index"])
    other = named
    if by_place:
        other = add_node(group, NEAREST, (x - 400, y - 200), data_type=data_type)
        link(held, other.inputs["Mesh"])
        link(value(named.outputs), value(other.inputs))
    link(same, of_type(chosen.inputs, "BOOLEAN")[0])
    for sampled, socket in zip((other, by_index), of_type(chosen.inputs, socket_type), strict=True):
        link(value(sampled.outputs), socket)
    link(geometry, stored.inputs["Geometry"])
    link(value(chosen.outputs), value(stored.inputs))
    return stored.outputs["Geometry"]
