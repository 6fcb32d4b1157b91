"""Reads displacement and normal maps of an object, from files or from its material, and its corners' tangents."""

from pathlib import Path

import bmesh
import bpy
import numpy as np

from paradesc.bridge import InputError, MeshArrays, SurfaceMaps
from paradesc.core import color_maps, spaces
from paradesc.files.map_images import MapChoice, displacement_notes, luminance, of_files

from . import mesh_io
from .arrays import read_array, read_corner_vertices

ORIGINAL_FACE = "paradesc_face"


def add_maps(target: bpy.types.Object, arrays: MeshArrays, choice: MapChoice) -> list[str]:
    """Adds the maps, and the mesh data that they need, to the arrays; returns a note about each map."""
    if not choice.any:
        return []
    if target.data.uv_layers.active is None:
        raise InputError(f'The mesh "{target.data.name}" has no UV map for displacement and normal maps; unwrap it.')
    maps = SurfaceMaps()
    notes = read_material(target, maps) if choice.material else of_files(choice, maps, read_file)
    if maps.normals is not None:
        maps.corner_tangents, arrays.corner_normals = read_tangent_space(target)
    arrays.maps = maps
    return notes


# ---- Images


def read_file(path: Path) -> tuple[np.ndarray, bool]:
    """(height, width, 4) float32 values of a file as they are, rows bottom-up, and whether that is over 8 bits."""
    if not path.is_file():
        raise InputError(f'There is no image "{path}".')
    try:
        image = bpy.data.images.load(str(path.resolve()), check_existing=False)
    except RuntimeError as error:
        raise InputError(f'Blender cannot read the image "{path}".') from error
    try:
        image.colorspace_settings.name = "Non-Color"
        image.alpha_mode = "CHANNEL_PACKED"
        return read_pixels(image, str(path)), image.is_float
    finally:
        bpy.data.images.remove(image)


def read_pixels(image: bpy.types.Image, name: str) -> np.ndarray:
    """(height, width, 4) float32 as the image holds them, rows bottom-up."""
    width, height = image.size
    if image.source == "TILED":
        raise InputError(f'The image "{name}" has several tiles; only single images can be used as maps.')
    count = len(image.pixels)
    if width == 0 or height == 0 or count == 0:
        raise InputError(f'The image "{name}" has no pixels that Blender can read.')
    pixels = np.empty(count, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, -1)
    channels = pixels.shape[2]
    if channels == 4:
        return pixels
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels[..., :3] if channels == 3 else pixels[..., :1]
    if channels == 2:
        rgba[..., 3] = pixels[..., 1]
    return rgba


def read_linear(image: bpy.types.Image) -> np.ndarray:
    """(height, width, 4) float32 as materials see the image: sRGB as linear colors, data unchanged."""
    pixels = read_pixels(image, image.name)
    space = image.colorspace_settings
    # Blender makes floats linear when it loads them.
    if image.is_float or space.is_data or space.name.startswith(("Raw", "Linear")):
        return pixels
    if space.name != "sRGB":
        raise InputError(f'The image "{image.name}" is in the color space "{space.name}"; set it to Non-Color.')
    pixels[..., :3] = color_maps.srgb_to_linear(pixels[..., :3])
    return pixels


# ---- The material


def read_material(target: bpy.types.Object, maps: SurfaceMaps) -> list[str]:
    """Fills the maps from the object's material; returns a note about each."""
    material = single_material(target)
    uses_nodes = bpy.app.version >= (5, 0, 0) or material.use_nodes  # since Blender 5.0 every material does
    output = material.node_tree.get_output_node("ALL") if uses_nodes and material.node_tree else None
    notes = []
    if output is not None:
        notes += read_displacement_node(target, material, output, maps)
        notes += read_normal_node(target, material, output, maps)
    if not notes:
        raise InputError(
            f'The material "{material.name}" has no Displacement or Normal Map node with an Image Texture; there is '
            "no map to use."
        )
    return notes


def single_material(target: bpy.types.Object) -> bpy.types.Material:
    """The one material that the object's faces use."""
    slots = [slot.material for slot in target.material_slots]
    used = np.unique(read_array(target.data.polygons, "material_index", np.int32)) if slots else []
    found = {slots[min(index, len(slots) - 1)] for index in used} - {None}
    if not found:
        raise InputError(f'The object "{target.name}" has no material to take maps from.')
    if len(found) > 1:
        names = ", ".join(sorted(f'"{material.name}"' for material in found))
        raise InputError(f'The object "{target.name}" has several materials ({names}); maps can be used from one only.')
    return found.pop()


