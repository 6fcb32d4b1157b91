"""Contexts, meshes and fields of libparadesc as Python objects: numpy arrays in and out, errors as ParadescError."""

import ctypes
import signal
import threading
import weakref
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from ctypes import byref
from types import FrameType

import numpy as np

from . import abi
from .arrays import MeshArrays, SurfaceMaps, address, image, native_mesh, near_positions, shaped
from .library import InputError, check, components, load_library, new_struct, text
from .options import BACKENDS, Options, choice, int32, native_options

# The buffers that Mesh.read_buffer reads, with their number of values for each texel.
BUFFERS = {"position": 3, "normal": 3, "chart": 1, "neighbor": 1, "distortion": 4}
BACKEND_NAMES = {number: name for name, number in BACKENDS.items()}
# (stage, fraction of the whole) -> False to cancel
ProgressFunction = Callable[[str, float], bool]
# Ctrl-C, and what else asks a process to end.
NUMBERS = (signal.SIGINT, signal.SIGTERM)


class Closing(AbstractContextManager):
    """Base of what is closed at the end of a with statement."""

    def __exit__(self, *_error: object) -> None:
        self.close()


class Made(Closing):
    """Base of what the library made for a mesh: close() frees it, or else Python, together with the object."""

    def __init__(self, pointer: ctypes.c_void_p, vertex_count: int, destroy: Callable[[object], None]) -> None:
        self._pointer = pointer
        self.vertex_count = vertex_count
        self._finalizer = weakref.finalize(self, destroy, pointer)
        self._finalizer.atexit = False  # a thread may still use it then (core/threads.py)

    def close(self) -> None:
        """Frees it; the fields of a mesh stay usable."""
        self._finalizer()


class Field(Made):
    """Results at the vertices of one mesh."""

    def report(self) -> dict[str, float | int]:
        """pdesc_field_report by member name."""
        report = new_struct(abi.FieldReport)
        check(load_library().pdesc_field_get_report(self._pointer, byref(report)))
        return as_dict(report)

    @property
    def backend(self) -> str:
        """The backend that computed."""
        return BACKEND_NAMES[int(self.report()["backend"])]

    @property
    def device(self) -> str:
        """The name of the device that computed, for people."""
        return text(load_library().pdesc_field_device(self._pointer))

    def warnings(self) -> list[str]:
        """One sentence for each limit of these results."""
        return [line for line in text(load_library().pdesc_field_warnings(self._pointer)).splitlines() if line.strip()]

    def values(self, name: str) -> np.ndarray:
        """(vertex_count,) float32 of a descriptor or "coverage", (vertex_count, 3) of a vector; NaN if undefined."""
        width = components(name)
        values = np.empty(self.vertex_count if width == 1 else (self.vertex_count, width), np.float32)
        pointer = address(values)
        check(load_library().pdesc_field_values(self._pointer, name.encode(), pointer, len(values)))
        return values

    def mask(self) -> np.ndarray:
        """(vertex_count,) uint8 bits abi.MASK_*"""
        mask = np.empty(self.vertex_count, np.uint8)
        check(load_library().pdesc_field_mask(self._pointer, address(mask), self.vertex_count))
        return mask

    def map(self, name: str) -> np.ndarray:
        """(N, N) or (N, N, 3) float32 over the layout, rows from v = 0 up, NaN off the surface; of evaluate = texel."""
        size, width = load_library().pdesc_field_map_size(self._pointer), components(name)
        values = np.empty((size, size) if width == 1 else (size, size, width), np.float32)
        pointer = address(values)
        check(load_library().pdesc_field_map(self._pointer, name.encode(), pointer, values.size))
        return values


