"""The Python package: descriptors of meshes that are numpy arrays, or meshes of trimesh, PyVista or Open3D.

    import paradesc
    result = paradesc.compute(vertices, faces, ["mean_curvature", "curvedness"], radius=0.08, radius_unit="absolute")
    result["mean_curvature"]  # (n,) float32

What is computed is the method of Andreadis, Papaioannou and Mavridis, "GPU Accelerated Computation of Geometric
Descriptors in Parametric Space"; descriptors() lists what there is, each with its equation. Imports no part of Blender.
"""

import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import takewhile
from traceback import walk_stack
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
from .numpy_api.result import Mask, ParadescWarning, Result

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "Descriptor", "InputError", "Mask", "Mesh", "ParadescError", "ParadescWarning", "Profile", "Result",
    "compute", "descriptors", "profile",
]  # fmt: skip

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

    Parameters
    ----------
    vertices : (n, 3) array_like, or a mesh of trimesh, PyVista or Open3D
        Real numbers. A mesh of another package has its faces. The library takes 32-bit floats; a mesh farther from the
        origin than it is large is moved there first, so that they hold its shape.
    faces : (m, 3) or (m, k) array_like, or a sequence of sequences
        Triangles or polygons, which may be concave: vertices counted from 0, counterclockwise as seen from outside.
    descriptors : str or sequence of str
        Of those that paradesc.descriptors() lists.
    radius : float, sequence of float, or "auto"
        Of the neighborhood that is measured. With several, result["mean_curvature", 0.01] has the values of one, and
        "mean_curvature_r0.01" is their name. "auto": as profile() finds it, and the estimator that then errs less,
        unless another than "shape-operator" is asked for.
    radius_unit : {"diagonal", "absolute", "mean-edge"}
        What a radius counts: the bounding box's diagonal, the unit of the vertices, or the mean edge.
    samples : int
        Of the neighborhood of a vertex, at least.
    uvs : (n, 2), (corners, 2) or (m, k, 2) array_like
        At vertices or at corners of faces; the backends "gpu" and "software" need them.
    corner_normals : (n, 3), (corners, 3) or (m, k, 3) array_like
        For normals "mesh".
    sharp_edges : (k, 2) array_like
        Vertices of edges that are hard.
    creases : {"auto", "marked", "none"}
        "auto" finds more hard edges by their angles, "marked" takes sharp_edges, and "none" measures past them.
    normals : {"fitted", "max", "mesh"}
        Fitted to the surface, by Max (1999), or those that are given.
    estimator : {"shape-operator", "extrapolated", "integral"}
        Of curvature: as fitted, extrapolated to radius 0, or by the paper's integrals (8, 11-14).
    distance : {"euclidean", "geodesic"}
        What is near in space, or along the surface.
    domain : {"vertices", "faces"}
        "faces" measures each at its middle.
    map_descriptor : str
        What operators (laplacian, harris and so on) work on.
    backend : {"auto", "cpu", "gpu", "software", "reference"}
        "auto" takes all cores ("cpu"); "gpu" a graphics card; "reference" integrates exactly, and slowly.
    device_index, threads, memory_limit : int
        Which card; how many cores, 0 is all, and values do not depend on it; bytes, 0 is half of what is free.
    progress : callable
        Called as progress(stage, fraction); returns False to cancel.
    **more
        See options.MoreOptions.

    Returns
    -------
    Result
        Values of each descriptor, (n,) or (n, 3) float32, also of float64 vertices: the library takes positions and
        gives values as 32-bit floats, and float64 would show digits that it has not computed. NaN at vertices without a
        face, at faces without an area, and wherever else a descriptor does not exist.

    Raises
    ------
    InputError
        A ValueError: arrays (empty ones too) or values of options cannot be used.
    TypeError
        No option has the name of a keyword argument; the sentence names the nearest.
    ParadescError
        It cannot be computed here (no such device, too little memory), or was cancelled.

    Warns
    -----
    ParadescWarning
        Something limits the values; Result.warnings has the same sentences.

    Notes
    -----
    Arrays are not changed. May be called from several threads. Ctrl-C ends it at once.

    Examples
    --------
    A ridge, whose principal curvatures along its line are 0.4 and 0.

    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> result = paradesc.compute(vertices, faces, ["mean_curvature", "curvedness"], radius=0.2, radius_unit="absolute")
    >>> result["mean_curvature"].shape
    (441,)
    >>> print(f"{result['mean_curvature'][220]:.2f}")
    0.20
    """
    named = {
        "radius_unit": radius_unit, "samples": samples, "creases": creases, "normals": normals,
        "estimator": estimator, "distance": distance, "map_descriptor": map_descriptor, "backend": backend,
        "device_index": device_index, "threads": threads, "memory_limit": memory_limit, "domain": domain,
    }  # fmt: skip
    options.check_names(compute, more)
    with plain_errors():
        settings = options.settings_of(descriptors, radius, {**named, **more})
        told = cancelling(progress)
        check_normals(settings, corner_normals)
        points, polygons = surface_of(vertices, faces)
        arrays = inputs.mesh_arrays(points, polygons, uvs, corner_normals, sharp_edges)
        results = face_centers.run_where_asked(arrays, settings, told, polygons.sizes)
    return told_of(Result(results))


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

    Parameters
    ----------
    vertices, faces
        As compute() takes them.
    descriptor : str
        "mean_curvature", the one whose standard error is known.
    radii : sequence of float
        Two or more, in radius_unit; None: from the mean edge to 16 % of the diagonal, in steps of about √2.
    at : (j,) array_like of int
        Vertices that the arrays are of; None: all.
    radius_unit, sharp_edges, progress, **more
        As compute() takes them. estimator: "shape-operator" or "extrapolated".

    Returns
    -------
    Profile
        radii (k,), values, standard_error and bias (k, n), best (n,), radius and expected.

    Raises
    ------
    InputError, TypeError, ParadescError
        As of compute(); and where noise is not known: by normals "mesh" and on devices.

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(*2 * [np.linspace(-1, 1, 21)])
    >>> heights = 0.2 * u * u + np.random.default_rng(0).normal(0, 0.003, u.shape)
    >>> i = np.arange(20 * 21).reshape(20, 21)[:, :20].reshape(-1, 1)
    >>> found = paradesc.profile(np.stack([u, v, heights], 2).reshape(-1, 3), i + [0, 1, 22, 21])
    >>> bool(found.standard_error[-1].mean() < found.standard_error[0].mean())
    True
    """
    options.check_names(profile, more, (*options.DEFAULTS, *options.WHOLE, "backend"))
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

    What does not depend on positions is made once. A frame has the very bits that compute() gives for its positions.
    Threads that use one mesh wait for each other.

    Parameters
    ----------
    vertices, faces, uvs, sharp_edges, backend, device_index, threads, memory_limit
        As compute() takes them.

    Raises
    ------
    InputError, ParadescError
        As of compute().

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> with paradesc.Mesh(vertices, faces) as mesh:
    ...     for stretch in (1, 2):
    ...         mesh.positions = vertices * [1, 1, stretch]
    ...         print(f"{mesh.compute(radius=0.2, radius_unit='absolute')['mean_curvature'][220]:.2f}")
    0.20
    0.40
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
        """Computes descriptors at the positions of now.

        A radius in shares of the diagonal follows a mesh that grows; "absolute" is the same in all frames.

        Parameters
        ----------
        descriptors, radius, radius_unit, samples, corner_normals, creases
            As paradesc.compute() takes them.
        normals, estimator, distance, map_descriptor, progress, **more
            As paradesc.compute() takes them.

        Returns
        -------
        Result
            At vertices.

        Raises
        ------
        InputError, TypeError, ParadescError
            As of compute(); and of a mesh that is closed.
        """
        named = {
            "radius_unit": radius_unit, "samples": samples, "creases": creases, "normals": normals,
            "estimator": estimator, "distance": distance, "map_descriptor": map_descriptor,
        }  # fmt: skip
        if "domain" in more:
            raise TypeError("A paradesc.Mesh has values at vertices; paradesc.compute() has them at faces.")
        options.check_names(Mesh.compute, more)
        with plain_errors(), self._lock:
            stream = self._opened()
            settings = options.settings_of(descriptors, radius, {**named, **more, **self._machine})
            told = cancelling(progress)
            check_normals(settings, corner_normals)
            own_normals = inputs.normals_of(corner_normals, len(self._points), self._polygons)
            positions = self._arrays(stream).positions
            stream.settings = job.fitted(settings, self._arrays(stream))
            results = stream.compute(positions, told, own_normals)
        return told_of(Result(results))

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


def told_of(result: Result) -> Result:
    """The same result, after a warning about each thing that limits its values, at the line that calls this package."""
    ours = takewhile(lambda row: row[0].f_globals.get("__package__") == __package__, walk_stack(sys._getframe()))
    level = 1 + len(list(ours))
    for sentence in result.warnings:
        warnings.warn(sentence, ParadescWarning, stacklevel=level)
    return result


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
