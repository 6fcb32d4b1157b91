"""Contexts, meshes and fields of libparadesc as Python objects: numpy arrays in and out, errors as ParadescError."""

import ctypes
import weakref
from collections.abc import Callable, Sequence
from ctypes import byref
from dataclasses import dataclass
from types import TracebackType

import numpy as np

from . import abi
from .library import InputError, ParadescError, check, components, load_library, new_struct, text

BACKENDS = {
    "auto": abi.BACKEND_AUTO,
    "gpu": abi.BACKEND_GPU,
    "software": abi.BACKEND_SOFTWARE,
    "reference": abi.BACKEND_REFERENCE,
}
NORMALS = {"fitted": abi.NORMALS_FITTED, "max": abi.NORMALS_MAX, "mesh": abi.NORMALS_MESH}
RADIUS_UNITS = {
    "diagonal": abi.RADIUS_DIAGONAL,
    "absolute": abi.RADIUS_ABSOLUTE,
    "mean-edge": abi.RADIUS_MEAN_EDGE,
}

RELOCATIONS = {
    "connected": abi.RELOCATION_CONNECTED,
    "affine": abi.RELOCATION_AFFINE,
    "paper": abi.RELOCATION_PAPER,
}
ESTIMATORS = {
    "shape-operator": abi.ESTIMATOR_SHAPE_OPERATOR,
    "integral": abi.ESTIMATOR_INTEGRAL,
    "extrapolated": abi.ESTIMATOR_EXTRAPOLATED,
}
VARIANCE_REDUCTIONS = {"shape": abi.VARIANCE_REDUCTION_SHAPE, "none": abi.VARIANCE_REDUCTION_NONE}
GEODESICS = {"local": abi.GEODESIC_LOCAL, "chords": abi.GEODESIC_CHORDS}
DISTANCES = {"euclidean": abi.DISTANCE_EUCLIDEAN, "geodesic": abi.DISTANCE_GEODESIC}
PATTERNS = {"golden-angle": abi.PATTERN_GOLDEN_ANGLE, "stratified": abi.PATTERN_STRATIFIED}
ELLIPSES = {"center": abi.ELLIPSE_CENTER, "directional": abi.ELLIPSE_DIRECTIONAL}
EVALUATIONS = {"vertex": abi.EVALUATE_VERTEX, "texel": abi.EVALUATE_TEXEL}
PRECISIONS = {"full": abi.PRECISION_FULL, "half": abi.PRECISION_HALF}
# Options that are a name: their choices, and what to call them in a sentence.
CHOICES = {
    "radius_unit": (RADIUS_UNITS, "radius unit"),
    "normals": (NORMALS, "kind of normals"),
    "relocation": (RELOCATIONS, "relocation"),
    "estimator": (ESTIMATORS, "estimator"),
    "variance_reduction": (VARIANCE_REDUCTIONS, "variance reduction"),
    "geodesic": (GEODESICS, "geodesic distance"),
    "distance": (DISTANCES, "distance"),
    "pattern": (PATTERNS, "pattern"),
    "ellipse": (ELLIPSES, "ellipse"),
    "evaluate": (EVALUATIONS, "place of evaluation"),
    "precision": (PRECISIONS, "precision"),
}
NUMBERS = {
    "samples": "number of samples",
    "buffer_size": "buffer size",
    "max_jumps": "number of jumps",
    "texels": "number of texels",
}
# What Mesh.read_buffer reads, and how many values a texel has of it.
BUFFERS = {"position": 3, "normal": 3, "chart": 1, "neighbor": 1, "distortion": 4}
# Of --adaptive without a number: radians.
ADAPTIVE_THRESHOLD = 0.05

# (stage, fraction of the whole) -> False to cancel
ProgressFunction = Callable[[str, float], bool]


@dataclass
class Layout:
    """A UV layout made for the computation, where a mesh has no usable UV map of its own."""

    uvs: np.ndarray  # (corner_count, 2) float32
    reason: str  # what the mesh's own map is lacking: "has no UV map"
    topology: str  # a name for the way the faces hang together that the layout fits
    kept: bool  # found in the mesh, where an earlier bake left it


