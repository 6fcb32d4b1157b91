"""Builds the node groups; each function says what its group does."""

import bpy
from graph import Graph

from paradesc_blender.scene import node_groups

# Scene-linear.
DIRT, BARE, CLAY, WORN = (0.10, 0.075, 0.055, 1), (0.32, 0.31, 0.30, 1), (0.35, 0.20, 0.11, 1), (0.78, 0.62, 0.46, 1)
WHITE = (0.8, 0.8, 0.8, 1)


def new_group(name: str, kind: str = "ShaderNodeTree") -> Graph:
    """An empty group that the add-on finds by its mark."""
    return Graph(node_groups.new_group(kind, name))


# ---- Wear


def wear() -> bpy.types.NodeTree:
    """Dirt where Cavity is high and wear where Edges is high, both broken up by noise."""
    g = new_group("Paradesc Wear")
    base = g.add_input("Base Color", "color", WHITE, "The surface where it is neither dirty nor worn")
    rough = g.add_input("Roughness", "share", 0.5)
    metal = g.add_input("Metallic", "share", 0.0)
    cavity = g.add_input("Cavity", "float", 0.0, "Mask of hollows: an attribute or an image", 1e6, -1e6)
    edges = g.add_input("Edges", "float", 0.0, "Mask of edges: an attribute or an image", 1e6, -1e6)
    own = g.add_input("Own Colors", "share", 1.0, "Dirt darkens and wear brightens the base color, instead of covering")
    dirt_color = g.add_input("Dirt Color", "color", DIRT)
    dirt_amount = g.add_input("Dirt Amount", "share", 0.9)
    dirt_level = g.add_input("Dirt Level", "share", 0.3, "The value of the mask that is half dirty")
    dirt_contrast = g.add_input("Dirt Contrast", "share", 0.4, "0: soft, 1: a hard border")
    dirt_rough = g.add_input("Dirt Roughness", "share", 0.9)
    edge_color = g.add_input("Edge Color", "color", BARE)
    edge_amount = g.add_input("Edge Amount", "share", 0.9)
    edge_level = g.add_input("Edge Level", "share", 0.5, "The value of the mask that is half worn")
    edge_contrast = g.add_input("Edge Contrast", "share", 0.7, "0: soft, 1: a hard border")
    edge_rough = g.add_input("Edge Roughness", "share", 0.4)
    edge_metal = g.add_input("Edge Metallic", "share", 0.0)
    rim = g.add_input("Edge Rim", "share", 0.3, "Dirt along the border of what is worn")
    dust = g.add_input("Dust on Top", "share", 0.0, "The color of dirt on what looks up, too")
    scale = g.add_input("Noise Scale", "float", 18.0, "Spots along the diagonal of the object's box", 1e4)
    breakup = g.add_input("Noise Breakup", "share", 0.7, "Strength of the noise that breaks up masks; 0: smooth")
    box = g.add_input(
        "Proportions", "vector", (0.58, 0.58, 0.58), "Sides of the object's box as shares of its diagonal"
    )

    place = g.vector("MULTIPLY", g.node("ShaderNodeTexCoord").outputs["Generated"], box)
    coarse = g.noise(place, scale, 10.0, 0.7)
    fine = g.noise(g.vector("ADD", place, (7.3, 1.9, 4.1)), g.math("MULTIPLY", scale, 2.2), 10.0, 0.7)
    softer = g.math("MULTIPLY", breakup, 0.6)  # dirt lies in spots, not in dashes along a hollow
    dirt = g.math("MULTIPLY", leveled(g, cavity, coarse, softer, dirt_level, dirt_contrast, "Dirt"), dirt_amount)
    worn = leveled(g, edges, fine, breakup, edge_level, edge_contrast, "Wear")
    border = g.math("MULTIPLY", g.math("MULTIPLY", worn, g.math("SUBTRACT", 1.0, worn)), 4.0)
    worn = g.math("MULTIPLY", worn, edge_amount)
    up = g.node("ShaderNodeSeparateXYZ", {0: g.node("ShaderNodeNewGeometry").outputs["Normal"]}).outputs["Z"]
    settled = g.math("MULTIPLY", g.ramp(up, 0.2, 1.0, "Looks up", "SMOOTHSTEP"), g.mix(breakup, 1.0, coarse))
    dirt = g.math("MAXIMUM", dirt, g.math("MULTIPLY", settled, dust))
    dirt = g.math("MAXIMUM", dirt, g.math("MULTIPLY", g.math("MULTIPLY", border, edge_amount), rim))

    edge_color = g.mix(own, edge_color, g.mix(1.0, base, edge_color, blend="SCREEN"), "Edge Color", "MIX")
    dirt_color = g.mix(own, dirt_color, g.mix(1.0, base, dirt_color, blend="MULTIPLY"), "Dirt Color", "MIX")
    color = g.mix(dirt, g.mix(worn, base, edge_color, "Worn", "MIX"), dirt_color, "Dirty", "MIX")
    worn_rough = g.mix(worn, rough, g.mix(own, edge_rough, rough))
    worn_metal = g.mix(worn, metal, g.mix(own, edge_metal, metal))
    g.add_output("Color", "color", color)
    g.add_output("Roughness", "float", g.mix(dirt, worn_rough, dirt_rough))
    g.add_output("Metallic", "float", g.mix(dirt, worn_metal, 0.0))
    g.add_output("Dirt", "float", dirt, "0: clean, 1: dirty")
    g.add_output("Wear", "float", worn, "0: whole, 1: worn")
    return g.finished()


