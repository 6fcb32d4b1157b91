"""Adds Geometry Nodes that read an attribute, as a modifier of the active object and as examples to build on."""

import bpy

from paradesc.bridge import InputError
from paradesc.core import legend
from paradesc.core.job import UNDEFINED_MASK

from ..scene import record
from ..scene.node_groups import MARK, add_modifier, input_of
from . import recolor, tuned
from .assets import append

# The start of each kind's effect, as a fraction of the range.
BEGINNINGS = {
    "swell": ("From Min", 0.0),
    "scatter": ("From Min", 0.25),
    "keep": ("Above", 0.75),
    "mark": ("Above", 0.75),
}


def build(kind: str, name: str, low: float, high: float, mask: str = UNDEFINED_MASK) -> bpy.types.NodeTree:
    """Creates a group that reads the attribute and applies one effect: "swell", "keep", "mark" or "scatter".

    mask: the attribute that is 1 where there is no value.
    """
    tree = append("node_groups", f"Paradesc {kind}")
    tree[MARK] = f"Paradesc {kind} by {name}"
    tree.name = f"Paradesc {kind.title()} by {legend.label(name)}"
    for node in tree.nodes:
        if node.bl_idname == "GeometryNodeInputNamedAttribute":
            node.inputs["Name"].default_value = name if node.label == "Value" else mask
    begin, share = BEGINNINGS[kind]
    input_of(tree, begin).default_value = low + share * (high - low)
    if begin == "From Min":
        input_of(tree, "From Max").default_value = high
    return tree


def shared(tree: bpy.types.NodeTree) -> bpy.types.NodeTree:
    """An unchanged group of an earlier click that is equal to this new one, which is then removed; else the new one."""
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
        description="Effect of the nodes",
        items=[
            ("swell", "Swell", "Move vertices along their normals by the value"),
            ("keep", "Keep Above", "Keep the parts above a value, and delete the rest"),
            ("mark", "Mark Above", "Write a boolean attribute paradesc_selection, true above a value"),
            ("scatter", "Scatter", "Scatter small objects by the value, the denser the higher it is"),
        ],
        default="swell",
    )

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Adds the modifier at the end of the stack."""
        mesh = target.data
        name = recolor.shown_name(mesh) or recolor.baked_names(mesh)[0]
        if recolor.is_direction(name):
            raise InputError(f"{name} is a direction; show a descriptor with one value per vertex.")
        shown = recolor.stored_range(mesh, name)
        mask = record.attribute_of(mesh, UNDEFINED_MASK)
        tree = shared(build(self.kind, name, shown.minimum, shown.maximum, mask))
        add_modifier(target, tree, tree.name)


classes = (PARADESC_OT_add_geometry_nodes,)
