"""Reads displacement and normal maps from image files without Blender: PNG and OpenEXR, exactly. Never imports bpy."""

from pathlib import Path

import numpy as np

from ..bridge import InputError
from .exr_reading import read_exr
from .png_reading import read_png

# The largest numbers of a channel stand for 1. Blender multiplies too, so that one image is the same bits everywhere.
STEPS = {np.dtype(kind): np.float32(1.0) / np.float32(np.iinfo(kind).max) for kind in (np.uint8, np.uint16)}


def read_image(path: Path) -> tuple[np.ndarray, bool]:
    """(height, width, 3) float32 values of a file as they are, rows bottom-up, and whether that is over 8 bits."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f'The image "{path}" is none of {", ".join(READERS)}, which are read without Blender.')
    if not path.is_file():
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
    """(height, width, 3) float32 from 0 to 1, top row first, and whether it has 16 bits."""
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
    """(height, width, 3) of (height, width, 1 to 4): grey in each, and nothing of an alpha channel."""
    return pixels[:, :, :3] if pixels.shape[2] >= 3 else np.repeat(pixels[:, :, :1], 3, axis=2)


READERS = {".png": of_png, ".exr": of_exr}