class Mesh(Made):
    """A mesh, its adjacency, charts and seams; made by Context.mesh()."""

    def report(self) -> dict[str, float | int]:
        """pdesc_mesh_report by member name."""
        report = new_struct(abi.MeshReport)
        check(load_library().pdesc_mesh_get_report(self._pointer, byref(report)))
        return as_dict(report)

    def set_positions(self, positions: np.ndarray) -> None:
        """New positions, (vertex_count, 3), for the same topology."""
        array = near_positions(positions)
        check(load_library().pdesc_mesh_set_positions(self._pointer, address(array), len(array)))

    def set_displacement(self, heights: np.ndarray | None, midlevel: float = 0.5, scale: float = 1.0) -> None:
        """Displaces the surface by (value - midlevel) scale of an image (height, width); None removes the image."""
        array, height, width = image(heights, "heights", (-1, -1))
        pointer = address(array)
        check(load_library().pdesc_mesh_set_displacement(self._pointer, pointer, width, height, midlevel, scale))

    def set_normal_map(self, colors: np.ndarray | None, corner_tangents: np.ndarray | None = None) -> None:
        """Takes the normals from an image (height, width, 3), in the tangent space of (corner_count, 4)."""
        array, height, width = image(colors, "the normal map", (-1, -1, 3))
        tangents, count = None, 0
        if corner_tangents is not None:
            tangents, count = shaped(corner_tangents, np.float32, "corner_tangents", (-1, 4)), len(corner_tangents)
        given = address(array), width, height, address(tangents), count
        check(load_library().pdesc_mesh_set_normal_map(self._pointer, *given))

    def set_maps(self, maps: SurfaceMaps) -> None:
        """Sets displacement and normal map, or removes those that are None."""
        self.set_displacement(maps.heights, maps.midlevel, maps.scale)
        self.set_normal_map(maps.normals, maps.corner_tangents)

    def near_seam(self, radius: float) -> np.ndarray:
        """(vertex_count,) bool: a seam of the UV map lies within radius, in units of the positions."""
        near = np.empty(self.vertex_count, np.uint8)
        pointer = address(near)
        check(load_library().pdesc_mesh_near_seam(self._pointer, radius, pointer, self.vertex_count))
        return near.astype(bool)

    def backend(self, options: Options | None = None, buffers: bool = False) -> str:
        """The backend that would compute with these options; under "auto" it may be another than the context's own."""
        native = native_options(options or Options(), buffers)
        number = ctypes.c_int32()
        check(load_library().pdesc_mesh_backend(self._pointer, byref(native), byref(number)))
        return BACKEND_NAMES[number.value]

    def compute(
        self,
        descriptors: Sequence[str],
        options: Options | None = None,
        progress: ProgressFunction | None = None,
        buffers: bool = False,
    ) -> Field:
        """Computes the named descriptors at every vertex from one sampling; buffers: baked buffers are to be read."""
        names = (ctypes.c_char_p * len(descriptors))(*[name.encode() for name in descriptors])
        native = native_options(options or Options(), buffers)
        pointer = abi.FieldPointer()
        # The object frees what is made even if an error is raised.
        field = Field(pointer, self.vertex_count, load_library().pdesc_field_destroy)
        with Call(progress) as callback:
            status = load_library().pdesc_compute(
                self._pointer, byref(native), names, len(descriptors), callback, None, byref(pointer)
            )
        check(status)
        return field

    def memory(
        self, descriptors: Sequence[str], options: Options | None = None, backend: str = "auto"
    ) -> dict[str, int]:
        """pdesc_memory by member name: the bytes that computing would take on this backend, not on the mesh's own."""
        names = (ctypes.c_char_p * len(descriptors))(*[name.encode() for name in descriptors])
        native = native_options(options or Options())
        memory = new_struct(abi.Memory)
        number = choice(BACKENDS, backend, "backend")
        asked = byref(native), names, len(descriptors), number
        check(load_library().pdesc_mesh_memory(self._pointer, *asked, byref(memory)))
        return as_dict(memory)

    def read_buffer(self, name: str) -> np.ndarray:
        """(size, size) or (size, size, c) float32 of what the last compute baked, rows from v = 0 up; see BUFFERS."""
        width = BUFFERS.get(name, 1)
        size = load_library().pdesc_mesh_buffer_size(self._pointer)
        values = np.empty((size, size) if width == 1 else (size, size, width), np.float32)
        pointer = address(values)
        check(load_library().pdesc_mesh_read_buffer(self._pointer, name.encode(), pointer, values.size))
        return values

    def layout(self) -> np.ndarray:
        """(triangle_count, 3, 2) float32 (u, v) in use: the UV map's, or those of the private layout."""
        count = int(self.report()["triangle_count"])
        uvs = np.empty((count, 3, 2), np.float32)
        check(load_library().pdesc_mesh_layout(self._pointer, address(uvs), count))
        return uvs