def leveled(
    g: Graph,
    mask: bpy.types.NodeSocket,
    noise: bpy.types.NodeSocket,
    breakup: bpy.types.NodeSocket,
    level: bpy.types.NodeSocket,
    contrast: bpy.types.NodeSocket,
    label: str,
) -> bpy.types.NodeSocket:
    """The mask times noise about 1, brought to between 0 and 1; what is 0 stays 0."""
    broken = g.math("MULTIPLY", mask, g.mix(breakup, 1.0, g.math("MULTIPLY", noise, 2.0)))
    half = g.math("MULTIPLY_ADD", contrast, -0.49, 0.5)
    low = g.math("MAXIMUM", g.math("SUBTRACT", level, half), 0.0)
    return g.ramp(broken, low, g.math("ADD", level, half), label, "SMOOTHSTEP")


# ---- Curvature


def curvature() -> bpy.types.NodeTree:
    """The sockets of the Curvature node that is announced for Cycles, from what was baked."""
    g = new_group("Curvature")
    about = "The radius of the bake, for the record: a group cannot measure again"
    g.add_input("Radius", "float", 0.01, about, 1e6)
    bias = g.add_input("Bias", "float", 0.0, "Added to what is convex, taken from what is concave", 1.0, -1.0)
    convex, concave = g.attribute("convexity_color"), g.attribute("cavity_color")
    signed = g.math("ADD", g.math("SUBTRACT", convex, concave), bias)
    convex = g.math("MAXIMUM", signed, 0.0, use_clamp=True)
    concave = g.math("MULTIPLY", signed, -1.0, use_clamp=True)
    both = g.node("ShaderNodeCombineColor", {"Red": convex, "Green": concave, "Blue": 0.0}).outputs[0]
    g.add_output("Curvature", "float", g.math("MULTIPLY_ADD", signed, 0.5, 0.5, use_clamp=True), "0.5: flat")
    g.add_output("Convexity", "float", convex)
    g.add_output("Concavity", "float", concave)
    g.add_output("Both", "color", both, "Red: convex, green: concave")
    return g.finished()


# ---- Cavity: what the Materials panel makes


def cavity() -> bpy.types.NodeTree:
    """Masks of the raw attributes, and dirt and wear on a base color."""
    return cavity_of("Paradesc Cavity", ("cavity", "convexity"))


def cavity_of_mean_curvature() -> bpy.types.NodeTree:
    """The same of mean curvature times radius, of either sign."""
    return cavity_of("Paradesc Cavity of mean_curvature", ("mean_curvature",))


def cavity_of(name: str, attributes: tuple[str, ...]) -> bpy.types.NodeTree:
    """Turns attributes into masks between 0 and 1, and mixes dirt and wear into a base color."""
    g = new_group(name)
    color = g.add_input("Base Color", "color", CLAY)
    colors = [g.add_input("Cavity Color", "color", (0.025, 0.014, 0.008, 1)), g.add_input("Edge Color", "color", WORN)]
    strengths = [g.add_input(f"{word} Strength", "float", 1.0) for word in ("Cavity", "Edge")]
    # The masks begin and are full at these values of curvature times radius: most of a surface is a little convex.
    ends = [
        [g.add_input(f"{word} {end}", "float", value) for end, value in (("Begin", begin), ("End", full))]
        for word, begin, full in (("Cavity", 0.03, 0.4), ("Edge", 0.2, 0.7))
    ]
    raw = [g.node("ShaderNodeAttribute", attribute_name=one).outputs["Fac"] for one in attributes]
    if len(raw) == 1:
        convex = g.math("MULTIPLY", raw[0], g.add_input("Radius", "float", 0.1, most=1e6))
        raw = [g.math("MULTIPLY", convex, -1.0), convex]
    rows = zip(("Cavity", "Edge"), raw, ends, strengths, colors, strict=True)
    for word, value, (begin, full), strength, tint in rows:
        # The larger of a value and 0, which is 0 if the value does not exist.
        mask = g.math("MULTIPLY", g.ramp(g.math("MAXIMUM", value, 0.0), begin, full, word), strength)
        color = g.mix(mask, color, tint, blend="MIX")
        g.add_output(word, "float", mask)
    g.add_output("Color", "color", color)
    return g.finished()