@dataclass
class SurfaceMaps:
    """Images over a mesh's UV map, rows bottom-up, that displace its surface or say its normals."""

    heights: np.ndarray | None = None  # (height, width) float32
    midlevel: float = 0.5
    scale: float = 1.0  # in units of the positions
    normals: np.ndarray | None = None  # (height, width, 3) float32 in [0, 1], in tangent space
    corner_tangents: np.ndarray | None = None  # (corner_count, 4) float32: unit tangent, sign of the bitangent


@dataclass
class MeshArrays:
    """A triangle mesh as the native library reads it; a corner is a face's use of a vertex."""

    positions: np.ndarray  # (vertex_count, 3) float32
    corner_vertices: np.ndarray  # (corner_count,) int32
    triangle_corners: np.ndarray  # (triangle_count, 3) int32
    corner_uvs: np.ndarray | None = None  # (corner_count, 2) float32
    corner_normals: np.ndarray | None = None  # (corner_count, 3) float32
    triangle_smooth: np.ndarray | None = None  # (triangle_count,) uint8
    sharp_edges: np.ndarray | None = None  # (sharp_edge_count, 2) int32
    layout: Layout | None = None  # where corner_uvs come from, if not from the mesh's own UV map
    maps: SurfaceMaps | None = None

    @property
    def triangle_vertices(self) -> np.ndarray:
        """(triangle_count, 3) int32"""
        return self.corner_vertices[self.triangle_corners]


@dataclass
class Options:
    """How to compute; the defaults are those of pdesc_options_init."""

    radius: float = 0.02
    radius_unit: str = "diagonal"
    samples: int = 256
    buffer_size: int = 1024
    normals: str = "fitted"
    max_jumps: int = 8
    seed: int = 0
    seam_error: bool = False
    relocation: str = "connected"
    estimator: str = "shape-operator"
    variance_reduction: str = "shape"
    geodesic: str = "local"
    distance: str = "euclidean"
    pattern: str = "golden-angle"
    ellipse: str = "center"
    evaluate: str = "vertex"
    texels: int = 512
    precision: str = "full"
    adaptive: float = 0.0
    map_descriptor: str = "sphere_volume_normalized"
    map_sigma: float = 1.0
    harris_k: float = 0.04


class Field:
    """Results at the vertices of one mesh."""

    def __init__(self, library: ctypes.CDLL, pointer: ctypes.c_void_p, vertex_count: int) -> None:
        self._library = library
        self._pointer = pointer
        self._vertex_count = vertex_count
        self._finalizer = weakref.finalize(self, library.pdesc_field_destroy, pointer)
        self._finalizer.atexit = False  # a thread may still use it then (threads.py)

    def report(self) -> dict[str, float | int]:
        """pdesc_field_report by member name."""
        report = new_struct(self._library, abi.FieldReport)
        check(self._library, self._library.pdesc_field_get_report(self._pointer, byref(report)))
        return as_dict(report)

    def warnings(self) -> list[str]:
        """One sentence each about what limits these results."""
        return [line for line in text(self._library.pdesc_field_warnings(self._pointer)).splitlines() if line.strip()]

    def values(self, name: str) -> np.ndarray:
        """(vertex_count,) float32 of a descriptor or "coverage", (vertex_count, 3) of a vector; NaN where undefined."""
        return self._read(self._library.pdesc_field_values, name, components(name))

    def seam_error(self, name: str) -> np.ndarray:
        """(vertex_count,) float32 largest difference between a vertex' places in the UV map; NaN with one place."""
        return self._read(self._library.pdesc_field_seam_error, name)

    def mask(self) -> np.ndarray:
        """(vertex_count,) uint8 bits abi.MASK_*"""
        mask = np.empty(self._vertex_count, np.uint8)
        status = self._library.pdesc_field_mask(self._pointer, address(mask, abi.Uint8Pointer), self._vertex_count)
        check(self._library, status)
        return mask

    def map(self, name: str) -> np.ndarray:
        """(N, N) or (N, N, 3) float32 over the layout, rows from v = 0 up, NaN off the surface; of evaluate = texel."""
        size, width = self._library.pdesc_field_map_size(self._pointer), components(name)
        values = np.empty((size, size) if width == 1 else (size, size, width), np.float32)
        pointer = address(values, abi.Float32Pointer)
        check(self._library, self._library.pdesc_field_map(self._pointer, name.encode(), pointer, values.size))
        return values

    def close(self) -> None:
        """Frees the results."""
        self._finalizer()

    def __enter__(self) -> "Field":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _read(self, function: Callable[..., int], name: str, width: int = 1) -> np.ndarray:
        """(vertex_count,) or (vertex_count, width) float32 from one of the reading functions."""
        values = np.empty(self._vertex_count if width == 1 else (self._vertex_count, width), np.float32)
        status = function(self._pointer, name.encode(), address(values, abi.Float32Pointer), self._vertex_count)
        check(self._library, status)
        return values


