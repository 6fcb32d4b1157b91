"""The picture of wear: one material in its own colors, and the three looks, side by side."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
import renders
import subjects

from paradesc.files import png

LOOKS = ("AS_IS", "PAINTED_METAL", "OLD_STONE", "DUSTY_PLASTIC")
WIDTH, HEIGHT, SAMPLES = 320, 300, 128
OWN = (0.42, 0.30, 0.06, 1)  # of the material that has wear in its own colors


def render_wear(path: str) -> None:
    """The monkey with each look, on a dark ground."""
    made = subjects.monkey(3)
    renders.set_up(WIDTH, HEIGHT, SAMPLES, clear=True)
    bpy.context.scene.camera.data.lens = 84
    parts = []
    with tempfile.TemporaryDirectory() as folder:
        for look in LOOKS:
            made.data.materials.clear()
            if look == "AS_IS":
                made.data.materials.append(plain())
            bpy.ops.paradesc.add_wear(look=look)
            file = str(Path(folder) / f"{look}.png")
            renders.render(file)
            parts.append(renders.over_night(file))
    png.write_png(Path(path), np.ascontiguousarray(np.hstack(parts)))


def plain() -> bpy.types.Material:
    """A material of one color."""
    material = bpy.data.materials.new("own")
    material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = OWN
    return material
