"""The picture of high to low: a sculpt, its low-poly mesh, and the mask of the one on the other, rendered by Cycles."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
import renders
import subjects

from paradesc.files import lettering, png

CLAY, DIRT = (0.62, 0.57, 0.5, 1), (0.03, 0.02, 0.012, 1)


def add_sculpt(low: bpy.types.Object) -> bpy.types.Object:
    """A sculpt of the low-poly mesh: divided, with scales in its skin."""
    made = low.copy()
    made.data, made.name = low.data.copy(), "suzanne_high"
    bpy.context.collection.objects.link(made)
    made.modifiers.new("divided", "SUBSURF").levels = 5
    texture = bpy.data.textures.new("scales", "VORONOI")
    texture.noise_scale = 0.1
    scales = made.modifiers.new("scales", "DISPLACE")
    scales.texture, scales.strength, scales.mid_level = texture, -0.05, 0.3
    return made


def material(name: str, image: bpy.types.Image | None) -> bpy.types.Material:
    """Clay, with dirt where an image is white."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    shader = tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value, shader.inputs["Roughness"].default_value = CLAY, 0.6
    if image is not None:
        node, mix = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMixRGB")
        node.image = image
        mix.inputs["Color1"].default_value, mix.inputs["Color2"].default_value = CLAY, DIRT
        tree.links.new(node.outputs["Color"], mix.inputs["Fac"])
        tree.links.new(mix.outputs["Color"], shader.inputs["Base Color"])
    return made


def render_onto(path: str) -> None:
    """Three views beside each other, each with its name: what was sculpted, the low-poly mesh, and its texture."""
    low = subjects.monkey(levels=0)
    low.name = "suzanne_low"
    high = add_sculpt(low)
    settings = bpy.context.scene.paradesc
    settings.descriptors, settings.texels, settings.radius_percent = {"cavity"}, 2048, 1.0
    bpy.ops.paradesc.bake_onto()
    renders.set_up(renders.WIDTH, renders.HEIGHT, 96, clear=True)
    lens = bpy.context.scene.camera.data
    lens.lens, lens.shift_x = 88, -0.08
    clay, mask = material("clay", None), material("mask", bpy.data.images["suzanne_low_cavity"])
    faces = f"low poly, {len(low.data.polygons):,} faces"
    views = (("sculpt", high, clay), (faces, low, clay), ("the same, with its mask", low, mask))
    image = np.full((renders.HEIGHT + renders.LABEL, len(views) * renders.WIDTH, 3), renders.NIGHT, np.uint8)
    with tempfile.TemporaryDirectory() as folder:
        for index, (words, shown, of) in enumerate(views):
            left = index * renders.WIDTH
            file = str(Path(folder) / f"{index}.png")
            low.hide_render, high.hide_render = shown != low, shown != high
            shown.data.materials.clear()
            shown.data.materials.append(of)
            renders.render(file)
            image[: renders.HEIGHT, left : left + renders.WIDTH] = renders.over_night(file)
            middle = left + (renders.WIDTH - lettering.text_width(words, 2)) // 2
            lettering.draw_text(image, words, middle, renders.HEIGHT, 2, renders.WORDS)
    png.write_png(Path(path), image)
