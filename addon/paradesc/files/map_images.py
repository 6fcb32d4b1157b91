"""Takes displacement and normal maps from image files, which OpenImageIO reads without Blender. Never imports bpy.

OpenImageIO is imported where it is used, and a sentence says how to install it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..bridge import InputError, SurfaceMaps
from .paths import is_file

# The largest number of a channel stands for 1. This multiplies as Blender does, so that an image has the same bits in
# both.
STEPS = {np.dtype(kind): np.float32(1.0) / np.float32(np.iinfo(kind).max) for kind in (np.uint8, np.uint16)}

SUFFIXES = (".png", ".exr")
INSTALL = "pip install paradesc[io]"
LONGEST = 200  # of a sentence of OpenImageIO's
LUMINANCE = (0.2126, 0.7152, 0.0722)  # the weights by which Blender turns a color into a number
# Gives (height, width, 3 or 4) float32 values of a file, rows bottom-up, and whether it has more than 8 bits.
Reader = Callable[[Path], tuple[np.ndarray, bool]]


@dataclass
class MapChoice:
    """The sources of maps: image files, or the object's material."""

    displacement: Path | None = None
    midlevel: float = 0.5
    scale: float = 1.0  # in units of the mesh
    normal_map: Path | None = None
    material: bool = False

    @property
    def any(self) -> bool:
        """Returns whether any map is given."""
        return self.material or self.displacement is not None or self.normal_map is not None


def of_files(choice: MapChoice, maps: SurfaceMaps, read: Reader) -> list[str]:
    """Fills the maps from image files, with their values unchanged; returns a note about each."""
    notes = []
    if choice.displacement is not None:
        pixels, fine = read(choice.displacement)
        maps.heights = luminance(pixels)
        maps.midlevel, maps.scale = choice.midlevel, choice.scale
        notes += displacement_notes(choice.displacement.name, maps, fine)
    if choice.normal_map is not None:
        maps.normals = read(choice.normal_map)[0][..., :3]
        notes.append(f'Normals are those of "{choice.normal_map.name}".')
    return notes


def displacement_notes(name: str, maps: SurfaceMaps, fine: bool) -> list[str]:
    """Notes about the displacement of the surface, and about the limits of an image with few bits."""
    notes = [f'The surface is displaced by "{name}", midlevel {maps.midlevel:g}, scale {maps.scale:g}.']
    if not fine and len(np.unique(maps.heights)) > 2:
        notes.append(f'"{name}" has 8 bits, each step of which is a slope of its own; use 16 bits or floats.')
    return notes


def luminance(pixels: np.ndarray) -> np.ndarray:
    """(height, width) float32 of (height, width, 3 or 4)."""
    return (pixels[..., :3].astype(np.float64) @ np.array(LUMINANCE)).astype(np.float32)


# ---- Files


def read_image(path: Path) -> tuple[np.ndarray, bool]:
    """(height, width, 3) float32 values of a file as they are, rows bottom-up, and whether that is over 8 bits."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f'The image "{path}" is none of {", ".join(SUFFIXES)}, which are read without Blender.')
    if not is_file(path):
        raise InputError(f'There is no image "{path}".')
    try:
        pixels, names = as_stored(path)
        pixels = in_three(pixels, names)
    except (ValueError, MemoryError) as error:
        said = str(error) or "there is not enough memory"
        raise InputError(f'The image "{path}" cannot be read: {said}.') from error
    steps = STEPS.get(pixels.dtype, np.float32(1))
    return np.ascontiguousarray(pixels[::-1].astype(np.float32) * steps), pixels.dtype != np.uint8


def as_stored(path: Path) -> tuple[np.ndarray, list[str]]:
    """(height, width, channels) numbers of the type in the file, top row first, and the names of the channels."""
    try:
        import OpenImageIO as images  # noqa: N813
    except ImportError as error:
        raise ValueError(f"it needs OpenImageIO, which is not installed; {INSTALL}") from error
    as_is = images.ImageSpec()
    as_is.attribute("oiio:UnassociatedAlpha", 1)  # colors are not multiplied by it
    opened = images.ImageInput.open(str(path), as_is)
    pixels = opened and opened.read_image(opened.spec().format)
    if pixels is None:
        said = " ".join((opened or images).geterror().split())
        raise ValueError(f"OpenImageIO finds it damaged ({said[:LONGEST]})")
    return pixels, list(opened.spec().channelnames)


def in_three(pixels: np.ndarray, names: list[str]) -> np.ndarray:
    """(height, width, 3) of red, green and blue, or of a single channel; alpha is dropped."""
    if {"R", "G", "B"} <= set(names):
        return pixels[:, :, [names.index(name) for name in "RGB"]]
    others = [place for place, name in enumerate(names) if name != "A"]
    if len(others) != 1:
        known = ", ".join(names[:8])
        raise ValueError(f"of its channels {known} none is the one to take; save it with R, G and B, or with Y")
    return np.repeat(pixels[:, :, others], 3, axis=2)
