"""The result of one click: the mask as it is shown at points of the surface, with every setting at its default."""

from dataclasses import dataclass

import bpy
import numpy as np
from measures import Measures, Points, Surface, at_corners, evenly, flat_faces, measured

from paradesc.core import color_maps
from paradesc_blender.scene import image_preview, image_results, large_faces
from paradesc_blender.show import recolor

# Points at which an image is looked at.
IN_IMAGE = 200_000
# The attributes of the masks, and the ends of the names of their images.
MASKS = {"cavity": ("cavity", "_cavity"), "edge_wear": ("convexity", "_edges")}


@dataclass
class Shown:
    """A mask that one click has made."""

    mask: str
    way: str  # "vertices" or "image"
    seen: bool  # whether it is the one that the viewport shows
    radius: float  # in the mesh's own unit
    surface: Surface
    points: Points
    values: np.ndarray  # (n,) shown, from black 0 to white 1
    target: bpy.types.Object
    image: bpy.types.Image | None = None

    def measured(self, hard: bool) -> Measures:
        """The measures of the shown mask; for a hard surface, they include its flat faces."""
        faces = flat_faces(self.surface, self.points, self.radius) if hard else None
        return measured(self.values, self.points, faces)

    @property
    def percent(self) -> float:
        """The radius in percent of the diagonal."""
        return 100 * self.radius / self.surface.diagonal


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


def click(to_image: bool) -> list[Shown]:
    """Presses the main button; gives each mask that it has made."""
    try:
        (bpy.ops.paradesc.bake_image if to_image else bpy.ops.paradesc.bake)()
    except RuntimeError as error:
        raise Refused(str(error).strip().removeprefix("Error: ")) from error
    return found(to_image)


def found(in_images: bool) -> list[Shown]:
    """The masks that the last bake of this scene has made."""
    meshes = [item for item in bpy.context.scene.objects if item.type == "MESH"]
    if in_images:
        target = next(item for item in meshes if image_results.found(item) is not None)
        images = image_results.found(target).images
        made = [in_image(target, mask, image) for mask in MASKS for image in images if MASKS[mask][1] in image.name]
        if not any(shown.seen for shown in made):  # in the background, which has no viewport
            made[color_maps.most_telling([one.measured(False).dark for one in made])].seen = True
        return made
    target = next(item for item in meshes if any(name in item.data.attributes for name, _ in MASKS.values()))
    return [at_vertices(target, mask) for mask, (name, _) in MASKS.items() if name in target.data.attributes]


def at_vertices(target: bpy.types.Object, mask: str) -> Shown:
    """The values at the vertices, as their colors show them."""
    mesh, name = target.data, MASKS[mask][0]
    shown = recolor.stored_range(mesh, name).shares(recolor.stored_values(mesh, name).astype(np.float64))
    surface = surface_of(mesh)
    points = at_corners(surface)
    values = points.mixed(np.nan_to_num(shown)[surface.triangles][..., None])[:, 0]
    radius = mesh["paradesc"]["field_report"]["radius"]
    seen = mesh.color_attributes.active_color.name == f"{name}_color"
    return Shown(mask, "vertices", seen, radius, surface, points, values, target)


def in_image(target: bpy.types.Object, mask: str, image: bpy.types.Image) -> Shown:
    """The texels of a mask's image under points of the surface."""
    mesh, made = target.data, image_results.found(target)
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
    return Shown(mask, "image", image_preview.shown(target) == image.name, radius, surface, points, np.nan_to_num(values), target, image)


def offers_image(target: bpy.types.Object) -> bool:
    """Returns whether the panel offers Bake to Image first: most of the area lies in too large faces."""
    return large_faces.every([target], bpy.context.scene.paradesc_animation.source)