def read_displacement_node(
    target: bpy.types.Object, material: bpy.types.Material, output: bpy.types.Node, maps: SurfaceMaps
) -> list[str]:
    """Takes heights, midlevel and scale from the output's Displacement node, if there is one; returns notes."""
    socket = source_of(output.inputs["Displacement"])
    if socket is None:
        return []
    node = socket.node
    if node.type != "DISPLACEMENT":
        raise InputError(
            f'The displacement of the material "{material.name}" comes from a {node.bl_label} node; only a '
            "Displacement node with an Image Texture can be used."
        )
    image, channel = image_of(target, material, node, "Height")
    pixels = read_linear(image)
    maps.heights = np.ascontiguousarray(pixels[..., 3]) if channel == "Alpha" else luminance(pixels)
    maps.midlevel = constant(material, node, "Midlevel")
    maps.scale = constant(material, node, "Scale")
    if node.space == "WORLD":
        scale = spaces.scales(target.matrix_world)
        if scale.min() <= 0 or not spaces.is_even(target.matrix_world):
            raise InputError(
                f'The object "{target.name}" is scaled differently along its axes, which its displacement in world '
                "space cannot follow; apply the scale, or set the Displacement node to object space."
            )
        maps.scale /= float(scale.mean())
    return displacement_notes(image.name, maps, image.is_float)


def read_normal_node(
    target: bpy.types.Object, material: bpy.types.Material, output: bpy.types.Node, maps: SurfaceMaps
) -> list[str]:
    """Takes colors from the Normal Map node of the output's surface shader, if there is one; returns notes."""
    shader = source_of(output.inputs["Surface"])
    entry = shader.node.inputs.get("Normal") if shader is not None else None
    socket = source_of(entry) if entry is not None else None
    if socket is None:
        return []
    node = socket.node
    if node.type != "NORMAL_MAP" or node.space != "TANGENT":
        what = f"a {node.bl_label} node" + (" in another space" if node.type == "NORMAL_MAP" else "")
        raise InputError(
            f'The normals of the material "{material.name}" come from {what}; only a Normal Map node in tangent space '
            "with an Image Texture can be used."
        )
    check_uv_map(target, node.uv_map, node)
    image, channel = image_of(target, material, node, "Color")
    if channel == "Alpha":
        raise InputError(f'The normal map of the material "{material.name}" is an alpha channel; connect the color.')
    maps.normals = with_strength(read_linear(image)[..., :3], constant(material, node, "Strength"))
    return [f'Normals are those of "{image.name}".']


def with_strength(colors: np.ndarray, strength: float) -> np.ndarray:
    """(height, width, 3) colors of normals that are blended with the surface's own, as by the node's Strength."""
    if strength == 1.0:
        return np.ascontiguousarray(colors)
    normals = 2.0 * colors - 1.0
    lengths = np.linalg.norm(normals, axis=2, keepdims=True)
    normals = np.where(lengths > 0, normals / np.maximum(lengths, 1e-20), (0.0, 0.0, 1.0))
    flat = np.array((0.0, 0.0, 1.0))
    return (0.5 + 0.5 * (flat + (normals - flat) * max(strength, 0.0))).astype(np.float32)


