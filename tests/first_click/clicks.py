"""What one click leaves: the mask as it is shown at points of the surface, with every setting at its default."""

from dataclasses import dataclass

import bpy
import numpy as np
from measures import Points, Surface, at_corners, evenly

from paradesc.files.preset_rules import PRESETS
from paradesc.scene import image_results, large_faces
from paradesc.show import recolor

# Points at which an image is looked at.
IN_IMAGE = 200_000
# The ends of the names of images.
WORDS = {"cavity": "_cavity", "edge_wear": "_edges"}


@dataclass
class Shown:
    """A mask that one click has made."""

    way: str  # "vertices" or "image"
    radius: float  # in the mesh's own unit
    points: Points
    values: np.ndarray  # (n,) shown, from black 0 to white 1
    target: bpy.types.Object
    image: bpy.types.Image | None = None


class Refused(Exception):
    """The click made nothing; the sentence says why."""


def surface_of(mesh: bpy.types.Mesh) -> Surface:
    """The triangles of a mesh."""
    mesh.calc_loop_triangles()
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    triangles, corners = (np.empty(3 * len(mesh.loop_triangles), np.int32) for _ in range(2))
    mesh.loop_triangles.foreach_get("vertices", triangles)
    mesh.loop_triangles.foreach_get("loops", corners)
    return Surface(positions.reshape(-1, 3).astype(np.float64), triangles.reshape(-1, 3), corners.reshape(-1, 3))


def click(mask: str, to_image: bool) -> Shown:
    """Presses the main button, and before it the mask's own if it is none of those that are baked by default."""
    group = bpy.context.scene.paradesc
    (name,) = PRESETS[mask].members["descriptors"]
    if name not in group.descriptors:
        bpy.ops.paradesc.mask(name=mask)
    try:
        (bpy.ops.paradesc.bake_image if to_image else bpy.ops.paradesc.bake)()
    except RuntimeError as error:
        raise Refused(str(error).strip().removeprefix("Error: ")) from error
    if to_image:
        return in_image(next(item for item in bpy.context.selected_objects if item.type == "MESH"), mask)
    return at_vertices(next(item for item in bpy.data.objects if item.type == "MESH" and name in item.data.attributes), name)


def at_vertices(target: bpy.types.Object, name: str) -> Shown:
    """The values at the vertices, as their colors show them."""
    mesh = target.data
    shown = recolor.stored_range(mesh, name).shares(recolor.stored_values(mesh, name).astype(np.float64))
    surface = surface_of(mesh)
    points = at_corners(surface)
    values = points.mixed(np.nan_to_num(shown)[surface.triangles][..., None])[:, 0]
    return Shown("vertices", mesh["paradesc"]["field_report"]["radius"], points, values, target)


def in_image(target: bpy.types.Object, mask: str) -> Shown:
    """The texels of the mask's image under points of the surface."""
    mesh, made = target.data, image_results.found(target)
    image = next(image for image in made.images if WORDS[mask] in image.name)
    surface = surface_of(mesh)
    points = evenly(surface, IN_IMAGE)
    uvs = np.empty(2 * len(mesh.loops), np.float32)
    mesh.uv_layers[made.uv_map or mesh.uv_layers.active.name].data.foreach_get("uv", uvs)
    u, v = points.mixed(uvs.reshape(-1, 2)[surface.corners]).T
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    texels = pixels.reshape(height, width, 4)[..., 0]
    column, row = (np.floor(place % 1 * size).astype(int) for place, size in ((u, width), (v, height)))
    values = texels[np.minimum(row, height - 1), np.minimum(column, width - 1)].astype(np.float64)
    radius = bpy.context.scene.paradesc.radius_percent / 100 * surface.diagonal  # which the bake has fitted
    return Shown("image", radius, points, np.nan_to_num(values), target, image)


def offers_image(target: bpy.types.Object) -> bool:
    """Whether the panel offers Bake to Image first, since most of the area lies in faces too large for vertex colors."""
    return large_faces.every([target], bpy.context.scene.paradesc_animation.source)
