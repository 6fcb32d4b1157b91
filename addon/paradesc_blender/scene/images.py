"""Brings textures into Blender: as images of data, from files or packed into the .blend, under names that are free."""

import re
import tempfile
from pathlib import Path

import bpy

from paradesc.files import file_names, marks, tile_names

# The custom property of images that were packed because the .blend had no folder, and of materials made for images.
MARK = "paradesc_image"
# The custom property with the name of the object from which an image was baked.
OBJECT = "paradesc_object"


def from_disk(path: Path, tiles: list[int | None], name: str) -> bpy.types.Image:
    """The image of a file, or of UDIM tiles, that was baked from an object of this name, with its present contents.

    An image that Blender has loaded already keeps the settings that people gave it. Images that people made of the file
    themselves only show the new contents.
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
    if bpy.data.filepath and bpy.context.preferences.filepaths.use_relative_paths:
        image.filepath_raw = bpy.path.relpath(str(path))
    image[OBJECT] = name
    return as_data(image) if made else image


def at_path(path: Path) -> list[bpy.types.Image]:
    """The local images that use a file, or the tiled file that has its name."""
    names = {file_names.folded(str(one)) for one in (path, tile_names.with_token(path))}
    local = (item for item in bpy.data.images if item.library is None and item.filepath)
    return [item for item in local if file_names.folded(str(Path(bpy.path.abspath(item.filepath)))) in names]


def read(image: bpy.types.Image, path: Path, tiles: list[int | None]) -> None:
    """Loads a file, or UDIM tiles, into an image; a tiled image has exactly these tiles afterwards."""
    if image.packed_file is not None or len(image.packed_files):
        image.unpack(method="REMOVE")  # a reload would keep packed contents
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


def from_memory(name: str, contents: dict[int | None, bytes], owner: str) -> bpy.types.Image:
    """The image of a file, or of UDIM tiles, that is packed into the .blend for an object of this name.

    The image of an earlier bake is filled again. Blender packs only existing files, so they are written for a moment;
    given bytes, it would look for the files all the same and complain on the console.
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
    """The image of this name that an earlier bake packed into the .blend."""
    return next((item for item in bpy.data.images if item.get(MARK) == name and item.library is None), None)


def as_data(image: bpy.types.Image) -> bpy.types.Image:
    """Sets up a new image as data: no color management, and channels that do not affect each other."""
    image.use_fake_user = True  # nothing may use it yet, and Blender saves only what is used
    image.colorspace_settings.is_data = True
    image.alpha_mode = "CHANNEL_PACKED"
    return image


# ---- Names


def stem_of(name: str, owner: str) -> str:
    """How the names of an object's textures begin.

    Earlier versions wrote "W_rfel" for "Würfel"; textures that this .blend has by such a name keep it.
    """
    former, there = file_names.cut(bpy.path.clean_name(name)), (item for item in bpy.data.images if item.library is None)
    named = (bpy.path.basename(item.filepath) for item in there if item.get(OBJECT) == owner)
    return former if any(one.startswith(f"{former}_") for one in named) else file_names.cut(file_names.plain(name))


def free_name(folder: Path | None, stem: str, word: str, owner: marks.Owner) -> str:
    """The name of an object's texture: that of its earlier, unchanged bake, or a free one, without suffix.

    stem: the object in file names; word: the texture; folder: that of the .blend, or None if textures are packed.
    """
    names = (f"{one}_{word}" for one in file_names.numbered(stem))
    there = [] if folder is None else list(folder.iterdir())

    def is_free(name: str) -> bool:
        if folder is not None:
            return is_free_in_folder(folder / f"{name}.png", there, owner)
        image = packed_as(name)
        return image is None or (image.get(OBJECT) == owner["object"] and not is_edited(image))

    return next(filter(is_free, names))


def is_free_in_folder(path: Path, there: list[Path], owner: marks.Owner) -> bool:
    """Returns whether a texture's file, or those of all its tiles, are missing or are unchanged bakes of this owner.

    A file that this .blend uses may have the mark of a former .blend.
    """
    pattern = re.compile(re.escape(file_names.folded(path.stem)) + r"(\.\d{4})?\.png")
    files = [one for one in there if pattern.fullmatch(file_names.folded(one.name))]
    loaded = at_path(path)
    is_ours = any(image.get(OBJECT) == owner["object"] for image in loaded)
    for found in (marks.owner_of_file(one) or {} for one in files):
        if found.get("object") != owner["object"] or not (is_ours or found.get("blend") == owner["blend"]):
            return False
    return not any(is_edited(image) for image in loaded)


def is_edited(image: bpy.types.Image) -> bool:
    """Returns whether somebody has painted on an image, or has packed other contents than a bake's into the .blend."""
    return image.is_dirty or any(marks.owner_of(item.packed_file.data) is None for item in image.packed_files)
