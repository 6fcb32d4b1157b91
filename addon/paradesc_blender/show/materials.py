"""Makes materials that show descriptors, in a slot of their own; one click restores the user's materials."""

import bpy

from paradesc.bridge import InputError
from paradesc.core import legend

from ..scene import mesh_io, record
from ..scene.node_groups import MARK, add_node, linked
from ..settings.translation import said
from . import recolor, tuned
from .assets import append, found_group
from .passing import base_shader, own_nodes, passes, put, take_out
from .slots import DESCRIPTOR, assign, take_back

# The groups of the assets by the attributes they read. Groups in a file also have the attributes in their names.
CAVITY_GROUP, OF_MEAN = "Paradesc Cavity", "Paradesc Cavity of mean_curvature"
PASSED = {"Base Color": "Color"}


# ---- Trees


def new_material(mesh: bpy.types.Mesh, name: str, kind: str) -> bpy.types.Material:
    """Creates a material that shows the colors of a descriptor, lit ("colors") or exactly as they are ("flat").

    Or a clay with dirt in its hollows and worn edges ("cavity").
    """
    is_cavity = kind == "cavity"
    group, settings = cavity_group(mesh) if is_cavity else (None, {})
    end = " Flat" if kind == "flat" else ""
    material = bpy.data.materials.new("Paradesc Cavity" if is_cavity else f"Paradesc {legend.label(name)}{end}")
    if material.node_tree is None:  # never since Blender 5
        material.use_nodes = True
    material[DESCRIPTOR], material[MARK] = "cavity" if is_cavity else name, "material"
    tree = material.node_tree
    tree.nodes.clear()
    output = add_node(tree, "ShaderNodeOutputMaterial", (300, 0))
    if is_cavity:
        node = add_group(tree, group, settings, (-300, 0))
    else:
        node = add_node(tree, "ShaderNodeAttribute", (-300, 0), attribute_name=f"{name}_color")
    if kind == "flat":
        shader = add_node(tree, "ShaderNodeEmission", (0, 0))
    else:  # rough, so that highlights do not hide the colors
        shader = add_node(tree, "ShaderNodeBsdfPrincipled", (0, 0))
        shader.inputs["Roughness"].default_value = 0.75
        specular = "Specular IOR Level" if "Specular IOR Level" in shader.inputs else "Specular"
        shader.inputs[specular].default_value = 0.2
    tree.links.new(node.outputs["Color"], shader.inputs["Color" if kind == "flat" else "Base Color"])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    tuned.leave(material)
    return material


def add_group(
    tree: bpy.types.NodeTree, group: bpy.types.NodeTree, settings: dict[str, float], place: tuple[float, float]
) -> bpy.types.Node:
    """Adds a node of a group, with some of its inputs set."""
    node = add_node(tree, "ShaderNodeGroup", place, node_tree=group, width=190, label="Paradesc Cavity")
    for name, value in settings.items():
        node.inputs[name].default_value = value
    return node


def cavity_group(mesh: bpy.types.Mesh) -> tuple[bpy.types.NodeTree, dict[str, float]]:
    """The node group that turns a mesh's values into masks and a color, and the group's inputs for this mesh.

    It reads cavity and convexity if both were baked, else mean curvature times the radius, else the one of the two that
    was baked; the other is then 0.
    """
    names = recolor.baked_names(mesh)
    first = {mesh_io.registry_name(name): name for name in reversed(names)}  # of each descriptor, at any radius
    concave, convex, mean = (first.get(word, "") for word in ("cavity", "convexity", "mean_curvature"))
    if mean and not (concave and convex):
        stored = record.read(mesh)
        radius = stored.get("drawn", {}).get(mean, {}).get("radius", stored.get("field_report", {}).get("radius"))
        if radius is None:
            raise InputError(
                f'The mesh "{mesh.name}" no longer stores the radius of "{mean}"; bake it again.'
            )
        asset, attributes, settings = OF_MEAN, {"mean_curvature": mean}, {"Radius": radius}
        title = f"{CAVITY_GROUP} of {mean}"
    elif concave or convex:
        ends = [concave.removeprefix("cavity"), convex.removeprefix("convexity")]
        suffix = ends[0] or ends[1]
        asset, settings = CAVITY_GROUP, {}
        attributes = {"cavity": concave or f"cavity{suffix}", "convexity": convex or f"convexity{suffix}"}
        different = [] if not (concave and convex) or ends[0] == ends[1] else ["and", ends[1].removeprefix("_") or "1"]
        title = " ".join([CAVITY_GROUP, suffix.removeprefix("_"), *different]).rstrip()
    else:
        raise InputError(
            f'The mesh "{mesh.name}" has neither cavity nor convexity nor mean curvature; bake those first.'
        )
    group = found_group(title) or cavity_asset(asset, title, attributes)
    return group, settings


