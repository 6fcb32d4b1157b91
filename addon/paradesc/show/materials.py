"""Makes materials that show descriptors, on a slot of their own: the user's stay, and one click restores them."""

import bpy

from ..scene import mesh_io, record
from ..scene.node_groups import MARK, add_map_range, add_math, add_mix, add_node, add_socket, found_group, new_group
from ..settings.translation import said
from . import recolor, tuned
from .slots import DESCRIPTOR, assign, take_back

CAVITY_GROUP = "Paradesc Cavity"
TREE = "ShaderNodeTree"
# What node groups and materials look like before the user changes them.
CLAY, DIRT, WEAR = (0.35, 0.20, 0.11, 1.0), (0.025, 0.014, 0.008, 1.0), (0.78, 0.62, 0.46, 1.0)
# Where the masks begin and where they are full, in curvature times radius: most of a surface is a little convex.
RAMPS = {"Cavity": (0.03, 0.4), "Edge": (0.2, 0.7)}


# ---- Trees


def color_material(name: str, flat: bool) -> bpy.types.Material:
    """Makes a material that shows the colors of a descriptor: lit, or exactly as they are."""
    material, nodes = new_material(f"Paradesc {name}" + (" flat" if flat else ""), name)
    tree = material.node_tree
    color = add_node(tree, "ShaderNodeAttribute", (-300, 0), attribute_name=f"{name}_color").outputs["Color"]
    if flat:
        shader = add_node(tree, "ShaderNodeEmission", (0, 0))
        tree.links.new(color, shader.inputs["Color"])
    else:
        shader = add_principled(tree)
        tree.links.new(color, shader.inputs["Base Color"])
    tree.links.new(shader.outputs[0], nodes.inputs["Surface"])
    tuned.leave(material)
    return material


def cavity_material(mesh: bpy.types.Mesh) -> bpy.types.Material:
    """Makes a clay with dirt in its hollows and worn edges."""
    group, settings = cavity_group(mesh)
    material, output = new_material("Paradesc cavity", "cavity")
    tree = material.node_tree
    node = add_group(tree, group, settings, (-300, 0))
    shader = add_principled(tree)
    tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    tuned.leave(material)
    return material


