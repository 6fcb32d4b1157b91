"""Pictures of the pages for artists that the command line or a bake draws: presets, textures, export, trouble."""

from pathlib import Path

import bpy
import numpy as np
import subjects

from paradesc.files import lettering, picture, png
from paradesc.settings.presets import PRESETS

TEXELS = 256
INK = (60, 60, 60)


def titled(image: np.ndarray, title: str) -> np.ndarray:
    """A picture with a line above it."""
    strip = np.full((22, image.shape[1], 3), subjects.BACKGROUND, np.uint8)
    lettering.draw_text(strip, title, 10, 8, 1, INK)
    return np.concatenate([strip, image])


def row_of(pictures: list[np.ndarray]) -> np.ndarray:
    """Pictures beside each other, as high as the highest."""
    height = max(len(image) for image in pictures)
    margins = [((0, height - len(image)), (0, 8), (0, 0)) for image in pictures]
    filled = [
        np.pad(image, margin, constant_values=subjects.BACKGROUND)
        for image, margin in zip(pictures, margins, strict=True)
    ]
    return np.concatenate(filled, axis=1)


def draw_presets(path: str) -> None:
    """The first descriptor of each preset."""
    made = subjects.monkey()
    shown = []
    for name, preset in PRESETS.items():
        image = subjects.drawn(made, "--preset", name)
        first = image[:, : image.shape[1] // len(preset.members["descriptors"])]
        shown.append(titled(subjects.trimmed(first), preset.label))
    half = len(shown) // 2
    png.write_png(Path(path), np.concatenate([row_of(shown[:half]), row_of(shown[half:])]))


def draw_textures(path: str) -> None:
    """What Bake to Image leaves for the monkey: curvature, and the packed masks."""
    subjects.monkey()
    settings = bpy.context.scene.paradesc
    settings.texels, settings.descriptors, settings.radius_percent = TEXELS, {"mean_curvature"}, subjects.RADIUS_PERCENT
    shown = []
    for packed in (False, True):
        settings.image_packed = packed
        before = set(bpy.data.images.keys())
        bpy.ops.paradesc.bake_image()
        (name,) = set(bpy.data.images.keys()) - before
        image = bpy.data.images[name]
        pixels = np.array(image.pixels[:], np.float32).reshape(TEXELS, TEXELS, 4)[::-1, :, :3]
        shown.append(titled(np.round(255 * np.clip(pixels, 0, 1)).astype(np.uint8), name))
    png.write_png(Path(path), row_of(shown))


def draw_export(path: str) -> None:
    """The monkey with cavity, edges and openness packed into the channels of one color attribute."""
    made = subjects.baked_monkey("cavity", "convexity", "ambient_openness")
    looks = bpy.context.scene.paradesc_looks
    looks.pack_red, looks.pack_green, looks.pack_blue, looks.pack_alpha = "cavity", "convexity", "ambient_openness", ""
    looks.pack_kind, looks.pack_domain = "FLOAT_COLOR", "POINT"
    bpy.ops.paradesc.pack()
    mesh, matrix = made.data, np.array(made.matrix_world)
    points = np.array([vertex.co for vertex in mesh.vertices]) @ matrix[:3, :3].T + matrix[:3, 3]
    mesh.calc_loop_triangles()
    triangles = np.array([list(triangle.vertices) for triangle in mesh.loop_triangles])
    packed = np.array([item.color for item in mesh.attributes[looks.pack_name].data])[:, :3]
    shown = [np.repeat(packed[:, [channel]], 3, axis=1) for channel in range(3)]
    titles = ("cavity, as red", "edges, as green", "openness, as blue", "packed")
    pictures = [
        titled(subjects.trimmed(picture.Drawing(points, triangles, picture.PANEL).paint(colors)[::2, ::2]), title)
        for title, colors in zip(titles, [*shown, packed], strict=True)
    ]
    png.write_png(Path(path), row_of(pictures))


def draw_trouble(path: str) -> None:
    """A coarse monkey at a radius below its edges, and at one that fits."""
    subjects.empty()
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    shown = [(0.01, "smaller than the edges, facets"), (0.08, "larger than the edges")]
    pictures = [subjects.trimmed(subjects.drawn(made, "--radius", str(radius))) for radius, _ in shown]
    png.write_png(Path(path), row_of([titled(image, what) for image, (_, what) in zip(pictures, shown, strict=True)]))
