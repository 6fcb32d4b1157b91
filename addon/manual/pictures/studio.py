"""The studio of the manual's pictures, with one ground, light and font: objects → tiles by Cycles → a sheet."""

import math
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector
from PIL import Image, ImageDraw, ImageFont

GROUND = (61, 61, 61)  # as Blender's viewport
WORDS = (225, 225, 225)
FONT = Path(bpy.utils.system_resource("DATAFILES")) / "fonts" / "Inter.woff2"
TITLE, LETTERS, GAP = 60, 30, 10  # heights of a title and of its letters, and pixels between tiles
QUALITY = 88  # of JPEG files
KEY, RIM, SKY = 30.0, 26.0, 0.22  # watts of both lamps for objects as large as 1, and the light of the sky


@dataclass(frozen=True)
class View:
    """From where objects are seen: degrees around them and above, and how much of the picture they leave free."""

    around: float = -30.0
    above: float = 12.0
    margin: float = 0.05
    lens: float = 85.0


def clear() -> None:
    """Removes all objects of the scene."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)


def select(items: Sequence[bpy.types.Object]) -> None:
    """Selects these alone; the last is active."""
    bpy.ops.object.select_all(action="DESELECT")
    for item in items:
        item.select_set(True)
        bpy.context.view_layer.objects.active = item


def corners_of(items: Iterable[bpy.types.Object]) -> np.ndarray:
    """(n, 3) positions of all vertices in the world."""
    graph = bpy.context.evaluated_depsgraph_get()
    found = []
    for item in items:
        shown = item.evaluated_get(graph)
        points = np.empty(3 * len(shown.data.vertices), np.float32)
        shown.data.vertices.foreach_get("co", points)
        matrix = np.array(shown.matrix_world)
        found.append(points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
    return np.concatenate(found)


def set_up(width: int, height: int, samples: int, lit: bool) -> None:
    """Cycles on the processor, without a ground of its own; lit: for paint, else for colors that are themselves."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", samples
    scene.cycles.use_denoising, scene.cycles.max_bounces = lit, 4
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Filmic" if lit else "Standard"
    scene.view_settings.look = "Medium High Contrast" if lit else "None"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.image_settings.color_mode = "RGBA"
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (SKY, SKY * 1.03, SKY * 1.08, 1)


def aim(points: np.ndarray, view: View, lit: bool) -> list[bpy.types.Object]:
    """Places a camera that sees all of the points, lamps and a floor that catches shadows; gives these."""
    scene = bpy.context.scene
    around, above = math.radians(view.around), math.radians(view.above)
    way = Vector((math.sin(around) * math.cos(above), -math.cos(around) * math.cos(above), math.sin(above)))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera, camera.data.lens = camera, view.lens
    camera.rotation_euler = way.to_track_quat("Z", "Y").to_euler()
    graph = bpy.context.evaluated_depsgraph_get()
    place, _scale = camera.camera_fit_coords(graph, points.ravel().tolist())
    middle, size = Vector(points.mean(axis=0)), float(np.linalg.norm(np.ptp(points, axis=0)))
    camera.location = place + view.margin * 2 * (place - middle).length * way
    return [camera, *(add_light(points, view.around, size) if lit else ())]


def add_light(points: np.ndarray, around: float, size: float) -> list[bpy.types.Object]:
    """A large lamp in front, one behind, and the floor."""
    middle, placed = Vector((points.min(axis=0) + points.max(axis=0)) / 2), []
    for turn, above, watts, width in ((-48, 42, KEY, 0.7), (140, 35, RIM, 0.5)):
        lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
        flat, up = math.radians(around + turn), math.radians(above)
        way = Vector((math.sin(flat) * math.cos(up), -math.cos(flat) * math.cos(up), math.sin(up)))
        lamp.location = middle + 1.3 * size * way
        lamp.rotation_euler = way.to_track_quat("Z", "Y").to_euler()
        lamp.data.energy, lamp.data.size = watts * size * size, width * size
        placed.append(lamp)
    mesh = bpy.data.meshes.new("floor")
    side, low = 8 * size, float(points[:, 2].min())
    mesh.from_pydata(
        [(x, y, low) for x, y in ((-side, -side), (side, -side), (side, side), (-side, side))], [], [(0, 1, 2, 3)]
    )
    floor = bpy.data.objects.new("floor", mesh)
    floor.is_shadow_catcher = True
    placed.append(floor)
    for item in placed:
        bpy.context.scene.collection.objects.link(item)
    return placed


def tile(
    items: Sequence[bpy.types.Object],
    size: tuple[int, int],
    view: View,
    samples: int,
    lit: bool,
    points: np.ndarray | None = None,
) -> Image.Image:
    """A picture of the objects on the ground, lit or flat; points: what the camera has to see, if not the objects."""
    set_up(*size, samples, lit)
    placed = aim(corners_of(items) if points is None else points, view, lit)
    for item in bpy.context.scene.objects:
        item.hide_render = item not in items and item not in placed
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.render.filepath = str(Path(folder) / "tile.png")
        bpy.ops.render.render(write_still=True)
        seen = Image.open(bpy.context.scene.render.filepath).convert("RGBA")
    for item in placed:
        bpy.data.objects.remove(item)
    ground = Image.new("RGBA", seen.size, (*GROUND, 255))
    return Image.alpha_composite(ground, seen).convert("RGB")


# ---- Sheets


def sheet(tiles: Sequence[Image.Image], titles: Sequence[str], columns: int) -> Image.Image:
    """Tiles in rows, each above its title."""
    width, height = tiles[0].size
    rows = -(-len(tiles) // columns)
    made = Image.new("RGB", (columns * (width + GAP) - GAP, rows * (height + TITLE)), GROUND)
    draw, font = ImageDraw.Draw(made), ImageFont.truetype(str(FONT), LETTERS)
    for index, (picture, words) in enumerate(zip(tiles, titles, strict=True)):
        left, top = index % columns * (width + GAP), index // columns * (height + TITLE)
        made.paste(picture, (left, top))
        draw.text((left + width / 2, top + height + TITLE / 2), words, WORDS, font, anchor="mm")
    return made


def save(picture: Image.Image, path: str) -> None:
    """Writes a JPEG file."""
    picture.save(path, quality=QUALITY, optimize=True, progressive=True)


# ---- Materials


def paint(item: bpy.types.Object, color: Sequence[float], roughness: float = 0.45, metallic: float = 0.0) -> None:
    """A plain material of its own."""
    material = bpy.data.materials.new(item.name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Roughness"].default_value, shader.inputs["Metallic"].default_value = roughness, metallic
    item.data.materials.append(material)


def emit(item: bpy.types.Object, kind: str, output: str = "Color") -> bpy.types.Node:
    """Gives the object one material, whose light is the output of a new node; gives the node."""
    material = bpy.data.materials.new("mask")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, light, end = (tree.nodes.new(name) for name in (kind, "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    tree.links.new(node.outputs[output], light.inputs["Color"])
    tree.links.new(light.outputs["Emission"], end.inputs["Surface"])
    item.data.materials.clear()
    item.data.materials.append(material)
    return node


def show_color(item: bpy.types.Object, name: str) -> None:
    """Shows a color attribute, without light or shade."""
    emit(item, "ShaderNodeVertexColor").layer_name = name


def show_image(item: bpy.types.Object, image: bpy.types.Image) -> None:
    """Shows an image over the UV map, without light or shade."""
    emit(item, "ShaderNodeTexImage").image = image