# ---- Geometry nodes


def swell() -> bpy.types.NodeTree:
    """Moves vertices along their normals by the value; the mask keeps those without a value in place."""
    g, value = reading("swell")
    distance = g.math("MULTIPLY", share(g, value, 0.0), g.add_input("Offset", "float", 0.02, "", 1e6, -1e6))
    normal = g.node("GeometryNodeInputNormal").outputs[0]
    offset = g.node("ShaderNodeVectorMath", {0: normal, "Scale": distance}, operation="SCALE").outputs[0]
    there = g.compare("LESS_THAN", g.named("paradesc_mask"), 0.5)
    moved = g.node("GeometryNodeSetPosition", {0: g.given["Geometry"], "Offset": offset, "Selection": there})
    return with_geometry(g, moved)


def keep() -> bpy.types.NodeTree:
    """Keeps what lies above a value and deletes the rest."""
    g, value = reading("keep")
    chosen = g.compare("GREATER_THAN", value, g.add_input("Above", "float", 0.75, "", 1e9, -1e9))
    return with_geometry(
        g, g.node("GeometryNodeSeparateGeometry", {0: g.given["Geometry"], "Selection": chosen}, domain="POINT")
    )


def mark() -> bpy.types.NodeTree:
    """Writes a boolean attribute, true above a value, that further nodes or a material can read."""
    g, value = reading("mark")
    chosen = g.compare("GREATER_THAN", value, g.add_input("Above", "float", 0.75, "", 1e9, -1e9))
    inputs = {0: g.given["Geometry"], "Name": "paradesc_selection"}
    node = g.node("GeometryNodeStoreNamedAttribute", inputs, data_type="BOOLEAN", domain="POINT")
    g.put(next(item for item in node.inputs if item.name == "Value" and item.type == "BOOLEAN"), chosen)
    return with_geometry(g, node)


def scatter() -> bpy.types.NodeTree:
    """Puts small spheres where the value is high, denser the higher it is: moss in hollows, for example."""
    g, value = reading("scatter")
    density = g.math("MULTIPLY", share(g, value, 0.25), g.add_input("Density", "float", 2000.0, "", 1e9))
    points = g.node(
        "GeometryNodeDistributePointsOnFaces", {0: g.given["Geometry"], "Density": density}, distribute_method="RANDOM"
    )
    ball = g.node("GeometryNodeMeshIcoSphere", {"Radius": g.add_input("Size", "float", 0.01, "", 1e6)})
    placed = g.node("GeometryNodeInstanceOnPoints", {0: points.outputs["Points"], "Instance": ball.outputs["Mesh"]})
    node = g.node("GeometryNodeJoinGeometry", {0: placed.outputs["Instances"]})
    g.put(node.inputs[0], g.given["Geometry"])
    return with_geometry(g, node)


def reading(kind: str) -> tuple[Graph, bpy.types.NodeSocket]:
    """A group of geometry nodes, and the value of the attribute whose name the add-on puts into it."""
    g = new_group(f"Paradesc {kind}", "GeometryNodeTree")
    g.add_input("Geometry", "geometry")
    return g, g.named("cavity", "Value")


def share(g: Graph, value: bpy.types.NodeSocket, begin: float) -> bpy.types.NodeSocket:
    """The place of the value between two inputs of the group."""
    ends = [g.add_input(f"From {end}", "float", at, "", 1e9, -1e9) for end, at in (("Min", begin), ("Max", 1.0))]
    return g.ramp(value, *ends)


def with_geometry(g: Graph, node: bpy.types.Node) -> bpy.types.NodeTree:
    """Ends a group of geometry nodes by what a node gives."""
    g.add_output("Geometry", "geometry", node.outputs[0])
    return g.finished()
