"""The pictures of assets: paint before and after wear, masks, radii and levels, textures, and what others need."""

import math
from collections.abc import Sequence

import bpy
import numpy as np
import studio
import subjects
from PIL import Image
from studio import View
from subjects import models

from paradesc import bridge
from paradesc_blender.settings.presets import PRESETS
from paradesc_blender.show.wear import LOOKS

MASKS = {"cavity": "cavity", "edge_wear": "convexity", "openness": "ambient_openness", "curvature": "mean_curvature"}
LABELS = {"cavity": "Cavity", "edge_wear": "Edge Wear", "openness": "Openness", "curvature": "Curvature"}
SAMPLES, FLAT_SAMPLES = 24, 10
RED, GREEN, STONE, SKIN = (0.4, 0.02, 0.014), (0.035, 0.07, 0.03), (0.24, 0.22, 0.19), (0.09, 0.14, 0.04)
BLUE = (0.03, 0.08, 0.2)


def bake(item: bpy.types.Object, mask: str) -> str:
    """Bakes a mask by one click, as the panel's button does; gives the name of its colors."""
    studio.select([item])
    bpy.ops.paradesc.bake(mask=mask)
    return f"{MASKS[mask]}_color"


def wear(item: bpy.types.Object, look: str) -> None:
    """One click on Add Wear."""
    studio.select([item])
    bpy.ops.paradesc.add_wear(look=look)


# ---- README


def dress_car(car: bpy.types.Object, color: Sequence[float]) -> None:
    """Rubber tires, dark windows and bare metal where a car has them; paint is the active material."""
    car.data.materials.clear()
    studio.paint(car, color, 0.3)
    studio.paint(car, (0.012, 0.012, 0.013), 0.7)
    studio.paint(car, (0.01, 0.014, 0.02), 0.08)
    studio.paint(car, (0.6, 0.6, 0.6), 0.2, 1.0)
    centers = np.empty(3 * len(car.data.polygons), np.float32)
    car.data.polygons.foreach_get("center", centers)
    car.data.polygons.foreach_set("material_index", models.car_parts(centers.reshape(-1, 3)).astype(np.int32))
    car.active_material_index = 0


def draw_hero(path: str) -> None:
    """Four assets in plain paint, and after one click each."""
    made = group_of_assets()
    size, view = (955, 760), View(-12, 11, 0.03, 75)
    tiles = [studio.tile(made, size, view, SAMPLES, lit=True)]
    for item, look in zip(made, ("PAINTED_METAL", "OLD_STONE", "PAINTED_METAL", "AS_IS"), strict=True):
        wear(item, look)
    tiles.append(studio.tile(made, size, view, SAMPLES, lit=True))
    studio.save(studio.sheet(tiles, ("Plain paint", "After one click each: Add Wear to Material"), 2), path)


def group_of_assets() -> list[bpy.types.Object]:
    """A car, a stone and a crate with a goblin's bust on it."""
    studio.clear()
    car, stone, crate = models.car(0.0095), models.stone(0.01), models.crate()
    creature = models.creature(0.01)
    dress_car(car, RED)
    for item, color, roughness in ((stone, STONE, 0.9), (crate, GREEN, 0.5), (creature, SKIN, 0.55)):
        studio.paint(item, color, roughness)
    place(car, (-0.42, -0.75, 0), 1.05, -62)
    place(stone, (-0.95, 0.75, 0.0), 1.0, 10)
    place(crate, (0.95, 0.1, 0), 1.0, 24)
    place(creature, (0.95, 0.1, 1.04), 0.46, 2)
    return [car, stone, crate, creature]


def place(item: bpy.types.Object, where: tuple, scale: float, turn: float) -> None:
    """Stands a new object there by its lowest point, scaled and turned around z."""
    low = float(studio.corners_of([item])[:, 2].min())
    item.location, item.scale = (where[0], where[1], where[2] - scale * low), (scale,) * 3
    item.rotation_euler.z = math.radians(turn)
    bpy.context.view_layer.update()


