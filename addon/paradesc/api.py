"""The Python package: descriptors of meshes that are numpy arrays, or meshes of trimesh, PyVista or Open3D.

    import paradesc
    result = paradesc.compute(vertices, faces, ["mean_curvature", "gaussian_curvature"], radius=0.02)
    result["mean_curvature"]  # (n,) float32

What is computed is the method of Andreadis, Papaioannou and Mavridis, "GPU Accelerated Computation of Geometric
Descriptors in Parametric Space"; descriptors() lists what there is, each with its equation. Imports no part of Blender.
"""

import threading
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .bridge import Descriptor, InputError, MeshArrays, ParadescError, ProgressFunction, abi, descriptors, origin
from .core import balance, face_centers, job
from .core.balance import Profile
from .core.polygons import Polygons, triangle_corners
from .core.stream import Stream
from .numpy_api import inputs, options, other_meshes
from .numpy_api.result import Result

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Descriptor", "InputError", "Mesh", "ParadescError", "Profile", "Result", "compute", "descriptors", "profile"]

# (stage, fraction of the whole) -> False to cancel
Progress = Callable[[str, float], object]


def compute(
    vertices: "ArrayLike | Any",
    faces: "ArrayLike | Sequence[Sequence[int]] | None" = None,
    descriptors: str | Sequence[str] = ("mean_curvature",),
    radius: float | Sequence[float] | Literal["auto"] = 0.02,
    *,
    radius_unit: options.RadiusUnit = "diagonal",
    samples: int = 256,
    uvs: "ArrayLike | None" = None,
    corner_normals: "ArrayLike | None" = None,
    sharp_edges: "ArrayLike | None" = None,
    creases: options.Creases = "auto",
    normals: options.Normals = "fitted",
    estimator: options.Estimator = "shape-operator",
    distance: options.Distance = "euclidean",
    domain: options.Domain = "vertices",
    map_descriptor: str = "sphere_volume_normalized",
    backend: options.Backend = "auto",
    device_index: int = -1,
    threads: int = 0,
    memory_limit: int = 0,
    progress: Progress | None = None,
    **more: "Unpack[options.MoreOptions]",
) -> Result:
    """Computes descriptors at every vertex or face of a mesh, in their order.

    vertices: (n, 3) real numbers, or a mesh of trimesh, PyVista or Open3D, which has its faces. The library computes
        with 32-bit floats; a mesh farther from the origin than it is large is moved there first, so nothing is lost.
    faces: (m, 3) triangles, (m, k) polygons, or a list of lists of any lengths: vertices counted from 0,
        counterclockwise as seen from outside. Polygons may be concave.
    descriptors: a name or several, of those that paradesc.descriptors() lists.
    radius: of the neighborhood that is measured; of several, values are named "mean_curvature_r0.01". In radius_unit:
        "diagonal" (of the bounding box, times it), "absolute" or "mean-edge" (times it). "auto": as profile() finds it,
        and the estimator that then errs less, unless another than "shape-operator" is asked for.
    samples: of the neighborhood of a vertex, at least. distance: what is near in space, or along the surface.
    uvs: (n, 2) at vertices, (corners, 2) or (m, k, 2) at corners of faces; needed by the backends gpu and software.
    corner_normals: the same with 3, for normals "mesh"; "fitted" to the surface and "max" (Max 1999) need none.
    sharp_edges: (k, 2) vertices; creases "auto" finds more by angles, "marked" takes these, "none" measures past them.
    estimator: of curvature: "shape-operator" as fitted, "extrapolated" to radius 0, or the paper's "integral" (8, 11-14).
    domain: "faces" measures each at its middle. map_descriptor: what operators (laplacian, harris and so on) work on.
    backend: "auto" takes all cores ("cpu"); "gpu" a graphics card; "reference" integrates exactly, and slowly.
    threads: 0 is all cores; values do not depend on it. memory_limit: bytes, 0 is half of what is free.
    progress: called as progress(stage, fraction); returns False to cancel. more: see options.MoreOptions.

    Values are float32, (n,) or (n, 3); NaN at vertices without a face, at faces without an area, and wherever else a
    descriptor does not exist. Arrays are not changed. May be called from several threads. Ctrl-C ends it at once.
    Errors: InputError, a ValueError, for arrays (empty ones too) and options that cannot be used; ParadescError for
    what cannot be computed here (no such device, too little memory) or was cancelled. Each is one sentence.
    """
    named = {
        "radius_unit": radius_unit, "samples": samples, "creases": creases, "normals": normals,
        "estimator": estimator, "distance": distance, "map_descriptor": map_descriptor, "backend": backend,
        "device_index": device_index, "threads": threads, "memory_limit": memory_limit, "domain": domain,
    }  # fmt: skip
    with plain_errors():
        settings = options.settings_of(descriptors, radius, {**named, **more})
        told = cancelling(progress)
        check_normals(settings, corner_normals)
        points, polygons = surface_of(vertices, faces)
        arrays = inputs.mesh_arrays(points, polygons, uvs, corner_normals, sharp_edges)
        return Result(face_centers.run_where_asked(arrays, settings, told, polygons.sizes))


