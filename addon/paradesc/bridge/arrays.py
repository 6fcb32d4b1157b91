"""Holds meshes as numpy arrays, and makes the C structs and pointers through which the native library reads them."""

import ctypes
from dataclasses import dataclass

import numpy as np

from . import abi, origin
from .library import ParadescError, new_struct


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


def native_mesh(library: ctypes.CDLL, arrays: MeshArrays) -> tuple[abi.MeshInput, list[np.ndarray]]:
    """The C struct of a mesh, and the arrays that must stay alive while the library reads it."""
    kept: list[np.ndarray] = []

    def give(array: np.ndarray | None, kind: type, name: str, width: int, pointer: type) -> object:
        if array is None:
            return pointer()
        kept.append(contiguous(array, kind, name, width))
        return address(kept[-1], pointer)

    native = new_struct(library, abi.MeshInput)
    native.vertex_count = len(arrays.positions)
    native.corner_count = len(arrays.corner_vertices)
    native.triangle_count = len(arrays.triangle_corners)
    native.positions = give(near_positions(arrays.positions), np.float32, "positions", 3, abi.Float32Pointer)
    native.corner_vertices = give(arrays.corner_vertices, np.int32, "corner_vertices", 1, abi.Int32Pointer)
    native.triangle_corners = give(arrays.triangle_corners, np.int32, "triangle_corners", 3, abi.Int32Pointer)
    native.corner_uvs = give(arrays.corner_uvs, np.float32, "corner_uvs", 2, abi.Float32Pointer)
    native.corner_normals = give(arrays.corner_normals, np.float32, "corner_normals", 3, abi.Float32Pointer)
    native.triangle_smooth = give(arrays.triangle_smooth, np.uint8, "triangle_smooth", 1, abi.Uint8Pointer)
    native.sharp_edges = give(arrays.sharp_edges, np.int32, "sharp_edges", 2, abi.Int32Pointer)
    native.sharp_edge_count = 0 if arrays.sharp_edges is None else len(arrays.sharp_edges)
    for name, array, count in (
        ("corner_uvs", arrays.corner_uvs, native.corner_count),
        ("corner_normals", arrays.corner_normals, native.corner_count),
        ("triangle_smooth", arrays.triangle_smooth, native.triangle_count),
    ):
        if array is not None and len(array) != count:
            sentence = f"{name} has {len(array)} rows, but {count} are needed."
            raise ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
    return native, kept


def near_positions(positions: np.ndarray) -> np.ndarray:
    """(vertex_count, 3) float32 positions for the library, moved near the origin if they are far from it."""
    return origin.near_origin(contiguous(positions, np.asarray(positions).dtype, "positions", 3))


def contiguous(array: np.ndarray, kind: type, name: str, width: int) -> np.ndarray:
    """(n,) or (n, width) array of the type wanted, copied only if necessary."""
    result = np.ascontiguousarray(array, dtype=kind)
    shape_fits = result.ndim == 1 if width == 1 else result.ndim == 2 and result.shape[1] == width
    if not shape_fits:
        wanted = "(n,)" if width == 1 else f"(n, {width})"
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, f"{name} has shape {result.shape}, but {wanted} is needed.")
    return result


def image(pixels: np.ndarray | None, name: str, dimensions: int) -> tuple[np.ndarray | None, object, int, int]:
    """An image's pixels with their address, height and width. Keep the pixels alive while the library reads them."""
    if pixels is None:
        return None, abi.Float32Pointer(), 0, 0
    array = np.ascontiguousarray(pixels, dtype=np.float32)
    if array.ndim != dimensions or (dimensions == 3 and array.shape[2] != 3):
        wanted = "(height, width)" if dimensions == 2 else "(height, width, 3)"
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, f"{name} has shape {array.shape}, but {wanted} is needed.")
    return array, address(array, abi.Float32Pointer), array.shape[0], array.shape[1]


def address(array: np.ndarray, pointer: type) -> object:
    """A typed C pointer to the array's first element."""
    return array.ctypes.data_as(pointer)