# ---- Masks


def draw_masks(path: str) -> None:
    """The four masks of one asset."""
    studio.clear()
    item, tiles = models.creature(0.011), []
    for mask in MASKS:
        studio.show_color(item, bake(item, mask))
        tiles.append(studio.tile([item], (475, 470), View(-16, 4, 0.02), FLAT_SAMPLES, lit=False))
    studio.save(studio.sheet(tiles, list(LABELS.values()), 4), path)


def draw_radii(path: str) -> None:
    """One mask at the three radii that fit, and one at three levels."""
    studio.clear()
    item, tiles = models.stone(0.01), []
    group, looks, view = bpy.context.scene.paradesc, bpy.context.scene.paradesc_looks, View(-16, 6, 0.0)

    def shown(**levels: float | bool) -> None:
        for name in ("contrast", "brightness", "invert"):
            setattr(looks, name, levels.get(name, type(getattr(looks, name))()))
        tiles.append(studio.tile([item], (475, 620), view, FLAT_SAMPLES, lit=False))

    for size in ("fine", "medium", "broad"):
        group.radius_fit = size
        studio.show_color(item, bake(item, "cavity"))
        shown()
    group.radius_fit = "medium"
    bake(item, "cavity")
    for levels in ({"contrast": 0.6}, {"brightness": 0.4}, {"invert": True}):
        shown(**levels)
    words = ("Fine", "Medium", "Broad", "Contrast 0.6", "Brightness 0.4", "Invert")
    studio.save(studio.sheet(tiles, words, 3), path)


def draw_looks(path: str) -> None:
    """The three looks of wear on a character and on a prop, which had no material."""
    tiles = []
    for make, view in ((models.creature, View(-24, 5, 0.02)), (models.crate, View(-36, 20, 0.02))):
        for look in LOOKS:
            studio.clear()
            item = make()
            item.data.materials.clear()
            wear(item, look)
            tiles.append(studio.tile([item], (630, 560), view, SAMPLES, lit=True))
    studio.save(studio.sheet(tiles, (*LOOKS.values(), *LOOKS.values()), len(LOOKS)), path)


def draw_creases(path: str) -> None:
    """Mean curvature of a machine part and of a goblin without and with creases, each in one range of colors."""
    group, looks, tiles = bpy.context.scene.paradesc, bpy.context.scene.paradesc_looks, []
    looks.span = "fixed"
    for make, percent, reach, view in (
        (subjects.machine_part, 4.0, 6.0, View(0, 30)),
        (subjects.creature, 2.0, 8.0, View(-10, 6)),
    ):
        item = make()
        group.radius_percent, looks.minimum, looks.maximum = percent, -reach, reach
        for group.creases in ("none", "auto"):
            studio.show_color(item, bake(item, "curvature"))
            tiles.append(studio.tile([item], (630, 480), view, FLAT_SAMPLES, lit=False))
    studio.save(studio.sheet(tiles, ("Creases: None", "Creases: Automatic") * 2, 2), path)