def profile(
    vertices: "ArrayLike | Any",
    faces: "ArrayLike | Sequence[Sequence[int]] | None" = None,
    descriptor: str = "mean_curvature",
    radii: Sequence[float] | None = None,
    at: "ArrayLike | None" = None,
    *,
    radius_unit: options.RadiusUnit = "diagonal",
    sharp_edges: "ArrayLike | None" = None,
    progress: Progress | None = None,
    **more: Any,
) -> Profile:
    """Mean curvatures over radii, how much noise and the radius change them, and at which radius that is least.

    vertices, faces: as compute() takes them. descriptor: "mean_curvature", the one whose standard error is known.
    radii: two or more, in radius_unit; None: from the mean edge to 16 % of the diagonal, in steps of about √2.
    at: vertices, (j,) from 0, which the arrays are of; None: all. more: other options of compute(), such as the
        estimator: "shape-operator" or "extrapolated".

    Returns a Profile: radii (k,), values, standard_error and bias (k, n), best (n,), radius and expected, see there and
    the manual. Errors are those of compute(), and InputError where noise is not known: by normals "mesh" and on devices.
    """
    with plain_errors():
        if descriptor != balance.MEAN:
            raise InputError(f"descriptor is {options.shown(descriptor)}; only mean_curvature has a standard error.")
        settings = options.settings_of(descriptor, 0.02, more)
        points, polygons = surface_of(vertices, faces)
        arrays = inputs.mesh_arrays(points, polygons, None, None, sharp_edges)
        lengths = balance.usual_radii(arrays) if radii is None else options.lengths_of(radii, radius_unit, arrays)
        told = cancelling(progress)
        found = balance.profile(settings, arrays, lengths, lambda asked: job.run(arrays, asked, told))
        return found if at is None else found.at(inputs.vertices_of(at, len(points)))


