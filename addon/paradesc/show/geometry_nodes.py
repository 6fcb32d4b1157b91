"""Adds Geometry Nodes that read a raw attribute, as a modifier of the active object and as examples to start from."""

from functools import partial

import bpy

from ..core.job import UNDEFINED_MASK
from ..scene import record
from ..scene.node_groups import MARK, add_map_range, add_math, add_modifier, add_node, add_socket, new_group
from . import recolor, tuned

TREE = "GeometryNodeTree"
MATH = "ShaderNodeMath"


def build(kind: str, name: str, low: float, high: float, mask: str = UNDEFINED_MASK) -> bpy.types.NodeTree:
    """Makes a group that reads the attribute and does one thing by it: "swell", "keep", "mark" or "scatter".

    mask: the attribute that is 1 where there is no value.
    """
    tree = new_group(TREE, f"Paradesc {kind} by {name}")
    add_socket(tree, "Geometry", "geometry")
    add_socket(tree, "Geometry", "geometry", output=True)
    if kind == "swell":
        add_socket(tree, "From Min", "float", (low, -1e9, 1e9))
        add_socket(tree, "From Max", "float", (high, -1e9, 1e9))
        add_socket(tree, "Offset", "float", (0.02, -1e6, 1e6))
    elif kind == "scatter":
        add_socket(tree, "From Min", "float", (low + 0.25 * (high - low), -1e9, 1e9))
        add_socket(tree, "From Max", "float", (high, -1e9, 1e9))
        add_socket(tree, "Density", "float", (2000.0, 0.0, 1e9))
        add_socket(tree, "Size", "float", (0.01, 0.0, 1e6))
    else:
        add_socket(tree, "Above", "float", (low + 0.75 * (high - low), -1e9, 1e9))
    given = add_node(tree, "NodeGroupInput", (-700, 0)).outputs
    result = add_node(tree, "NodeGroupOutput", (500, 0)).inputs
    value = named_attribute(tree, name, (-500, -200))
    link = tree.links.new
    makers = {"swell": partial(swell, mask=mask), "keep": keep, "mark": mark, "scatter": scatter}
    node = makers[kind](tree, value, given)
    link(given["Geometry"], node.inputs[0])
    link(node.outputs[0], result["Geometry"])
    return tree


def named_attribute(tree: bpy.types.NodeTree, name: str, place: tuple[float, float]) -> bpy.types.NodeSocket:
    """The values of a float attribute."""
    node = add_node(tree, "GeometryNodeInputNamedAttribute", place, data_type="FLOAT")
    node.inputs["Name"].default_value = name
    return next(socket for socket in node.outputs if socket.type == "VALUE")


def compare(
    tree: bpy.types.NodeTree, operation: str, place: tuple[float, float], first: bpy.types.NodeSocket, second: object
) -> bpy.types.NodeSocket:
    """Compares whether one number is above or below another; for values that do not exist neither is true."""
    node = add_node(tree, "FunctionNodeCompare", place, data_type="FLOAT", operation=operation)
    tree.links.new(first, node.inputs[0])
    if isinstance(second, bpy.types.NodeSocket):
        tree.links.new(second, node.inputs[1])
    else:
        node.inputs[1].default_value = second
    return node.outputs[0]


def swell(
    tree: bpy.types.NodeTree, value: bpy.types.NodeSocket, given: bpy.types.NodeOutputs, mask: str
) -> bpy.types.Node:
    """Moves vertices along their normals by the value; the mask keeps those without a value in place."""
    link = tree.links.new
    share = add_map_range(tree, (-280, -200), value, given["From Min"], given["From Max"])
    distance = add_math(tree, MATH, "MULTIPLY", (-90, -200), share, given["Offset"])
    scale = add_node(tree, "ShaderNodeVectorMath", (90, -200), operation="SCALE")
    link(add_node(tree, "GeometryNodeInputNormal", (-90, -380)).outputs[0], scale.inputs[0])
    link(distance, scale.inputs["Scale"])
    node = add_node(tree, "GeometryNodeSetPosition", (290, 0))
    link(scale.outputs[0], node.inputs["Offset"])
    without = named_attribute(tree, mask, (-280, -520))
    link(compare(tree, "LESS_THAN", (90, -480), without, 0.5), node.inputs["Selection"])
    return node


