"""Builds the materials: each a surface whose colors go through Paradesc Wear, which reads the masks of a bake."""

import bpy
from graph import Graph

from paradesc_blender.show import wear


class Look:
    """A material under way: its tree, the node of wear and the shader."""

    def __init__(self, name: str, seed: float, **values: object) -> None:
        """Begins with the wear between the masks and the shader; values: inputs of the group, _ for spaces."""
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        g = self.graph = Graph(self.material.node_tree)
        inputs = {name: self.mask(descriptor) for name, descriptor in wear.MASKS.items()}
        inputs |= {word.replace("_", " "): value for word, value in values.items()}
        self.wear = g.node("ShaderNodeGroup", node_tree=bpy.data.node_groups[wear.GROUP], name=wear.GROUP, width=220)
        for name, value in inputs.items():
            g.put(self.wear.inputs[name], value)
        passed = {word: self.wear.outputs[end] for word, end in wear.PASSED.items()}
        self.shader = g.node("ShaderNodeBsdfPrincipled", passed)
        g.node("ShaderNodeOutputMaterial", {"Surface": self.shader.outputs[0]})
        generated = g.node("ShaderNodeTexCoord").outputs["Generated"]
        self.place = g.vector("ADD", generated, (seed, seed, seed))

    def mask(self, descriptor: str) -> bpy.types.NodeSocket:
        """A mask at vertices, in whose place an image may come."""
        color = self.graph.attribute(f"{descriptor}_color")
        color.node[wear.OF_VERTICES] = descriptor
        return color

    def colored(self, *colors: tuple[float, float, float], scale: float, roughness: tuple[float, float]) -> None:
        """Gives the base color and roughness that noise varies between two or three values."""
        g = self.graph
        spots = g.noise(self.place, scale, 8.0, 0.65)
        color = g.mix(spots, (*colors[0], 1), (*colors[1], 1), "Base Color", "MIX")
        if len(colors) > 2:
            color = g.mix(g.noise(self.place, 0.3 * scale), color, (*colors[2], 1), "Base Color", "MIX")
        g.put(self.wear.inputs["Base Color"], color)
        g.put(self.wear.inputs["Roughness"], g.ramp_to(spots, *roughness))

    def bumped(self, height: bpy.types.NodeSocket, strength: float, distance: float) -> None:
        """Bends the normals by a height; the distance suits an object of two meters."""
        bump = self.graph.node("ShaderNodeBump", {"Strength": strength, "Distance": distance, "Height": height})
        self.graph.put(self.shader.inputs["Normal"], bump.outputs[0])

    def finished(self) -> bpy.types.Material:
        """The material, whose wear is as we left it."""
        wear.dress(self.wear, wear.values_of(self.wear))
        self.graph.finished()
        return self.material


def painted_metal() -> bpy.types.Material:
    """Blue paint that is gone from the edges down to bare steel, with grime in the hollows."""
    look = Look(
        "Painted Metal", 0.0, Own_Colors=0.0, Dirt_Color=(0.028, 0.021, 0.016, 1), Dirt_Amount=0.9, Dirt_Level=0.38,
        Dirt_Contrast=0.15, Dirt_Roughness=0.95, Edge_Color=(0.66, 0.64, 0.61, 1), Edge_Amount=1.0, Edge_Level=0.32,
        Edge_Contrast=0.82, Edge_Roughness=0.4, Edge_Metallic=1.0, Edge_Rim=0.75, Dust_on_Top=0.12, Noise_Scale=28.0,
        Noise_Breakup=0.9,
    )  # fmt: skip
    look.colored((0.03, 0.115, 0.185), (0.055, 0.175, 0.265), scale=7.0, roughness=(0.3, 0.52))
    chips = look.graph.math("SUBTRACT", 1.0, look.wear.outputs["Wear"])
    look.bumped(chips, 0.5, 0.012)
    return look.finished()


def old_stone() -> bpy.types.Material:
    """Weathered stone: pale worn edges, dark and mossy hollows."""
    look = Look(
        "Old Stone", 3.1, Own_Colors=0.0, Dirt_Color=(0.028, 0.032, 0.014, 1), Dirt_Amount=0.92, Dirt_Level=0.26,
        Dirt_Contrast=0.1, Dirt_Roughness=1.0, Edge_Color=(0.56, 0.52, 0.44, 1), Edge_Amount=0.85, Edge_Level=0.36,
        Edge_Contrast=0.35, Edge_Roughness=0.85, Edge_Metallic=0.0, Edge_Rim=0.0, Dust_on_Top=0.0, Noise_Scale=16.0,
        Noise_Breakup=0.8,
    )  # fmt: skip
    look.colored((0.13, 0.118, 0.102), (0.25, 0.232, 0.20), (0.19, 0.148, 0.108), scale=9.0, roughness=(0.8, 0.95))
    g = look.graph
    pits = g.node("ShaderNodeTexVoronoi", {"Vector": look.place, "Scale": 34.0}).outputs["Distance"]
    rough = g.math("ADD", g.noise(look.place, 20.0, 10.0, 0.7), g.math("MULTIPLY", pits, 0.6))
    look.bumped(rough, 0.6, 0.02)
    return look.finished()


def dusty_plastic() -> bpy.types.Material:
    """Plastic whose edges are scuffed, with pale dust in the hollows and on top."""
    look = Look(
        "Dusty Plastic", 5.7, Own_Colors=0.0, Dirt_Color=(0.42, 0.385, 0.335, 1), Dirt_Amount=0.8, Dirt_Level=0.45,
        Dirt_Contrast=0.0, Dirt_Roughness=1.0, Edge_Color=(0.62, 0.61, 0.59, 1), Edge_Amount=0.55, Edge_Level=0.4,
        Edge_Contrast=0.5, Edge_Roughness=0.55, Edge_Metallic=0.0, Edge_Rim=0.0, Dust_on_Top=0.6, Noise_Scale=22.0,
        Noise_Breakup=0.7,
    )  # fmt: skip
    look.colored((0.44, 0.065, 0.02), (0.52, 0.09, 0.032), scale=6.0, roughness=(0.26, 0.38))
    return look.finished()
