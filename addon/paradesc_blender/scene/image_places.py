"""Finds names for textures: those of the object's earlier, unchanged bake, or free ones."""

import re
from pathlib import Path

import bpy

from paradesc.files import file_names, marks

from . import images


def found(folder: Path | None, stem: str, word: str, owner: marks.Owner) -> str:
    """The name, without suffix, of an object's texture. stem: the object in file names; word: the texture.

    folder: that of the .blend; without one, textures are packed into the .blend.
    """
    names = (f"{one}_{word}" for one in file_names.numbered(stem))
    if folder is None:
        return next(name for name in names if is_free_in_file(name, owner))
    there = list(folder.iterdir())
    return next(name for name in names if is_free_in_folder(folder / f"{name}.png", there, owner))


def is_free_in_folder(path: Path, there: list[Path], owner: marks.Owner) -> bool:
    """Whether a texture's file, or those of all its tiles, are missing or are unchanged bakes of this owner."""
    pattern = re.compile(re.escape(file_names.folded(path.stem)) + r"(\.\d{4})?\.png")
    files = [one for one in there if pattern.fullmatch(file_names.folded(one.name))]
    loaded = images.at_path(path)
    ours = any(image.get(images.OBJECT) == owner["object"] for image in loaded)
    return all(is_owners(marks.owner_of_file(one), owner, ours) for one in files) and not any(
        is_edited(image) for image in loaded
    )


def is_owners(found: marks.Owner | None, owner: marks.Owner, loaded: bool) -> bool:
    """Whether a mark names the owner. loaded: this .blend uses the file, so the mark may name a former .blend."""
    theirs = found or {}
    return theirs.get("object") == owner["object"] and (loaded or theirs.get("blend") == owner["blend"])


def is_free_in_file(name: str, owner: marks.Owner) -> bool:
    """Whether no image of this name is packed into the .blend, or it is an unchanged bake of the owner."""
    image = images.packed_as(name)
    return image is None or (image.get(images.OBJECT) == owner["object"] and not is_edited(image))


def is_edited(image: bpy.types.Image) -> bool:
    """Whether somebody has painted on an image, or has packed other contents than a bake's into the .blend."""
    return image.is_dirty or any(marks.owner_of(item.packed_file.data) is None for item in image.packed_files)
