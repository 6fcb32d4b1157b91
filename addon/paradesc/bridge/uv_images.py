"""Images over a UV map, drawn by the native library: numpy arrays in and out, no context and no device."""

from ctypes import byref
from dataclasses import dataclass

import numpy as np

from . import abi
from .arrays import address, shaped
from .library import check, load_library, new_struct
from .options import int32
from .session import Call, ProgressFunction


@dataclass(frozen=True)
class TexelMap:
    """Values evaluated at texels, and the layout of the triangles over them."""

    values: np.ndarray  # (M, M) or (M, M, 3) float32, rows from v = 0 up
    layout: np.ndarray  # (triangle_count, 3, 2) float32


def draw_uv_image(
    uvs: np.ndarray,
    triangle_values: np.ndarray,
    values: np.ndarray,
    size: int,
    texels: TexelMap | None = None,
    progress: ProgressFunction | None = None,
    numbers: bool = False,
) -> np.ndarray:
    """(N, N, 1 or 3) float32 of values (n,) or (n, 3) at the corners of triangles, rows from v = 0 up; NaN off them.

    uvs: (triangle_count, 3, 2). triangle_values: (triangle_count, 3) which value each corner has. numbers: values are
    (n, k) with k up to 6, of which each is a number by itself and not part of a direction.
    """
    corners = shaped(triangle_values, np.int32, "triangle_values", (-1, 3))
    places = shaped(uvs, np.float32, "uvs", (len(corners), 3, 2))
    width = 1 if values.ndim == 1 else values.shape[1] if numbers else 3
    column = shaped(values, np.float32, "values", (-1,) if values.ndim == 1 else (-1, width))
    native = new_struct(abi.UvImageInput)
    native.size = int32(size, "number of texels")
    native.triangle_count, native.value_count, native.components = len(corners), len(column), width
    native.uvs, native.triangle_values = address(places), address(corners)
    native.values, native.numbers = address(column), numbers
    if texels is not None:
        side = len(texels.values)
        source = shaped(texels.values, np.float32, "the map", (side, side, 3) if width == 3 else (side, side))
        layout = shaped(texels.layout, np.float32, "the layout", places.shape)
        native.map, native.map_size = address(source), side
        native.map_uvs = address(layout)
    image = np.empty((max(size, 0), max(size, 0), width), np.float32)
    with Call(progress) as native.progress:
        status = load_library().pdesc_uv_image_draw(byref(native), address(image), image.size)
    check(status)
    return image


def fill_gutter(image: np.ndarray, steps: int) -> np.ndarray:
    """(height, width, c) float32 with rings of undefined texels filled from their neighbors, 0 beyond the gutter."""
    filled = np.array(image, np.float32, order="C")
    height, width, components = filled.shape
    pointer = address(filled)
    check(load_library().pdesc_uv_image_fill_gutter(pointer, filled.size, width, height, components, steps, 0))
    return filled
