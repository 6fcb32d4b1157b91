"""A picture of each asset for people to look at: Dirty, Pointiness, Cavity and Edge Wear beside each other, in flat light."""

import math
import sys
import tempfile
from pathlib import Path

import bpy
import clicks
import numpy as np
from mathutils import Vector
from PIL import Image

from paradesc.files import png

sys.path.append(str(Path(__file__).resolve().parents[2] / "addon" / "manual" / "pictures"))
import lettering

SIZE, LABEL = 400, 28
WORDS = (225, 225, 225)
DIRECTION = Vector((0.75, -1.0, 0.55)).normalized()  # from which assets are looked at
MARGIN = 1.08


def set_up(target: bpy.types.Object) -> None:
    """A camera that sees all of the object, and flat light on the colors that are shown."""
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.display.shading.light, scene.display.render_aa = "FLAT", "8"
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGB"
    scene.world = bpy.data.worlds.new("ground")
    scene.world.color = (0.045, 0.05, 0.06)
    camera = scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    for item in bpy.data.objects:
        item.hide_render = item not in (target, camera)
    turn = DIRECTION.to_track_quat("Z", "Y")
    camera.rotation_euler = turn.to_euler()
    corners = [target.matrix_world @ vertex.co for vertex in target.data.vertices]
    seen = np.array([turn.inverted() @ corner for corner in corners])
    low, high = seen.min(axis=0), seen.max(axis=0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", float((high - low)[:2].max()) * MARGIN
    depth = float(high[2] - low[2])
    middle = Vector([*((low + high) / 2)[:2], high[2] + depth + 1])
    camera.location = turn @ middle
    camera.data.clip_start, camera.data.clip_end = 0.5, 3 * depth + 2


def drawn(target: bpy.types.Object, colors: str = "", image: bpy.types.Image | None = None) -> np.ndarray:
    """(SIZE, SIZE, 3) uint8 of the object with a color attribute, or with an image."""
    shading = bpy.context.scene.display.shading
    if image is None:
        shading.color_type = "VERTEX"
        target.data.color_attributes.active_color = target.data.color_attributes[colors]
    else:
        shading.color_type = "TEXTURE"
        material = bpy.data.materials.new("image")
        material.use_nodes = True
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        material.node_tree.nodes.active = node
        target.data.materials.clear()
        target.data.materials.append(material)
        for face in target.data.polygons:
            face.material_index = 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "view.png"
        bpy.context.scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        return read(path)


def read(path: Path) -> np.ndarray:
    """(height, width, 3) uint8 of a file that Blender has rendered."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    found = np.array(image.pixels[:], np.float32).reshape(height, width, 4)[::-1, :, :3]
    bpy.data.images.remove(image)
    return np.round(255 * found).astype(np.uint8)


def of_mask(shown: "clicks.Shown") -> np.ndarray:
    """The object with a mask, by the color attribute or by the image that the click has made."""
    set_up(shown.target)
    return drawn(shown.target, "" if shown.image else f"{clicks.MASKS[shown.mask][0]}_color", shown.image)


def of_tones(target: bpy.types.Object, tones: np.ndarray) -> np.ndarray:
    """The object with (vertex_count,) greys."""
    layer = target.data.color_attributes.new("tones", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", tones.repeat(4).astype(np.float32))
    set_up(target)
    return drawn(target, "tones")


def written(path: Path, views: dict[str, np.ndarray]) -> None:
    """The views beside each other, each with its name."""
    sheet = np.full((SIZE + LABEL, SIZE * len(views), 3), 24, np.uint8)
    for number, (name, view) in enumerate(views.items()):
        sheet[LABEL:, number * SIZE : (number + 1) * SIZE] = view
        lettering.draw_text(sheet, name, number * SIZE + 8, 4, 2, WORDS)
    png.write_png(path, sheet)


def contact(path: Path, sheets: list[Path], width: int = 533) -> None:
    """All sheets below each other in two columns, small."""
    pictures = [Image.open(sheet) for sheet in sheets]
    high = width * pictures[0].height // pictures[0].width
    whole = Image.new("RGB", (2 * width, math.ceil(len(pictures) / 2) * high))
    for number, picture in enumerate(pictures):
        whole.paste(picture.convert("RGB").resize((width, high)), (number % 2 * width, number // 2 * high))
    whole.save(path, quality=75)