class Mesh:
    """A mesh that is kept for several computations: of other descriptors and radii, or of frames that move it.

        with paradesc.Mesh(vertices, faces) as mesh:
            for frame in frames:
                mesh.positions = frame
                result = mesh.compute("mean_curvature", 0.05, radius_unit="absolute")

    What does not depend on positions is made once. A frame has the very bits that compute() gives for its positions.
    The arguments are those of compute(); errors too. Threads that use one mesh wait for each other.
    """

    def __init__(
        self,
        vertices: "ArrayLike | Any",
        faces: "ArrayLike | Sequence[Sequence[int]] | None" = None,
        *,
        uvs: "ArrayLike | None" = None,
        sharp_edges: "ArrayLike | None" = None,
        backend: options.Backend = "auto",
        device_index: int = -1,
        threads: int = 0,
        memory_limit: int = 0,
    ) -> None:
        self._machine = {
            "backend": backend, "device_index": device_index, "threads": threads, "memory_limit": memory_limit,
        }  # fmt: skip
        with plain_errors():
            settings = options.settings_of("mean_curvature", 0.02, self._machine)
            self._points, self._polygons = surface_of(vertices, faces)
            arrays = inputs.mesh_arrays(self._points, self._polygons, uvs, None, sharp_edges)
            self._near = origin.near_origin(self._points)  # the points as the library reads them
            self._stream: Stream | None = Stream(arrays, settings)
        self._lock = threading.RLock()
        self._finalizer = weakref.finalize(self, self._stream.leave)
        self._finalizer.atexit = False  # a thread may still use it then

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, 3) float64 in use, which cannot be written into; assign (n, 3) others for the next frame."""
        shown = self._points.view()
        shown.flags.writeable = False
        return shown

    @positions.setter
    def positions(self, vertices: "ArrayLike") -> None:
        with plain_errors(), self._lock:
            points = inputs.points_of(vertices)
            if points.shape != self._points.shape:
                raise InputError(f"positions has the shape {points.shape}, but the mesh has {self._points.shape}.")
            self._points, self._near = points, origin.near_origin(points)

    @property
    def report(self) -> dict[str, float | int]:
        """What was found in the mesh, at its positions: counts of its parts and defects, its diagonal and mean edge."""
        with plain_errors(), self._lock:
            stream = self._opened()
            return stream.mesh_at(self._arrays(stream)).report()

    def compute(
        self,
        descriptors: str | Sequence[str] = ("mean_curvature",),
        radius: float | Sequence[float] | Literal["auto"] = 0.02,
        *,
        radius_unit: options.RadiusUnit = "diagonal",
        samples: int = 256,
        corner_normals: "ArrayLike | None" = None,
        creases: options.Creases = "auto",
        normals: options.Normals = "fitted",
        estimator: options.Estimator = "shape-operator",
        distance: options.Distance = "euclidean",
        map_descriptor: str = "sphere_volume_normalized",
        progress: Progress | None = None,
        **more: "Unpack[options.MoreOptions]",
    ) -> Result:
        """Computes descriptors at the positions of now; arguments, values and errors are those of paradesc.compute().

        A radius in shares of the diagonal follows a mesh that grows; "absolute" is the same in all frames.
        """
        named = {
            "radius_unit": radius_unit, "samples": samples, "creases": creases, "normals": normals,
            "estimator": estimator, "distance": distance, "map_descriptor": map_descriptor,
        }  # fmt: skip
        with plain_errors(), self._lock:
            stream = self._opened()
            settings = options.settings_of(descriptors, radius, {**named, **more, **self._machine})
            if settings.domain != "vertices":
                raise InputError("A paradesc.Mesh has values at vertices; paradesc.compute() has them at faces.")
            told = cancelling(progress)
            check_normals(settings, corner_normals)
            own_normals = inputs.normals_of(corner_normals, len(self._points), self._polygons)
            positions = self._arrays(stream).positions
            stream.settings = job.fitted(settings, self._arrays(stream))
            return Result(stream.compute(positions, told, own_normals))

    def close(self) -> None:
        """Frees memory and device; results stay."""
        with self._lock:
            self._finalizer.detach()
            if self._stream is not None:
                self._stream.close()
            self._stream = None

    def __enter__(self) -> "Mesh":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _opened(self) -> Stream:
        if self._stream is None:
            raise ParadescError(abi.STATUS_INVALID_OPERATION, "The mesh is closed.")
        return self._stream

    def _arrays(self, stream: Stream) -> MeshArrays:
        """The mesh at its positions; polygons that have bent may be cut into other triangles."""
        triangles = stream.arrays.triangle_corners
        if len(triangles) != len(self._polygons.starts) - 1:
            triangles = triangle_corners(self._polygons, self._points)
        moved = replace(stream.arrays, positions=self._near, triangle_corners=triangles)
        if not np.array_equal(triangles, stream.arrays.triangle_corners):
            stream.replace(moved)
        return moved


def surface_of(vertices: object, faces: object) -> tuple[NDArray[np.float64], Polygons]:
    """(n, 3) float64 points and the polygons of what was given: two arrays, or a mesh of another package."""
    if faces is None:
        vertices, faces = other_meshes.vertices_and_faces(vertices)
    if faces is None:
        raise InputError("faces is missing; give faces, or a mesh of trimesh, PyVista or Open3D that has them.")
    points = inputs.points_of(vertices)
    return points, inputs.polygons_of(faces, len(points))


def check_normals(settings: job.Settings, corner_normals: object) -> None:
    """Refuses to measure by the mesh's own normals where there are none."""
    if settings.options.normals == "mesh" and corner_normals is None:
        raise InputError('corner_normals is missing; give them, or choose normals "fitted" or "max".')


def cancelling(progress: Progress | None) -> ProgressFunction | None:
    """A progress function that cancels where the given one returns False, and not where it returns nothing."""
    if progress is None:
        return None
    if not callable(progress):
        raise InputError(f"progress is {options.shown(progress)}; give a function of stage and fraction.")

    def tell(stage: str, fraction: float) -> bool:
        answer = progress(stage, fraction)
        return bool(answer) or not isinstance(answer, (bool, np.bool_))

    return tell


@contextmanager
def plain_errors() -> Iterator[None]:
    """Makes what cannot be used an InputError, wherever it was found, and says where memory ends."""
    try:
        yield
    except InputError:
        raise
    except ParadescError as error:
        if error.status != abi.STATUS_INVALID_ARGUMENT:
            raise
        raise InputError(error.sentence) from None
    except MemoryError:
        raise ParadescError(abi.STATUS_OUT_OF_MEMORY, "There is not enough memory for a mesh of this size.") from None