def draw_presets(path: str) -> None:
    """The first descriptor of each preset."""
    studio.clear()
    item, tiles = models.helmet(), []
    studio.select([item])
    for name, preset in PRESETS.items():
        bpy.ops.paradesc.preset(name=name)
        bpy.ops.paradesc.bake()
        first = next(row.name for row in bridge.descriptors() if row.name in preset.settings["descriptors"])
        studio.show_color(item, f"{first}_color")
        tiles.append(studio.tile([item], (475, 480), View(-28, 8), FLAT_SAMPLES, lit=False))
    studio.save(studio.sheet(tiles, [preset.name for preset in PRESETS.values()], -(-len(tiles) // 2)), path)


def decimate(item: bpy.types.Object, ratio: float) -> None:
    """Leaves so much of the faces."""
    studio.select([item])
    modifier = item.modifiers.new("decimate", "DECIMATE")
    modifier.ratio = ratio
    bpy.ops.object.modifier_apply(modifier=modifier.name)


# ---- Images


def image_of(item: bpy.types.Object, mask: str, texels: int = 2048, packed: bool = False) -> bpy.types.Image:
    """Bakes a mask to an image by the panel's button; gives the image."""
    group = bpy.context.scene.paradesc
    bpy.ops.paradesc.mask(name=mask)
    group.texels, group.image_packed = texels, packed
    before = set(bpy.data.images.keys())
    studio.select([item])
    bpy.ops.paradesc.bake_image()
    return bpy.data.images[(set(bpy.data.images.keys()) - before).pop()]


def wear_by_images(item: bpy.types.Object, look: str, **images: bpy.types.Image) -> None:
    """One click on Add Wear; then images lie on the group's sockets, Cavity and Edges, instead of attributes."""
    wear(item, look)
    tree = item.active_material.node_tree
    node = next(node for node in tree.nodes if node.type == "GROUP" and "Edges" in node.inputs)
    for name in ("Cavity", "Edges"):
        if name in images:
            texture = tree.nodes.new("ShaderNodeTexImage")
            texture.image = images[name]
            tree.links.new(texture.outputs["Color"], node.inputs[name])
        else:
            for link in node.inputs[name].links:
                tree.links.remove(link)
            node.inputs[name].default_value = 0.0


def draw_low_poly(path: str) -> None:
    """A house without bevels: as it is, its edges in an image, and worn by the image."""
    studio.clear()
    item, view, size = models.house(), View(-36, 14), (630, 600)
    models.unwrap(item)
    studio.paint(item, BLUE, 0.5)
    tiles = [studio.tile([item], size, view, SAMPLES, lit=True)]
    material = item.active_material
    bpy.context.scene.paradesc.radius_fit = "fine"
    image = image_of(item, "edge_wear")
    studio.show_image(item, image)
    tiles.append(studio.tile([item], size, view, FLAT_SAMPLES, lit=False))
    item.data.materials.clear()
    item.data.materials.append(material)
    wear(item, "PAINTED_METAL")
    tiles.append(studio.tile([item], size, view, SAMPLES, lit=True))
    item.data.calc_loop_triangles()
    words = (
        f"{len(item.data.loop_triangles)} triangles, no bevel",
        "Edge Wear, baked to an image",
        "Add Wear to Material",
    )
    studio.save(studio.sheet(tiles, words, 3), path)


def draw_onto(path: str) -> None:
    """A sculpt, a low-poly mesh of it, and that mesh with the masks of the sculpt."""
    studio.clear()
    high = models.stone(0.009)
    low = high.copy()
    low.data = high.data.copy()
    bpy.context.collection.objects.link(low)
    high.name, low.name = "stone_high", "stone_low"
    decimate(low, 0.004)
    models.unwrap(low)
    for item in (high, low):
        item.data.materials.clear()
        studio.paint(item, STONE, 0.9)
        count = len(item.data.polygons)
    view, size, group = View(-18, 8), (630, 640), bpy.context.scene.paradesc
    tiles = [studio.tile([item], size, view, SAMPLES, lit=True) for item in (high, low)]
    images, group.texels = {}, 2048
    for mask, socket in (("cavity", "Cavity"), ("edge_wear", "Edges")):
        bpy.ops.paradesc.mask(name=mask)
        before = set(bpy.data.images.keys())
        studio.select([high, low])
        bpy.ops.paradesc.bake_onto()
        images[socket] = bpy.data.images[(set(bpy.data.images.keys()) - before).pop()]
    wear_by_images(low, "OLD_STONE", **images)
    tiles.append(studio.tile([low], size, view, SAMPLES, lit=True))
    words = (
        f"Sculpt, {len(high.data.polygons):,} faces",
        f"Low poly, {count:,} faces",
        "Low poly with its textures",
    )
    studio.save(studio.sheet(tiles, words, 3), path)


def draw_trouble(path: str) -> None:
    """Faces that are too large for values at vertices, and the same in an image."""
    studio.clear()
    item, view, size = models.gear(), View(-28, 12, 0.0), (630, 560)
    models.unwrap(item)
    studio.show_color(item, bake(item, "edge_wear"))
    tiles = [studio.tile([item], size, view, FLAT_SAMPLES, lit=False)]
    studio.show_image(item, image_of(item, "edge_wear"))
    tiles.append(studio.tile([item], size, view, FLAT_SAMPLES, lit=False))
    studio.save(studio.sheet(tiles, ("At vertices: large faces turn white", "Baked to an image"), 2), path)


def pixels_of(image: bpy.types.Image) -> Image.Image:
    """An image as it is, top row first."""
    width, height = image.size
    pixels = np.empty(4 * width * height, np.float32)
    image.pixels.foreach_get(pixels)
    bytes_of = np.round(255 * np.clip(pixels.reshape(height, width, 4)[::-1, :, :3], 0, 1)).astype(np.uint8)
    return Image.fromarray(bytes_of)


def draw_textures(path: str) -> None:
    """The images that Bake to Image leaves of the gear: edges, cavity, and three masks in one."""
    studio.clear()
    item, tiles = models.gear(), []
    models.unwrap(item)
    for mask, packed in (("edge_wear", False), ("cavity", False), ("cavity", True)):
        image = image_of(item, mask, 1024, packed)
        tiles.append(pixels_of(image).resize((630, 630), Image.LANCZOS))
    studio.save(studio.sheet(tiles, ("gear_edges", "gear_cavity", "gear_masks: packed channels"), 3), path)


def draw_export(path: str) -> None:
    """Cavity, edges and openness, and the three packed into the channels of one color attribute."""
    studio.clear()
    item, tiles, looks = models.helmet(), [], bpy.context.scene.paradesc_looks
    names = ("cavity", "edge_wear", "openness")
    for mask in names:
        bake(item, mask)
    looks.pack_red, looks.pack_green, looks.pack_blue, looks.pack_alpha = "cavity", "convexity", "ambient_openness", ""
    bpy.ops.paradesc.pack()
    for color in (*(f"{MASKS[mask]}_color" for mask in names), looks.pack_name):
        studio.show_color(item, color)
        tiles.append(studio.tile([item], (475, 480), View(-28, 8), FLAT_SAMPLES, lit=False))
    words = ("Cavity: red", "Edge Wear: green", "Openness: blue", "Packed")
    studio.save(studio.sheet(tiles, words, 4), path)


# ---- Live


def draw_live(path: str) -> None:
    """A caterpillar that bends, its curvature live, as a GIF."""
    studio.clear()
    item = models.caterpillar()
    item.rotation_euler.y = math.radians(90)
    bend = item.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis = "BEND", "Y"
    frames, scene = 20, bpy.context.scene
    for frame, angle in ((1, -2.2), (frames // 2 + 1, 2.2), (frames + 1, -2.2)):
        bend.angle = angle
        bend.keyframe_insert("angle", frame=frame)
    scene.frame_set(frames // 4 + 1)
    studio.show_color(item, bake(item, "curvature"))
    item.paradesc_live.mode = "LIVE"
    tiles, reach = [], []
    for frame in (1, frames // 4 + 1, frames // 2 + 1):
        scene.frame_set(frame)
        reach.append(studio.corners_of([item]))
    for frame in range(1, frames + 1):
        scene.frame_set(frame)
        tiles.append(studio.tile([item], (720, 420), View(0, 0), 8, lit=False, points=np.concatenate(reach)))
    palette = tiles[0].quantize(64)
    tiles = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in tiles]
    tiles[0].save(path, save_all=True, append_images=tiles[1:], duration=80, loop=0, optimize=True)


KINDS = {
    "hero": draw_hero,
    "masks": draw_masks,
    "radii": draw_radii,
    "looks": draw_looks,
    "creases": draw_creases,
    "presets": draw_presets,
    "trouble": draw_trouble,
    "low_poly": draw_low_poly,
    "onto": draw_onto,
    "textures": draw_textures,
    "export": draw_export,
    "live": draw_live,
}