class Mesh:
    """A mesh, its adjacency, charts and seams; made by Context.mesh()."""

    def __init__(self, library: ctypes.CDLL, pointer: ctypes.c_void_p, vertex_count: int) -> None:
        self._library = library
        self._pointer = pointer
        self.vertex_count = vertex_count
        self._finalizer = weakref.finalize(self, library.pdesc_mesh_destroy, pointer)
        self._finalizer.atexit = False  # a thread may still use it then (threads.py)

    def report(self) -> dict[str, float | int]:
        """pdesc_mesh_report by member name."""
        report = new_struct(self._library, abi.MeshReport)
        check(self._library, self._library.pdesc_mesh_get_report(self._pointer, byref(report)))
        return as_dict(report)

    def set_positions(self, positions: np.ndarray) -> None:
        """New positions, (vertex_count, 3) float32, for the same topology."""
        array = contiguous(positions, np.float32, "positions", 3)
        status = self._library.pdesc_mesh_set_positions(self._pointer, address(array, abi.Float32Pointer), len(array))
        check(self._library, status)

    def set_displacement(self, heights: np.ndarray | None, midlevel: float = 0.5, scale: float = 1.0) -> None:
        """Displaces the surface by (value - midlevel) scale of an image (height, width); None takes it away."""
        array, pointer, height, width = image(heights, "heights", 2)
        status = self._library.pdesc_mesh_set_displacement(self._pointer, pointer, width, height, midlevel, scale)
        check(self._library, status)
        del array

    def set_normal_map(self, colors: np.ndarray | None, corner_tangents: np.ndarray | None = None) -> None:
        """Takes the normals from an image (height, width, 3), in the tangent space of (corner_count, 4)."""
        array, pointer, height, width = image(colors, "the normal map", 3)
        tangents = None if corner_tangents is None else contiguous(corner_tangents, np.float32, "corner_tangents", 4)
        given = abi.Float32Pointer() if tangents is None else address(tangents, abi.Float32Pointer)
        count = 0 if tangents is None else len(tangents)
        status = self._library.pdesc_mesh_set_normal_map(self._pointer, pointer, width, height, given, count)
        check(self._library, status)
        del array

    def set_maps(self, maps: SurfaceMaps) -> None:
        """Both of them."""
        self.set_displacement(maps.heights, maps.midlevel, maps.scale)
        self.set_normal_map(maps.normals, maps.corner_tangents)

    def near_seam(self, radius: float) -> np.ndarray:
        """(vertex_count,) bool: a seam of the UV map lies within radius, in units of the positions."""
        near = np.empty(self.vertex_count, np.uint8)
        pointer = address(near, abi.Uint8Pointer)
        check(self._library, self._library.pdesc_mesh_near_seam(self._pointer, radius, pointer, self.vertex_count))
        return near.astype(bool)

    def compute(
        self, descriptors: Sequence[str], options: Options | None = None, progress: ProgressFunction | None = None
    ) -> Field:
        """Computes the named descriptors at every vertex from one sampling."""
        names = (ctypes.c_char_p * len(descriptors))(*[name.encode() for name in descriptors])
        native = native_options(self._library, options or Options())
        pointer = abi.FieldPointer()
        caught: list[BaseException] = []
        callback = progress_callback(progress, caught)
        status = self._library.pdesc_compute(
            self._pointer, byref(native), names, len(descriptors), callback, None, byref(pointer)
        )
        if caught:
            self._library.pdesc_field_destroy(pointer)
            raise caught[0]
        check(self._library, status)
        return Field(self._library, pointer, self.vertex_count)

    def memory(
        self, descriptors: Sequence[str], options: Options | None = None, backend: str = "auto"
    ) -> dict[str, int]:
        """pdesc_memory by member name: bytes that computing would take, on this backend instead of the mesh's own."""
        names = (ctypes.c_char_p * len(descriptors))(*[name.encode() for name in descriptors])
        native = native_options(self._library, options or Options())
        memory = new_struct(self._library, abi.Memory)
        number = choice(BACKENDS, backend, "backend")
        status = self._library.pdesc_mesh_memory(
            self._pointer, byref(native), names, len(descriptors), number, byref(memory)
        )
        check(self._library, status)
        return as_dict(memory)

    def read_buffer(self, name: str) -> np.ndarray:
        """(size, size) or (size, size, c) float32 of what the last compute baked, rows from v = 0 up; see BUFFERS."""
        width = BUFFERS.get(name, 1)
        size = self._library.pdesc_mesh_buffer_size(self._pointer)
        values = np.empty((size, size) if width == 1 else (size, size, width), np.float32)
        pointer = address(values, abi.Float32Pointer)
        status = self._library.pdesc_mesh_read_buffer(self._pointer, name.encode(), pointer, values.size)
        check(self._library, status)
        return values

    def layout(self) -> np.ndarray:
        """(triangle_count, 3, 2) float32 (u, v) in use: the UV map's, or those of the private layout."""
        count = int(self.report()["triangle_count"])
        uvs = np.empty((count, 3, 2), np.float32)
        check(self._library, self._library.pdesc_mesh_layout(self._pointer, address(uvs, abi.Float32Pointer), count))
        return uvs

    def close(self) -> None:
        """Frees the mesh; its fields stay usable."""
        self._finalizer()

    def __enter__(self) -> "Mesh":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