def new_material(name: str, descriptor: str) -> tuple[bpy.types.Material, bpy.types.Node]:
    """Makes a material with only its output node."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # never since Blender 5
        material.use_nodes = True
    material.node_tree.nodes.clear()
    material[DESCRIPTOR] = descriptor
    material[MARK] = "material"
    return material, add_node(material.node_tree, "ShaderNodeOutputMaterial", (300, 0))


def add_principled(tree: bpy.types.NodeTree) -> bpy.types.Node:
    """Adds a dull surface, whose highlights do not hide colors."""
    shader = add_node(tree, "ShaderNodeBsdfPrincipled", (0, 0))
    shader.inputs["Roughness"].default_value = 0.75
    name = "Specular IOR Level" if "Specular IOR Level" in shader.inputs else "Specular"
    shader.inputs[name].default_value = 0.2
    return shader


def add_group(
    tree: bpy.types.NodeTree, group: bpy.types.NodeTree, settings: dict[str, float], place: tuple[float, float]
) -> bpy.types.Node:
    """Adds a node of a group, with some of its inputs set."""
    node = add_node(tree, "ShaderNodeGroup", place, node_tree=group, width=190, label="Paradesc Cavity")
    for name, value in settings.items():
        node.inputs[name].default_value = value
    return node


def cavity_group(mesh: bpy.types.Mesh) -> tuple[bpy.types.NodeTree, dict[str, float]]:
    """The node group that turns what was baked on a mesh into masks and a color, and the inputs that this mesh needs.

    It reads cavity and convexity if both were baked, else mean curvature times the radius, else the one of the two that
    was baked; the other is then 0.
    """
    names = recolor.baked_names(mesh)
    concave, convex, mean = (first_of(names, word) for word in ("cavity", "convexity", "mean_curvature"))
    if mean and not (concave and convex):
        stored = record.read(mesh)
        radius = stored.get("drawn", {}).get(mean, {}).get("radius", stored.get("field_report", {}).get("radius"))
        if radius is None:
            raise mesh_io.refuse(
                f'The mesh "{mesh.name}" does not say any more which radius "{mean}" has; bake it again.'
            )
        attributes, title, settings = (mean, ""), f"{CAVITY_GROUP} of {mean}", {"Radius": radius}
    elif concave or convex:
        ends = [concave.removeprefix("cavity"), convex.removeprefix("convexity")]
        suffix = ends[0] or ends[1]
        attributes = (concave or f"cavity{suffix}", convex or f"convexity{suffix}")
        different = [] if not (concave and convex) or ends[0] == ends[1] else ["and", ends[1].removeprefix("_") or "1"]
        title, settings = " ".join([CAVITY_GROUP, suffix.removeprefix("_"), *different]).rstrip(), {}
    else:
        raise mesh_io.refuse(
            f'The mesh "{mesh.name}" has neither cavity nor convexity nor mean curvature; bake those first.'
        )
    group = found_group(TREE, title)
    if group is None:
        group = build_cavity(title, attributes)
    return group, settings


def first_of(names: list[str], word: str) -> str:
    """The first of the names that is this descriptor, at whatever radius, or ""."""
    return next((name for name in names if mesh_io.registry_name(name) == word), "")


def build_cavity(title: str, attributes: tuple[str, str]) -> bpy.types.NodeTree:
    """Turns attributes into masks between 0 and 1, and mixes dirt and wear into a base color."""
    tree = new_group(TREE, title)
    for name, color in (("Base Color", CLAY), ("Cavity Color", DIRT), ("Edge Color", WEAR)):
        add_socket(tree, name, "color", color)
    for name in ("Cavity Strength", "Edge Strength"):
        add_socket(tree, name, "float", (1.0, 0.0, 1.0))
    for word, (begin, end) in RAMPS.items():
        add_socket(tree, f"{word} Begin", "float", (begin, 0.0, 1.0))
        add_socket(tree, f"{word} End", "float", (end, 0.0, 1.0))
    if not attributes[1]:
        add_socket(tree, "Radius", "float", (0.1, 0.0, 1e6))
    add_socket(tree, "Color", "color", output=True)
    for name in ("Cavity", "Edge"):
        add_socket(tree, name, "float", output=True)
    given = add_node(tree, "NodeGroupInput", (-900, 0)).outputs
    result = add_node(tree, "NodeGroupOutput", (700, 0)).inputs
    color = given["Base Color"]
    for index, (word, value) in enumerate(zip(RAMPS, raw_masks(tree, attributes, given), strict=True)):
        height = -300.0 * index
        # The larger of a value and 0, which is 0 if the value does not exist.
        value = add_math(tree, "ShaderNodeMath", "MAXIMUM", (-300, height), value, 0.0)
        share = add_map_range(tree, (-120, height), value, given[f"{word} Begin"], given[f"{word} End"], label=word)
        mask = add_math(tree, "ShaderNodeMath", "MULTIPLY", (180, height), share, given[f"{word} Strength"])
        color = add_mix(tree, (400, height), mask, color, given[f"{word} Color"])
        tree.links.new(mask, result[word])
    tree.links.new(color, result["Color"])
    return tree


def raw_masks(
    tree: bpy.types.NodeTree, attributes: tuple[str, str], given: bpy.types.NodeOutputs
) -> list[bpy.types.NodeSocket]:
    """How concave and how convex the surface is: as baked, or by mean curvature times radius of either sign."""
    if attributes[1]:
        return [
            add_node(tree, "ShaderNodeAttribute", (-600, -300 * index), attribute_name=name).outputs["Fac"]
            for index, name in enumerate(attributes)
        ]
    value = add_node(tree, "ShaderNodeAttribute", (-820, -300), attribute_name=attributes[0]).outputs["Fac"]
    convex = add_math(tree, "ShaderNodeMath", "MULTIPLY", (-640, -300), value, given["Radius"])
    return [add_math(tree, "ShaderNodeMath", "MULTIPLY", (-470, -100), convex, -1.0), convex]


# ---- The group in the user's own material


def base_shader(material: bpy.types.Material | None) -> bpy.types.Node | None:
    """The first Principled BSDF of a material whose output is used; its base color is what the material shows."""
    if material is None or material.node_tree is None:
        return None
    nodes = [node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"]
    return next((node for node in nodes if node.outputs[0].is_linked), None)


def own_node(shader: bpy.types.Node) -> bpy.types.Node | None:
    """The cavity group in front of a shader's base color, if it is there."""
    socket = shader.inputs["Base Color"]
    node = socket.links[0].from_node if socket.is_linked else None
    tree = getattr(node, "node_tree", None)
    return node if tree is not None and str(tree.get(MARK, "")).startswith(CAVITY_GROUP) else None