def keep(tree: bpy.types.NodeTree, value: bpy.types.NodeSocket, given: bpy.types.NodeOutputs) -> bpy.types.Node:
    """Keeps what lies above a value and deletes the rest."""
    node = add_node(tree, "GeometryNodeSeparateGeometry", (200, 0), domain="POINT")
    tree.links.new(compare(tree, "GREATER_THAN", (-100, -200), value, given["Above"]), node.inputs["Selection"])
    return node


def mark(tree: bpy.types.NodeTree, value: bpy.types.NodeSocket, given: bpy.types.NodeOutputs) -> bpy.types.Node:
    """Writes a boolean attribute, true above a value, that further nodes or a material can read."""
    node = add_node(tree, "GeometryNodeStoreNamedAttribute", (200, 0), data_type="BOOLEAN", domain="POINT")
    node.inputs["Name"].default_value = "paradesc_selection"
    chosen = compare(tree, "GREATER_THAN", (-100, -200), value, given["Above"])
    tree.links.new(
        chosen, next(socket for socket in node.inputs if socket.type == "BOOLEAN" and socket.name == "Value")
    )
    return node


def scatter(tree: bpy.types.NodeTree, value: bpy.types.NodeSocket, given: bpy.types.NodeOutputs) -> bpy.types.Node:
    """Puts small spheres where the value is high, denser the higher it is: moss in hollows, for example."""
    link = tree.links.new
    share = add_map_range(tree, (-280, -200), value, given["From Min"], given["From Max"])
    density = add_math(tree, MATH, "MULTIPLY", (-90, -200), share, given["Density"])
    points = add_node(tree, "GeometryNodeDistributePointsOnFaces", (90, -200), distribute_method="RANDOM")
    link(given["Geometry"], points.inputs["Mesh"])
    link(density, next(item for item in points.inputs if item.name == "Density" and item.enabled))
    ball = add_node(tree, "GeometryNodeMeshIcoSphere", (90, -480))
    link(given["Size"], ball.inputs["Radius"])
    placed = add_node(tree, "GeometryNodeInstanceOnPoints", (290, -200))
    link(points.outputs["Points"], placed.inputs["Points"])
    link(ball.outputs["Mesh"], placed.inputs["Instance"])
    node = add_node(tree, "GeometryNodeJoinGeometry", (400, 0))
    link(placed.outputs["Instances"], node.inputs[0])
    return node


def shared(tree: bpy.types.NodeTree) -> bpy.types.NodeTree:
    """The group that an earlier click made just like this new one, if nobody has changed it since; else the new one."""
    tuned.leave(tree)
    for other in bpy.data.node_groups:
        same = other.get(MARK) == tree[MARK] and other.get(tuned.PROPERTY) == tree[tuned.PROPERTY]
        if same and other != tree and other.library is None and tuned.is_as_left(other):
            bpy.data.node_groups.remove(tree)
            return other
    return tree


class PARADESC_OT_add_geometry_nodes(recolor.NeedsBake, bpy.types.Operator):
    """Add a Geometry Nodes modifier that reads the values of the descriptor that is shown: a start for your own"""

    bl_idname = "paradesc.add_geometry_nodes"
    bl_label = "Geometry Nodes"
    bl_options = {"REGISTER", "UNDO"}

    kind: bpy.props.EnumProperty(
        name="Kind",
        description="What the nodes do",
        items=[
            ("swell", "Swell", "Move vertices along their normals by the value"),
            ("keep", "Keep Above", "Keep what lies above a value, delete the rest"),
            ("mark", "Mark Above", "Write a boolean attribute paradesc_selection, true above a value"),
            ("scatter", "Scatter", "Put small objects where the value is high, denser the higher it is"),
        ],
        default="swell",
    )

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Adds the modifier at the end of the stack."""
        mesh = target.data
        name = recolor.shown_name(mesh) or recolor.baked_names(mesh)[0]
        if recolor.is_direction(name):
            raise recolor.mesh_io.refuse(f"{name} is a direction; show a descriptor with one value a vertex.")
        shown = recolor.stored_range(mesh, name)
        mask = record.attribute_of(mesh, UNDEFINED_MASK)
        tree = shared(build(self.kind, name, shown.minimum, shown.maximum, mask))
        add_modifier(target, tree, tree.name)


classes = (PARADESC_OT_add_geometry_nodes,)