class Context:
    """A device and its compiled programs. Closing it closes the meshes made from it."""

    def __init__(self, backend: str = "auto", device_index: int = -1, threads: int = 0, memory_limit: int = 0) -> None:
        self._library = load_library()
        options = new_struct(self._library, abi.ContextOptions)
        options.backend = choice(BACKENDS, backend, "backend")
        options.device_index = int32(device_index, "device index")
        options.threads = int32(threads, "number of threads")
        options.memory_limit = memory_limit
        self._pointer = abi.ContextPointer()
        check(self._library, self._library.pdesc_context_create(byref(options), byref(self._pointer)))
        self._meshes: weakref.WeakSet[Mesh] = weakref.WeakSet()

    @property
    def backend(self) -> str:
        """The backend in use."""
        number = self._library.pdesc_context_backend(self._pointer)
        return next((name for name, value in BACKENDS.items() if value == number), str(number))

    @property
    def device(self) -> str:
        """The device's name, for people."""
        return text(self._library.pdesc_context_device(self._pointer))

    @property
    def fallback(self) -> str:
        """Why "auto" did not get a device, or ""."""
        return text(self._library.pdesc_context_fallback(self._pointer))

    def mesh(self, arrays: MeshArrays, progress: ProgressFunction | None = None) -> Mesh:
        """Validates and copies a mesh, and builds its adjacency, charts and seams."""
        native, kept = native_mesh(self._library, arrays)
        caught: list[BaseException] = []
        if progress is not None:
            native.progress = progress_callback(progress, caught)
        pointer = abi.MeshPointer()
        status = self._library.pdesc_mesh_create(self._pointer, byref(native), byref(pointer))
        del kept
        if caught:
            self._library.pdesc_mesh_destroy(pointer)
            raise caught[0]
        if status == abi.STATUS_INVALID_ARGUMENT:
            raise InputError(text(self._library.pdesc_last_error()))
        check(self._library, status)
        mesh = Mesh(self._library, pointer, native.vertex_count)
        self._meshes.add(mesh)
        if arrays.maps is not None:
            mesh.set_maps(arrays.maps)
        return mesh

    def close(self) -> None:
        """Frees the meshes of this context, then the device."""
        for mesh in list(self._meshes):
            mesh.close()
        self._library.pdesc_context_destroy(self._pointer)
        self._pointer = abi.ContextPointer()

    def __enter__(self) -> "Context":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def native_mesh(library: ctypes.CDLL, arrays: MeshArrays) -> tuple[abi.MeshInput, list[np.ndarray]]:
    """The C struct of a mesh, and the arrays that have to live as long as it is read."""
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
    native.positions = give(arrays.positions, np.float32, "positions", 3, abi.Float32Pointer)
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