def plug(material: bpy.types.Material, mesh: bpy.types.Mesh) -> None:
    """Puts the cavity group between a material's base color and what it was before."""
    shader = base_shader(material)
    if shader is None:
        raise mesh_io.refuse("The active material has no Principled BSDF in use; make the Paradesc material instead.")
    if own_node(shader) is not None:
        raise mesh_io.refuse(f'The material "{material.name}" has the cavity group already.')
    group, settings = cavity_group(mesh)
    tree, socket = material.node_tree, shader.inputs["Base Color"]
    place = (shader.location.x - 230, shader.location.y - 60)
    node = add_group(tree, group, settings, place)
    node.inputs["Base Color"].default_value = socket.default_value
    if socket.is_linked:
        tree.links.new(socket.links[0].from_socket, node.inputs["Base Color"])
    tree.links.new(node.outputs["Color"], socket)


def unplug(material: bpy.types.Material) -> bool:
    """Takes the cavity group out of a material again; False where there is none."""
    shader = base_shader(material)
    node = None if shader is None else own_node(shader)
    if node is None:
        return False
    tree, socket = material.node_tree, shader.inputs["Base Color"]
    if node.inputs["Base Color"].is_linked:
        tree.links.new(node.inputs["Base Color"].links[0].from_socket, socket)
    socket.default_value = node.inputs["Base Color"].default_value
    tree.nodes.remove(node)
    return True


# ---- Operators


class PARADESC_OT_make_material(recolor.NeedsBake, bpy.types.Operator):
    """Show a descriptor by a material on a slot of its own; your materials stay, and Remove gives the faces back"""

    bl_idname = "paradesc.make_material"
    bl_label = "Material"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    kind: bpy.props.EnumProperty(
        name="Kind",
        description="What the material shows",
        items=[
            ("colors", "Colors", "The colors of the descriptor that is shown, lit as the scene is"),
            ("flat", "Flat Colors", "The colors exactly as the legend has them, without light"),
            ("cavity", "Cavity", "A clay with dirt in its hollows and worn edges"),
        ],
        default="colors",
    )

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Makes the material and gives it to all faces."""
        mesh = target.data
        name = recolor.shown_name(mesh) or recolor.baked_names(mesh)[0]
        made = cavity_material(mesh) if self.kind == "cavity" else color_material(name, self.kind == "flat")
        for sentence in assign(mesh, made):
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
            raise mesh_io.refuse(f'The object "{target.name}" has no active material; make the Paradesc material.')
        if material.library is not None or material.override_library is not None:
            raise mesh_io.refuse(f'The material "{material.name}" is linked from another file; make it local first.')
        plug(material, target.data)


class PARADESC_OT_remove_material(recolor.NeedsBake, bpy.types.Operator):
    """Give all faces their former materials again, and take the cavity group out of them"""

    bl_idname = "paradesc.remove_material"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}
    whole_selection = True

    def run(self, _context: bpy.types.Context, target: bpy.types.Object) -> None:
        """Removes what the other two made."""
        for sentence in take_back(target.data):
            self.report({"INFO"}, said(sentence))
        for slot in target.material_slots:
            if slot.material is not None and DESCRIPTOR not in slot.material and slot.material.library is None:
                unplug(slot.material)


classes = (PARADESC_OT_make_material, PARADESC_OT_plug_cavity, PARADESC_OT_remove_material)
