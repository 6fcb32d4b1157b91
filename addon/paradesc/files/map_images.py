"""Takes displacement and normal maps from image files, and reads PNG and OpenEXR itself. Never imports bpy."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..bridge import InputError, SurfaceMaps
from .exr_reading import read_exr
from .paths import is_file
from .png_reading import read_png

# The largest number of a channel stands for 1. This multiplies as Blender does, so that an image has the same bits in
# both.
STEPS = {np.dtype(kind): np.float32(1.0) / np.float32(np.iinfo(kind).max) for kind in (np.uint8, np.uint16)}

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
        """Whether any map is given."""
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
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f'The image "{path}" is none of {", ".join(READERS)}, which are read without Blender.')
    if not is_file(path):
        raise InputError(f'There is no image "{path}".')
    try:
        pixels, fine = reader(path)
    except ValueError as error:
        raise InputError(f'The image "{path}" cannot be read: {error}.') from error
    except (OSError, MemoryError) as error:
        said = getattr(error, "strerror", None) or "there is not enough memory"
        raise InputError(f'The image "{path}" cannot be read: {said}.') from error
    return np.ascontiguousarray(pixels[::-1]), fine


def of_png(path: Path) -> tuple[np.ndarray, bool]:
    """(height, width, 3) float32 from 0 to 1, top row first, and whether the file has 16 bits."""
    found = read_png(path)
    return in_three(found.astype(np.float32) * STEPS[found.dtype]), found.dtype == np.uint16


def of_exr(path: Path) -> tuple[np.ndarray, bool]:
    """(height, width, 3) float32, top row first, of red, green and blue or of a single channel; always floats."""
    channels = read_exr(path)
    values = {name: channel for name, channel in channels.items() if name != "A"}
    if {"R", "G", "B"} <= values.keys():
        return np.stack([values[name] for name in "RGB"], axis=2), True
    if len(values) != 1:
        known = ", ".join(list(channels)[:8])
        raise ValueError(f"of its channels {known} none is the one to take; save it with R, G and B, or with Y")
    (grey,) = values.values()
    return in_three(grey[:, :, None]), True


def in_three(pixels: np.ndarray) -> np.ndarray:
    """(height, width, 3) of (height, width, 1 to 4): grey is repeated, and alpha is dropped."""
    return pixels[:, :, :3] if pixels.shape[2] >= 3 else np.repeat(pixels[:, :, :1], 3, axis=2)


READERS = {".png": of_png, ".exr": of_exr}