def native_options(library: ctypes.CDLL, options: Options) -> abi.ComputeOptions:
    """The C struct of the options."""
    native = new_struct(library, abi.ComputeOptions)
    native.radius = options.radius
    native.adaptive = options.adaptive
    native.map_descriptor = options.map_descriptor.encode()
    native.map_sigma = options.map_sigma
    native.harris_k = options.harris_k
    for name, (choices, what) in CHOICES.items():
        setattr(native, name, choice(choices, getattr(options, name), what))
    for name, what in NUMBERS.items():
        setattr(native, name, int32(getattr(options, name), what))
    if not 0 <= options.seed < 2**32:
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, f"The seed {options.seed} is not between 0 and {2**32 - 1}.")
    native.seed = options.seed
    native.seam_error = int(options.seam_error)
    return native


def progress_callback(progress: ProgressFunction | None, caught: list[BaseException]) -> object:
    """A C callback that keeps what the Python one raised (Ctrl-C, for one) and cancels then."""
    if progress is None:
        return abi.Progress()

    def report(_user: int | None, stage: bytes, fraction: float) -> int:
        try:
            return int(bool(progress(text(stage), fraction)))
        except BaseException as error:  # noqa: BLE001 (raised again by the caller: no exception may cross C)
            caught.append(error)
            return 0

    return abi.Progress(report)


def as_dict(struct: ctypes.Structure) -> dict[str, float | int]:
    """A report struct by member name, without its size."""
    return {name: getattr(struct, name) for name, *_ in struct._fields_ if name != "struct_size"}


def choice(names: dict[str, int], name: str, what: str) -> int:
    """The number of a named choice; ParadescError lists the names there are."""
    if name not in names:
        sentence = f'There is no {what} "{name}"; choose one of {", ".join(names)}.'
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
    return names[name]


def int32(value: int, what: str) -> int:
    """The value itself where it fits the C type; ctypes would cut it silently."""
    if not -(2**31) <= value < 2**31:
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, f"The {what} {value} is out of range.")
    return value


def contiguous(array: np.ndarray, kind: type, name: str, width: int) -> np.ndarray:
    """(n,) or (n, width) array of the type wanted, copied only where it has to be."""
    result = np.ascontiguousarray(array, dtype=kind)
    shape_fits = result.ndim == 1 if width == 1 else result.ndim == 2 and result.shape[1] == width
    if not shape_fits:
        wanted = "(n,)" if width == 1 else f"(n, {width})"
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, f"{name} has shape {result.shape}, but {wanted} is needed.")
    return result


def image(pixels: np.ndarray | None, name: str, dimensions: int) -> tuple[np.ndarray | None, object, int, int]:
    """An image's pixels, which have to live as long as they are read, their address, height and width."""
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
