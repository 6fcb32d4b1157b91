"""Stores on a mesh which images were baked from it, for the panel that shows them."""

from dataclasses import asdict, dataclass, field
from pathlib import Path

import bpy

from paradesc.core import legend
from paradesc.files import tile_names

from ..settings import translation
from . import record

# The member of the mesh's record.
MEMBER = "image_bake"


@dataclass
class ImageBake:
    """A bake of one mesh to images, as plain values for a custom property."""

    names: list[str]  # of the images in the .blend
    holds: list[str]  # the names of the values in each, between commas
    size: int  # texels along a side
    seconds: float
    uv_map: str  # the UV map they lie over
    cage: float = 0.0  # the cage distance in the world; 0 if the mesh itself was measured
    notes: str = ""  # more lines for the panel
    warnings: str = ""
    percent: float = 0.0  # the radius, of the diagonal of what was measured
    drawn: dict[str, dict[str, float]] = field(default_factory=dict)  # of masks by their place: extremes, as in records

    @property
    def images(self) -> list[bpy.types.Image]:
        """The images that still exist."""
        return [image for image in map(bpy.data.images.get, self.names) if image is not None]

    def extremes(self, image: bpy.types.Image) -> dict[str, float]:
        """The shares of an image that are nearly black and nearly white; {} if it is not a mask."""
        return self.drawn.get(str(self.names.index(image.name)), {})

    def label(self, image: bpy.types.Image) -> str:
        """The names of the values in an image, in the interface's language."""
        return ", ".join(map(translation.label, map(legend.label, self.held(image))))

    def held(self, image: bpy.types.Image) -> list[str]:
        """The names of the values in an image."""
        return self.holds[self.names.index(image.name)].split(",")


def keep(mesh: bpy.types.Mesh, made: ImageBake) -> None:
    """Stores the bake in place of an earlier one; a linked mesh cannot store it."""
    if mesh.library is None:
        record.write(mesh, {MEMBER: asdict(made)}, {}, {})


def found(target: bpy.types.Object | None) -> ImageBake | None:
    """The last bake of an object's mesh to images; None if there is none, or if none of its images exists any more."""
    if target is None:
        return None
    stored = record.read(target.data).get(MEMBER)
    made = ImageBake(**stored) if stored else None
    return made if made is not None and made.images else None


def folder_of(image: bpy.types.Image) -> Path:
    """The folder with the image's file."""
    return Path(bpy.path.abspath(image.filepath)).parent


def packed_files(image: bpy.types.Image) -> dict[str, bytes]:
    """The PNG files packed into the .blend, by the names that they would have on disk."""
    path = Path(image.filepath.removeprefix("//"))
    packed = {(item.tile_number if image.source == "TILED" else None): item for item in image.packed_files}
    return {tile_names.of_tile(path, tile).name: item.packed_file.data for tile, item in packed.items()}
