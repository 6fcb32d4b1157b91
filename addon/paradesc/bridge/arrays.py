"""Holds meshes as numpy arrays, and makes the C structs and pointers through which the native library reads them."""

from dataclasses import dataclass

import numpy as np

from . import abi, origin
from .library import new_struct, unusable

POINTERS = {np.float32: abi.Float32Pointer, np.int32: abi.Int32Pointer, np.uint8: abi.Uint8Pointer}


@dataclass
class Layout:
    """A UV layout made for the computation, because the mesh has no usable UV map of its own."""

    uvs: np.ndarray  # (corner_count, 2) float32
    reason: str  # the fault of the mesh's own map: "has no UV map"
    topology: str  # names the way in which the faces are connected, which the layout fits
    kept: bool  # whether an earlier bake stored it in the mesh


@dataclass
class SurfaceMaps:
    """Images over a mesh's UV map, rows bottom-up, which displace its surface or define its normals."""

    heights: np.ndarray | None = None  # (height, width) float32
    midlevel: float = 0.5
    scale: float = 1.0  # in units of the positions
    normals: np.ndarray | None = None  # (height, width, 3) float32 in [0, 1], in tangent space
    corner_tangents: np.ndarray | None = None  # (corner_count, 4) float32: unit tangent, sign of the bitangent


@dataclass
class MeshArrays:
    """A triangle mesh as the native library reads it; a corner is a face's use of a vertex."""

    positions: np.ndarray  # (vertex_count, 3) float32, or float64 where it lies far from the origin
    corner_vertices: np.ndarray  # (corner_count,) int32
    triangle_corners: np.ndarray  # (triangle_count, 3) int32
    corner_uvs: np.ndarray | None = None  # (corner_count, 2) float32
    corner_normals: np.ndarray | None = None  # (corner_count, 3) float32
    triangle_smooth: np.ndarray | None = None  # (triangle_count,) uint8
    sharp_edges: np.ndarray | None = None  # (sharp_edge_count, 2) int32
    layout: Layout | None = None  # where corner_uvs come from, if not from the mesh's own UV map
    maps: SurfaceMaps | None = None
    uv_fault: str = ""  # why the mesh's own UV map is not in corner_uvs: "has a UV map without area"

    @property
    def map_fault(self) -> str:
        """The reason why no image can lie over the mesh's own UV map: "has no UV map"; "" if one can."""
        is_usable = self.corner_uvs is not None and self.layout is None
        return "" if is_usable else self.uv_fault or "has no UV map"

    @property
    def triangle_vertices(self) -> np.ndarray:
        """(triangle_count, 3) int32"""
        return self.corner_vertices[self.triangle_corners]


def native_mesh(arrays: MeshArrays) -> tuple[abi.MeshInput, list[np.ndarray]]:
    """The C struct of a mesh, and the arrays that must stay alive while the library reads it."""
    native = new_struct(abi.MeshInput)
    native.vertex_count = len(arrays.positions)
    native.corner_count, native.triangle_count = len(arrays.corner_vertices), len(arrays.triangle_corners)
    kept: list[np.ndarray] = []
    for name, kind, width, count in (
        ("positions", np.float32, 3, -1),
        ("corner_vertices", np.int32, 1, -1),
        ("triangle_corners", np.int32, 3, -1),
        ("corner_uvs", np.float32, 2, native.corner_count),
        ("corner_normals", np.float32, 3, native.corner_count),
        ("triangle_smooth", np.uint8, 1, native.triangle_count),
        ("sharp_edges", np.int32, 2, -1),
    ):
        array = near_positions(arrays.positions) if name == "positions" else getattr(arrays, name)
        if array is not None:
            kept.append(shaped(array, kind, name, (-1,) if width == 1 else (-1, width)))
            setattr(native, name, address(kept[-1]))
            if count not in (-1, len(array)):
                raise unusable(f"{name} has {len(array)} rows, but {count} are needed.")
    native.sharp_edge_count = 0 if arrays.sharp_edges is None else len(arrays.sharp_edges)
    return native, kept


def near_positions(positions: np.ndarray) -> np.ndarray:
    """(vertex_count, 3) float32 positions for the library, moved near the origin if they are far from it."""
    return origin.near_origin(shaped(positions, np.asarray(positions).dtype, "positions", (-1, 3)))


def shaped(array: np.ndarray, kind: type, name: str, shape: tuple[int, ...], wanted: str = "") -> np.ndarray:
    """The array in the type wanted, copied only where it has to be; -1 is any length; wanted: the shape in an error."""
    result = np.ascontiguousarray(array, dtype=kind)
    fits = result.ndim == len(shape) and all(want in (-1, have) for want, have in zip(shape, result.shape, strict=True))
    if not fits:
        wanted = wanted or str(shape).replace("-1", "n")
        raise unusable(f"{name} has shape {result.shape}, but {wanted} is needed.")
    return result


def image(pixels: np.ndarray | None, name: str, shape: tuple[int, ...]) -> tuple[np.ndarray | None, int, int]:
    """An image's pixels as 32-bit floats, and its height and width."""
    if pixels is None:
        return None, 0, 0
    wanted = "(height, width)" if len(shape) == 2 else "(height, width, 3)"
    array = shaped(pixels, np.float32, name, shape, wanted)
    return array, array.shape[0], array.shape[1]


def address(array: np.ndarray | None) -> object:
    """A typed C pointer to the array's first element, null without an array; keep the array while it is read."""
    return None if array is None else array.ctypes.data_as(POINTERS[array.dtype.type])
