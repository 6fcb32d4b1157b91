"""Brings textures into Blender: as images of data, from files or packed into the .blend, and into materials."""

import tempfile
from pathlib import Path

import bpy

from ..files import file_names, tile_names
from . import mesh_io

# The custom property of images that were packed because the .blend had no folder yet, and of materials made for images.
MARK = "paradesc_image"
# The custom property of images that names the object whose bake they are.
OBJECT = "paradesc_object"
# Where nodes stand beside each other, in the node editor's units.
NODE_WIDTH, NODE_HEIGHT = 300.0, 300.0


def from_disk(path: Path, tiles: list[int | None], name: str) -> bpy.types.Image:
    """The image of a file, or of its UDIM tiles, that a bake of an object of this name has written, read afresh.

    Where Blender has it already it keeps how people use it; images that they themselves made of the file only see it.
    """
    tiled, there = tiles != [None], at_path(path)
    ours = (item for item in there if OBJECT in item or item.colorspace_settings.is_data)
    image = next((item for item in ours if (item.source == "TILED") == tiled), None)
    made = image is None
    if made:
        image = bpy.data.images.load(str(tile_names.of_tile(path, tiles[0])), check_existing=False)
    path = tile_names.with_token(path) if tiled else path
    if made and tiled:
        image.name = path.name
    read(image, path, tiles)
    for other in there:
        if other != image:
            other.reload()
    place(image, path)
    image[OBJECT] = name
    return as_data(image) if made else image


def at_path(path: Path) -> list[bpy.types.Image]:
    """The local images that show a file, or the tiles that have its name."""
    names = {file_names.folded(str(one)) for one in (path, tile_names.with_token(path))}
    local = (item for item in bpy.data.images if item.library is None and item.filepath)
    return [item for item in local if file_names.folded(str(Path(bpy.path.abspath(item.filepath)))) in names]


def read(image: bpy.types.Image, path: Path, tiles: list[int | None]) -> None:
    """Reads a file, or UDIM tiles, into an image, which gets these tiles and no others."""
    unpack(image)
    image.source = "FILE" if tiles == [None] else "TILED"
    image.filepath_raw = str(path)
    image.reload()  # which takes in all tiles that lie there, of earlier bakes too
    if tiles == [None]:
        return
    while len(image.tiles) > 1:  # one always stays
        image.tiles.remove(image.tiles[-1])
    image.tiles[0].number = tiles[0]
    for number in tiles[1:]:
        image.tiles.new(tile_number=number)
    image.tiles.active_index = 0
    image.alpha_mode = image.alpha_mode  # has Blender read the files of these tiles


def unpack(image: bpy.types.Image) -> None:
    """Takes an older content out of the .blend, which a reload would keep."""
    if image.packed_file is not None or len(image.packed_files):
        image.unpack(method="REMOVE")


def place(image: bpy.types.Image, path: Path) -> None:
    """Lets the image find its file from the .blend's folder, if people want that."""
    if bpy.data.filepath and bpy.context.preferences.filepaths.use_relative_paths:
        image.filepath_raw = bpy.path.relpath(str(path))


def from_memory(name: str, contents: dict[int | None, bytes], owner: str) -> bpy.types.Image:
    """The image of a file, or of UDIM tiles, that is packed into the .blend for a bake of an object of this name.

    That of an earlier bake is filled anew. Blender packs files, so they are there for a moment: it would look for them
    too, and complain on the console, if it were handed their content.
    """
    image = packed_as(name) or bpy.data.images.new(name, 8, 8)
    made = OBJECT not in image
    image[MARK], image[OBJECT] = name, owner
    with tempfile.TemporaryDirectory(dir=bpy.app.tempdir) as folder:
        path = Path(folder) / f"{name}.png"
        path = path if None in contents else tile_names.with_token(path)
        for tile, content in contents.items():
            tile_names.of_tile(path, tile).write_bytes(content)
        read(image, path, list(contents))
        if made:
            as_data(image)
        image.pack()
    image.filepath_raw = f"//{path.name}"
    return image


def packed_as(name: str) -> bpy.types.Image | None:
    """The image that an earlier bake has packed into the .blend under this name."""
    return next((item for item in bpy.data.images if item.get(MARK) == name and item.library is None), None)


def as_data(image: bpy.types.Image) -> bpy.types.Image:
    """A new image, whose channels are numbers: no color management, and no channel weighs another."""
    image.use_fake_user = True  # nothing may use it yet, and Blender saves only what is used
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