def source_of(socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The output that is linked to an input, through reroutes; None if there is no link."""
    while socket.is_linked:
        origin = socket.links[0].from_socket
        if origin.node.type != "REROUTE":
            return origin
        socket = origin.node.inputs[0]
    return None


def constant(material: bpy.types.Material, node: bpy.types.Node, name: str) -> float:
    """The value of an input, which must not be linked."""
    if source_of(node.inputs[name]) is not None:
        sentence = f'The {name} of the {node.bl_label} node in "{material.name}" is connected; it must be a number.'
        raise InputError(sentence)
    return float(node.inputs[name].default_value)


def image_of(
    target: bpy.types.Object, material: bpy.types.Material, node: bpy.types.Node, name: str
) -> tuple[bpy.types.Image, str]:
    """The image linked to an input of a node, and which output of the Image Texture node is used."""
    socket = source_of(node.inputs[name])
    texture = socket.node if socket is not None else None
    if texture is None or texture.type != "TEX_IMAGE" or texture.image is None:
        raise InputError(
            f'The {name} of the {node.bl_label} node in the material "{material.name}" '
            "does not come from an Image Texture with an image."
        )
    way = source_of(texture.inputs["Vector"])
    plain = way is None or way.node.type == "UVMAP" or (way.node.type == "TEX_COORD" and way.name == "UV")
    if not plain or texture.projection != "FLAT":
        raise InputError(
            f'The image "{texture.image.name}" in the material "{material.name}" is not mapped by a UV map alone; '
            "only such images can be used."
        )
    check_uv_map(target, way.node.uv_map if way is not None and way.node.type == "UVMAP" else "", texture)
    return texture.image, socket.name


def check_uv_map(target: bpy.types.Object, name: str, node: bpy.types.Node) -> None:
    """Raises if an image uses another UV map than the active one, which alone is baked."""
    layers = target.data.uv_layers
    used = name or next((layer.name for layer in layers if layer.active_render), layers.active.name)
    if used != layers.active.name:
        raise InputError(
            f'The {node.bl_label} node uses the UV map "{used}", but "{layers.active.name}" is active; '
            f'make "{used}" the active one.'
        )


# ---- Tangents


def read_tangent_space(target: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """(corner_count, 4) float32 tangents with the bitangent's sign, by MikkTSpace, and (corner_count, 3) normals."""
    if target.data.is_editmode:
        target.update_from_editmode()
    mesh = target.data.copy()  # what Blender computes here stays on the copy
    try:
        normals = mesh_io.read_corner_normals(mesh)
        if len(mesh.loops) == 0 or read_array(mesh.polygons, "loop_total", np.int32).max() <= 4:
            return calculate_tangents(mesh), normals
        return tangents_of_polygons(mesh), normals
    finally:
        bpy.data.meshes.remove(mesh)


def calculate_tangents(mesh: bpy.types.Mesh) -> np.ndarray:
    """(corner_count, 4) float32 of a mesh of triangles and quads."""
    try:
        mesh.calc_tangents(uvmap=mesh.uv_layers.active.name)
    except RuntimeError as error:
        raise InputError(f'Blender cannot compute the tangents of the mesh "{mesh.name}": {error}.') from error
    tangents = np.empty((len(mesh.loops), 4), np.float32)
    tangents[:, :3] = read_array(mesh.loops, "tangent", np.float32, 3)
    tangents[:, 3] = read_array(mesh.loops, "bitangent_sign", np.float32)
    mesh.free_tangents()
    return tangents


def tangents_of_polygons(mesh: bpy.types.Mesh) -> np.ndarray:
    """(corner_count, 4) float32 of a mesh with larger faces. They are cut, and a corner takes the tangent of a part."""
    count = len(mesh.vertices)
    keys = corner_faces(mesh) * count + read_corner_vertices(mesh)
    cut = bmesh.new()
    try:
        cut.from_mesh(mesh)
        layer = cut.faces.layers.int.new(ORIGINAL_FACE)
        for face in cut.faces:
            face[layer] = face.index
        bmesh.ops.triangulate(cut, faces=[face for face in cut.faces if len(face.verts) > 4])
        cut.to_mesh(mesh)
    finally:
        cut.free()
    faces = read_array(mesh.attributes[ORIGINAL_FACE].data, "value", np.int32)
    tangents = calculate_tangents(mesh)
    cut_keys = faces[corner_faces(mesh)].astype(np.int64) * count + read_corner_vertices(mesh)
    known, first = np.unique(cut_keys, return_index=True)
    return tangents[first[np.searchsorted(known, keys)]]


def corner_faces(mesh: bpy.types.Mesh) -> np.ndarray:
    """(corner_count,) int64 face of each corner."""
    sizes = read_array(mesh.polygons, "loop_total", np.int32)
    starts = read_array(mesh.polygons, "loop_start", np.int32)
    faces = np.empty(len(mesh.loops), np.int64)
    faces[np.repeat(starts, sizes) + np.arange(len(faces)) - np.repeat(np.cumsum(sizes) - sizes, sizes)] = np.repeat(
        np.arange(len(sizes)), sizes
    )
    return faces