class Context(Closing):
    """A device and its compiled programs. Closing it closes the meshes made from it."""

    def __init__(self, backend: str = "auto", device_index: int = -1, threads: int = 0, memory_limit: int = 0) -> None:
        options = new_struct(abi.ContextOptions)
        options.backend = choice(BACKENDS, backend, "backend")
        options.device_index = int32(device_index, "device index")
        options.threads = int32(threads, "number of threads")
        options.memory_limit = memory_limit
        self._pointer = abi.ContextPointer()
        check(load_library().pdesc_context_create(byref(options), byref(self._pointer)))
        self._meshes: weakref.WeakSet[Mesh] = weakref.WeakSet()

    @property
    def backend(self) -> str:
        """The backend in use."""
        return BACKEND_NAMES[load_library().pdesc_context_backend(self._pointer)]

    @property
    def device(self) -> str:
        """The device's name, for people."""
        return text(load_library().pdesc_context_device(self._pointer))

    def mesh(self, arrays: MeshArrays, progress: ProgressFunction | None = None) -> Mesh:
        """Validates and copies a mesh, and builds its adjacency, charts and seams."""
        native, kept = native_mesh(arrays)
        pointer = abi.MeshPointer()
        # The object frees what is made even if an error is raised.
        mesh = Mesh(pointer, native.vertex_count, load_library().pdesc_mesh_destroy)
        self._meshes.add(mesh)
        with Call(progress) as native.progress:
            status = load_library().pdesc_mesh_create(self._pointer, byref(native), byref(pointer))
        del kept
        if status == abi.STATUS_INVALID_ARGUMENT:
            raise InputError(text(load_library().pdesc_last_error()))
        check(status)
        if arrays.maps is not None:
            mesh.set_maps(arrays.maps)
        return mesh

    def close(self) -> None:
        """Frees the meshes of this context, then the device."""
        for mesh in list(self._meshes):
            mesh.close()
        load_library().pdesc_context_destroy(self._pointer)
        self._pointer = abi.ContextPointer()


def allowed_memory(limit: int) -> int:
    """The bytes that may be used, as the library decides: the limit if it is above 0, else half of the free memory."""
    triangle = MeshArrays(np.eye(3, dtype=np.float32), np.arange(3, dtype=np.int32), np.arange(3, dtype=np.int32)[None])
    with Context("reference", memory_limit=limit) as context, context.mesh(triangle) as mesh:
        return mesh.memory(["mean_curvature"])["allowed"]


def as_dict(struct: ctypes.Structure) -> dict[str, float | int]:
    """A report struct by member name, without its size."""
    return {name: getattr(struct, name) for name, *_ in struct._fields_ if name != "struct_size"}


class Call:
    """A native call that reports progress, as a context: gives its C callback, raises at the end what came up in it.

    An exception may not cross C: that of the Python callback cancels the call and is raised after it. So is what
    handlers of Ctrl-C and SIGTERM raise, on the main thread: Python runs them where the next Python function begins,
    which during a native call is the callback, before its first line.

    Handlers still run at once, and one that raises nothing stops nothing. Handlers in C are left alone.
    """

    def __init__(self, progress: ProgressFunction | None) -> None:
        self._progress = progress
        self._caught: list[BaseException] = []
        self._former: dict[int, Callable[[int, FrameType | None], object]] = {}

    def __enter__(self) -> object:
        if threading.current_thread() is threading.main_thread():
            for number in NUMBERS:
                former = signal.getsignal(number)
                if callable(former):
                    self._former[number] = former
                    signal.signal(number, self._keep)
        return abi.Progress(self._report)

    def __exit__(self, kind: type | None, *_error: object) -> None:
        for number, former in self._former.items():
            signal.signal(number, former)
        if self._caught and kind is None:
            raise self._caught.pop(0)

    def _report(self, _user: int | None, stage: bytes, fraction: float) -> int:
        try:
            return int(not self._caught and (self._progress is None or bool(self._progress(text(stage), fraction))))
        except BaseException as error:  # noqa: BLE001 (raised again once the call has ended)
            self._caught.append(error)
            return 0

    def _keep(self, number: int, frame: FrameType | None) -> None:
        try:
            self._former[number](number, frame)
        except BaseException as error:  # noqa: BLE001 (raised again once the call has ended)
            self._caught.append(error)