def cavity_asset(asset: str, title: str, attributes: dict[str, str]) -> bpy.types.NodeTree:
    """Appends a group of the assets, and replaces the attributes that it reads by these."""
    group = append("node_groups", asset)
    group.name = group[MARK] = title
    for node in group.nodes:
        if node.bl_idname == "ShaderNodeAttribute":
            node.attribute_name = attributes[node.attribute_name]
    return group


# ---- Operators


class PARADESC_OT_make_material(recolor.NeedsBake, bpy.types.Operator):
    """Show a descriptor by a material in its own slot; your materials are kept, and Remove restores the faces"""

    bl_idname = "paradesc.make_material"
    bl_label = "Material"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    kind: bpy.props.EnumProperty(
        name="Kind",
        description="Lighting of the colors",
        items=[
            ("colors", "Colors", "The colors of the descriptor that is shown, lit as the scene is"),
            ("flat", "Flat Colors", "The colors exactly as in the legend, without light"),
            ("cavity", "Cavity", "A clay with dirt in its hollows and worn edges"),
        ],
        default="colors",
    )

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Makes the material and gives it to all faces."""
        mesh = target.data
        name = recolor.shown_name(mesh) or recolor.baked_names(mesh)[0]
        for sentence in assign(mesh, new_material(mesh, name, self.kind)):
            self.report({"INFO"}, said(sentence))


class PARADESC_OT_plug_cavity(recolor.NeedsBake, bpy.types.Operator):
    """Put the Paradesc Cavity group before the base color of the object's active material"""

    bl_idname = "paradesc.plug_cavity"
    bl_label = "Add to Active Material"
    bl_options = {"REGISTER", "UNDO"}

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Changes the active material."""
        material = target.active_material
        if material is None:
            raise InputError(f'The object "{target.name}" has no active material; make the Paradesc material.')
        if linked(material):
            raise InputError(linked(material))
        shader = base_shader(material)
        if shader is None:
            raise InputError("The active material has no Principled BSDF in use; make the Paradesc material instead.")
        if any(passes(node, PASSED) for node in own_nodes(material.node_tree, CAVITY_GROUP)):
            raise InputError(f'The material "{material.name}" has the cavity group already.')
        group, settings = cavity_group(target.data)
        place = (shader.location.x - 230, shader.location.y - 60)
        put(shader, add_group(material.node_tree, group, settings, place), PASSED)


class PARADESC_OT_remove_material(recolor.NeedsBake, bpy.types.Operator):
    """Restore the former materials of all faces, and remove the cavity group from them"""

    bl_idname = "paradesc.remove_material"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Removes the materials and groups that the other two operators added."""
        for sentence in take_back(target.data):
            self.report({"INFO"}, said(sentence))
        for slot in target.material_slots:
            material = slot.material
            if material is not None and DESCRIPTOR not in material and not linked(material):
                for node in own_nodes(material.node_tree, CAVITY_GROUP):
                    if passes(node, PASSED):
                        take_out(node, PASSED)
                        material.node_tree.nodes.remove(node)


classes = (PARADESC_OT_make_material, PARADESC_OT_plug_cavity, PARADESC_OT_remove_material)
