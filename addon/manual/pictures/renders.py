"""Pictures that Cycles renders: several descriptors side by side, and the ready cavity material."""

import math
import tempfile
from pathlib import Path

import bpy
import numpy as np
import subjects

from paradesc.files import lettering, png

# The picture of README: what each view shows, and its color map; the last is the ready material.
VIEWS = (
    ("mean_curvature", "auto"),
    ("shape_index", "auto"),
    ("ambient_openness", "purple-green"),
    ("cavity", "blue-yellow"),
    ("convexity", "heat"),
    ("cavity material", ""),
)
COLUMNS, WIDTH, HEIGHT, LABEL = 3, 310, 250, 24
NIGHT, WORDS = (33, 36, 41), (200, 204, 210)
SKY = (0.42, 0.46, 0.52, 1)


def set_up(width: int, height: int, samples: int, clear: bool) -> None:
    """Camera, lamp and sky around the monkey, and Cycles on the processor."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.0, -6.4, 0.7), (math.radians(84), 0, 0)
    camera.data.lens = 82
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
    lamp.location, lamp.rotation_euler = (-2.5, -3.5, 3.5), (math.radians(48), 0, math.radians(-35))
    lamp.data.energy, lamp.data.size = 190, 1.2
    for item in (camera, lamp):
        scene.collection.objects.link(item)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = SKY
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", samples
    scene.cycles.use_denoising, scene.render.film_transparent = False, clear
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.image_settings.color_mode = "RGBA" if clear else "RGB"
    scene.render.image_settings.compression = 100


def render(path: str) -> None:
    """The scene as it is, into a file."""
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def render_cavity(path: str) -> None:
    """The ready cavity material, with one lamp and a light sky."""
    subjects.baked_monkey("mean_curvature", "cavity", "convexity")
    bpy.ops.paradesc.make_material(kind="cavity")
    set_up(400, 360, 96, clear=False)
    render(path)


def render_hero(path: str) -> None:
    """Descriptors side by side, each with its name, on a dark ground."""
    made = subjects.baked_monkey(*(name for name, color_map in VIEWS if color_map))
    set_up(WIDTH, HEIGHT, 160, clear=True)
    lens = bpy.context.scene.camera.data
    lens.lens, lens.shift_x = 88, -0.08
    rows = -(-len(VIEWS) // COLUMNS)
    image = np.full((rows * (HEIGHT + LABEL), COLUMNS * WIDTH, 3), NIGHT, np.uint8)
    with tempfile.TemporaryDirectory() as folder:
        for index, (name, color_map) in enumerate(VIEWS):
            top, left = index // COLUMNS * (HEIGHT + LABEL), index % COLUMNS * WIDTH
            file = str(Path(folder) / f"{index}.png")
            show(made, name, color_map)
            render(file)
            image[top : top + HEIGHT, left : left + WIDTH] = over_night(file)
            words = name.replace("_", " ")
            middle = left + (WIDTH - lettering.text_width(words, 2)) // 2
            lettering.draw_text(image, words, middle, top + HEIGHT, 2, WORDS)
    png.write_png(Path(path), image)


def show(made: bpy.types.Object, name: str, color_map: str) -> None:
    """Gives the monkey a material that shows a descriptor in these colors, or the ready cavity material."""
    made.select_set(True)
    if not color_map:
        bpy.ops.paradesc.make_material(kind="cavity")
        return
    bpy.context.scene.paradesc_looks.color_map = color_map
    bpy.ops.paradesc.show(name=name)
    bpy.ops.paradesc.recolor()
    bpy.ops.paradesc.make_material(kind="colors")


def over_night(file: str) -> np.ndarray:
    """(height, width, 3) uint8: a rendered file with its transparent parts on the dark ground."""
    image = bpy.data.images.load(file)
    image.alpha_mode = "CHANNEL_PACKED"
    pixels = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], 4)[::-1]
    bpy.data.images.remove(image)
    color, share = 255 * pixels[..., :3], pixels[..., 3:]
    return np.round(color * share + np.array(NIGHT) * (1 - share)).clip(0, 255).astype(np.uint8)
