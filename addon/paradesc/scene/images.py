"""Brings textures into Blender: as images of data, from files or packed into the .blend, and into materials."""

import tempfile
from pathlib import Path

import bpy

from ..files import tile_names
from . import mesh_io

# The custom property of images that were packed because the .blend had no folder yet, and of materials made for images.
MARK = "paradesc_image"
# Where nodes stand beside each other, in the node editor's units.
NODE_WIDTH, NODE_HEIGHT = 300.0, 300.0


def from_file(path: Path) -> bpy.types.Image:
    """The image of this file, read afresh where Blender has it already."""
    image = bpy.data.images.load(str(path), check_existing=True)
    unpack(image)
    image.reload()
    place(image, path)
    return as_data(image)


def from_tiles(path: Path, tiles: list[int]) -> bpy.types.Image:
    """The tiled image of UDIM tiles whose files lie at a path with a place for their numbers, read afresh."""
    same = (item for item in bpy.data.images if item.source == "TILED" and item.library is None)
    image = next((item for item in same if Path(bpy.path.abspath(item.filepath)) == path), None)
    if image is None:
        image = bpy.data.images.load(str(tile_names.of_tile(path, tiles[0])))
        image.name = path.name
    read_tiles(image, path, tiles)
    place(image, path)
    return as_data(image)


def read_tiles(image: bpy.types.Image, path: Path, tiles: list[int]) -> None:
    """Reads the tiles into an image, which gets them and no others."""
    unpack(image)
    image.source = "TILED"
    image.filepath_raw = str(path)
    image.reload()  # which takes in all that lie there, of earlier bakes too
    while len(image.tiles) > 1:  # one always stays
        image.tiles.remove(image.tiles[-1])
    image.tiles[0].number = tiles[0]
    for number in tiles[1:]:
        image.tiles.new(tile_number=number)
    image.tiles.active_index = 0


def unpack(image: bpy.types.Image) -> None:
    """Takes an older content out of the .blend, which a reload would keep."""
    if image.packed_file is not None or len(image.packed_files):
        image.unpack(method="REMOVE")


def place(image: bpy.types.Image, path: Path) -> None:
    """Lets the image find its file from the .blend's folder, if people want that."""
    if bpy.data.filepath and bpy.context.preferences.filepaths.use_relative_paths:
        image.filepath_raw = bpy.path.relpath(str(path))


def from_memory(name: str, content: bytes) -> bpy.types.Image:
    """The image of a file that is packed into the .blend; the one of an earlier call is filled anew."""
    image = kept_in_file(name)
    if image.source == "TILED":
        unpack(image)
        image.source = "FILE"
    image.filepath_raw = ""  # or Blender would look for a file of this name when it reloads
    image.pack(data=content, data_len=len(content))
    image.source = "FILE"
    image.reload()
    image.filepath_raw = f"//{name}.png"
    return as_data(image)


def from_memory_of_tiles(name: str, contents: dict[int, bytes]) -> bpy.types.Image:
    """The same of UDIM tiles, which Blender packs from files alone."""
    image = kept_in_file(name)
    with tempfile.TemporaryDirectory(dir=bpy.app.tempdir) as folder:
        path = tile_names.with_token(Path(folder) / f"{name}.png")
        for tile, content in contents.items():
            tile_names.of_tile(path, tile).write_bytes(content)
        read_tiles(image, path, list(contents))
        image.pack()
    image.filepath_raw = f"//{path.name}"
    return as_data(image)


def kept_in_file(name: str) -> bpy.types.Image:
    """The image that an earlier call packed into the .blend under this name, or a new one."""
    found = (item for item in bpy.data.images if item.get(MARK) == name and item.library is None)
    image = next(found, None) or bpy.data.images.new(name, 8, 8)
    image[MARK] = name
    image.use_fake_user = True  # nothing may use it yet, and Blender saves only what is used
    return image


def as_data(image: bpy.types.Image) -> bpy.types.Image:
    """The image, whose channels are numbers: no color management, and no channel weighs another."""
    image.colorspace_settings.is_data = True
    image.alpha_mode = "CHANNEL_PACKED"
    return image


def add_to_material(target: bpy.types.Object, images: list[bpy.types.Image]) -> bpy.types.Material:
    """Puts the images into the object's active material, the first one active; without one it makes a material."""
    material = target.active_material
    if material is None:
        if target.data.library is not None or target.data.override_library is not None:
            raise mesh_io.refuse(f'The mesh "{target.data.name}" is linked and has no material; make it local first.')
        material = target.active_material = new_material(target.name)
    if material.library is not None or material.override_library is not None:
        raise mesh_io.refuse(f'The material "{material.name}" is linked from another file; make it local first.')
    if material.node_tree is None:  # never since Blender 5
        material.use_nodes = True
    tree = material.node_tree
    nodes = [image_node(tree, image) for image in images]
    for node in tree.nodes:
        node.select = node in nodes
    tree.nodes.active = nodes[0]
    if material.get(MARK):
        show(tree, nodes[0])
    return material


def new_material(name: str) -> bpy.types.Material:
    """Makes a material with a shader only."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # never since Blender 5
        material.use_nodes = True
    material[MARK] = name
    return material


def image_node(tree: bpy.types.NodeTree, image: bpy.types.Image) -> bpy.types.Node:
    """The node with this image, which is added below the others where it is missing."""
    found = [node for node in tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    node = next((node for node in found if node.image == image), None)
    if node is not None:
        return node
    place = (min((node.location.x for node in tree.nodes), default=0.0) - NODE_WIDTH, NODE_HEIGHT)
    if found:
        lowest = min(found, key=lambda node: node.location.y)
        place = (lowest.location.x, lowest.location.y - NODE_HEIGHT)
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.location = image, place
    return node


def show(tree: bpy.types.NodeTree, node: bpy.types.Node) -> None:
    """Makes the image the base color of the material's shader, unless something else is already."""
    shader = next((item for item in tree.nodes if item.type == "BSDF_PRINCIPLED"), None)
    if shader is not None and not shader.inputs["Base Color"].is_linked:
        tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
