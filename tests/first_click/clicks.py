"""What one click leaves: the mask as it is shown at points of the surface, with every setting at its default."""

from dataclasses import dataclass

import bpy
import numpy as np
from measures import Points, Surface, at_corners, evenly

from paradesc.files.preset_rules import PRESETS
from paradesc.show import recolor

# Points at which an image is looked at.
IN_IMAGE = 200_000
# Above this share of the area in faces all of whose vertices lie on creases, the panel's button is Bake to Image.
LARGE_FACES = 0.5
# Degrees, from which on an edge counts as a crease where the add-on does not yet say how many faces are too large.
CREASE = 30.0


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
    """Presses the main button, with the mask's own pressed before if it is not the default one."""
    group = bpy.context.scene.paradesc
    if PRESETS[mask].members["descriptors"] != group.descriptors:
        bpy.ops.paradesc.mask(name=mask)
    images = set(bpy.data.images)
    try:
        (bpy.ops.paradesc.bake_image if to_image else bpy.ops.paradesc.bake)()
    except RuntimeError as error:
        raise Refused(str(error).strip().removeprefix("Error: ")) from error
    (name,) = PRESETS[mask].members["descriptors"]
    if to_image:
        made = [image for image in bpy.data.images if image not in images]
        return in_image(next(item for item in bpy.context.selected_objects if item.type == "MESH"), made[0])
    return at_vertices(next(item for item in bpy.data.objects if item.type == "MESH" and name in item.data.attributes), name)


def at_vertices(target: bpy.types.Object, name: str) -> Shown:
    """The values at the vertices, as their colors show them."""
    mesh = target.data
    shown = recolor.stored_range(mesh, name).shares(recolor.stored_values(mesh, name).astype(np.float64))
    surface = surface_of(mesh)
    points = at_corners(surface)
    values = points.mixed(np.nan_to_num(shown)[surface.triangles][..., None])[:, 0]
    return Shown("vertices", mesh["paradesc"]["field_report"]["radius"], points, values, target)


def in_image(target: bpy.types.Object, image: bpy.types.Image) -> Shown:
    """The texels under points of the surface."""
    mesh = target.data
    surface = surface_of(mesh)
    points = evenly(surface, IN_IMAGE)
    uvs = np.empty(2 * len(mesh.loops), np.float32)
    mesh.uv_layers.active.data.foreach_get("uv", uvs)
    u, v = points.mixed(uvs.reshape(-1, 2)[surface.corners]).T
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    texels = pixels.reshape(height, width, 4)[..., 0]
    column, row = (np.floor(place % 1 * size).astype(int) for place, size in ((u, width), (v, height)))
    values = texels[np.minimum(row, height - 1), np.minimum(column, width - 1)].astype(np.float64)
    group = bpy.context.scene.paradesc
    if getattr(group, "radius_fit", "typed") != "typed":
        bpy.ops.paradesc.fit_radius(size=group.radius_fit)  # which shows the radius that the bake has had
    return Shown("image", group.radius_percent / 100 * surface.diagonal, points, np.nan_to_num(values), target, image)


def offers_image(mesh: bpy.types.Mesh) -> bool:
    """Whether the panel offers Bake to Image, since most of the area lies in faces that are too large for colors."""
    if not mesh.uv_layers:
        return False
    return share_of_large_faces(mesh) > LARGE_FACES


def share_of_large_faces(mesh: bpy.types.Mesh) -> float:
    """The share of the area in faces all of whose vertices lie on edges that bend by 30 degrees or are open."""
    copy = mesh.copy()
    try:
        import bmesh

        form = bmesh.new()
        form.from_mesh(copy)
        bmesh.ops.remove_doubles(form, verts=form.verts, dist=1e-6)
        sharp = {
            vertex
            for edge in form.edges
            if len(edge.link_faces) != 2 or edge.calc_face_angle(0.0) > np.radians(CREASE)
            for vertex in edge.verts
        }
        areas = [(face.calc_area(), all(vertex in sharp for vertex in face.verts)) for face in form.faces]
        form.free()
    finally:
        bpy.data.meshes.remove(copy)
    return sum(area for area, large in areas if large) / max(sum(area for area, _ in areas), 1e-300)
