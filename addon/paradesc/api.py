"""The Python package: descriptors of meshes that are numpy arrays, or meshes of trimesh, PyVista or Open3D.

    import paradesc
    result = paradesc.compute(vertices, faces, ["mean_curvature", "curvedness"], radius=0.08, radius_unit="absolute")
    result["mean_curvature"]  # (n,) float32

The method is that of Andreadis, Papaioannou and Mavridis, "GPU Accelerated Computation of Geometric
Descriptors in Parametric Space"; descriptors() lists what there is, each with its equation. Imports no part of Blender.
"""

import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import takewhile
from traceback import walk_stack
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .bridge import Descriptor, InputError, MeshArrays, ParadescError, abi, descriptors, uses_texture_space
from .numpy_api import words
from .numpy_api.result import Mask, ParadescWarning, Result

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .core.balance import Profile
    from .core.stream import Stream

__all__ = [
    "Descriptor", "InputError", "Mask", "Mesh", "ParadescError", "ParadescWarning", "Result",
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
    radius_unit: words.RadiusUnit = "diagonal",
    samples: int = 256,
    uvs: "ArrayLike | None" = None,
    corner_normals: "ArrayLike | None" = None,
    sharp_edges: "ArrayLike | None" = None,
    creases: words.Creases = "auto",
    normals: words.Normals = "fitted",
    estimator: words.Estimator = "shape-operator",
    distance: words.Distance = "euclidean",
    domain: words.Domain = "vertices",
    map_descriptor: str = "sphere_volume_normalized",
    backend: words.Backend = "auto",
    device_index: int = -1,
    threads: int = 0,
    memory_limit: int = 0,
    progress: Progress | None = None,
    **more: "Unpack[words.MoreOptions]",
) -> Result:
    """Computes descriptors at every vertex or face of a mesh, in their order.

    Parameters
    ----------
    vertices : (n, 3) array_like, or a mesh of trimesh, PyVista or Open3D
        The positions, as real numbers of any type; a mesh of another package brings its faces along. A mesh that lies
        farther from the origin than its size is first moved there, so that 32-bit floats keep its shape.
    faces : (m, 3) or (m, k) array_like, or a sequence of sequences
        Triangles or polygons (concave ones too) of vertices from 0, counterclockwise as seen from outside.
    descriptors : str or sequence of str
        One name or several; paradesc.descriptors() lists them.
    radius : float, sequence of float, or "auto"
        The size of the neighborhood that is measured. With several, result["mean_curvature", 0.01] has the values at
        one, and "mean_curvature_r0.01" is their name. "auto" takes the radius that profile() finds, and the estimator
        "shape-operator" or "extrapolated", whichever errs less, unless another is given.
    radius_unit : {"diagonal", "absolute", "mean-edge"}
        The unit of radius: the diagonal of the bounding box, the unit of the vertices, or the mean edge length.
    samples : int
        The least number of samples in each neighborhood.
    uvs : (n, 2), (corners, 2) or (m, k, 2) array_like
        Texture coordinates at vertices or at corners of faces. Only the backends "gpu" and "software" need them.
    corner_normals : (n, 3), (corners, 3) or (m, k, 3) array_like
        Normals at vertices or at corners of faces, for normals="mesh".
    sharp_edges : (k, 2) array_like
        The edges that are hard creases, each by its two vertices.
    creases : {"auto", "marked", "none"}
        "auto" also detects edges by their angles, "marked" uses sharp_edges only, and "none" ignores creases.
    normals : {"fitted", "max", "mesh"}
        The normals that curvature is measured with: fitted to the surface, averaged by Max (1999), or corner_normals.
    estimator : {"shape-operator", "extrapolated", "integral"}
        Curvature by the fitted shape operator, by its extrapolation to radius 0, or by the paper's integrals.
    distance : {"euclidean", "geodesic"}
        The radius is measured through space, or along the surface.
    domain : {"vertices", "faces"}
        The places that are measured: every vertex, or the middle of every face.
    map_descriptor : str
        The descriptor that gradient_magnitude, laplacian, difference_of_gaussians and harris are applied to.
    backend : {"auto", "cpu", "gpu", "software", "reference"}
        All cores ("auto" and "cpu"), a graphics card, OpenGL without a card, or exact and slow integration.
    device_index, threads, memory_limit : int
        The number of the graphics card; the number of threads (0: all cores); the most bytes (0: half of those free).
    progress : callable
        A function that is called as progress(stage, fraction), and returns False to cancel.
    **more
        The other settings of the manual's reference: variance_reduction, geodesic, map_sigma, harris_k, buffer_size,
        corner_threshold, relocation, max_jumps, seed, pattern, ellipse, evaluate, texels, precision and adaptive.

    Returns
    -------
    Result
        Arrays (n,) or (n, 3) of float32, also for float64 vertices: the library takes positions and gives values as
        32-bit floats, and float64 would show digits that it has not computed. NaN is at vertices without a face, at
        faces without an area, and wherever else a descriptor does not exist.

    Raises
    ------
    InputError
        An array or the value of an option cannot be used; empty arrays cannot. It is a ValueError.
    TypeError
        No option has the name of a keyword argument; the sentence names the nearest.
    ParadescError
        The computation is not possible here (no such device, too little memory), or was cancelled.

    Warns
    -----
    ParadescWarning
        Something limits the values; Result.warnings has the same sentences.

    Notes
    -----
    The arrays are not changed. Several threads may call this at once. Ctrl-C ends it at once.

    Examples
    --------
    A ridge, whose principal curvatures along its line are 0.4 and 0.

    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> result = paradesc.compute(vertices, faces, radius=0.2, radius_unit="absolute")
    >>> result["mean_curvature"].shape
    (441,)
    >>> print(f"{result['mean_curvature'][220]:.2f}")
    0.20
    """
    from .numpy_api import work

    named = {
        "radius_unit": radius_unit, "samples": samples, "creases": creases, "normals": normals,
        "estimator": estimator, "distance": distance, "map_descriptor": map_descriptor, "backend": backend,
        "device_index": device_index, "threads": threads, "memory_limit": memory_limit, "domain": domain,
    }  # fmt: skip
    work.options.check_names(compute, more)
    with work.plain_errors():
        settings = work.options.settings_of(descriptors, radius, {**named, **more})
        told = work.cancelling(progress)
        work.check_normals(settings, corner_normals)
        points, polygons = work.surface_of(vertices, faces)
        arrays = work.inputs.mesh_arrays(points, polygons, uvs, corner_normals, sharp_edges)
        if settings.domain == "faces":
            results = work.face_centers.run(arrays, settings, told, polygons.sizes)
        else:
            results = work.job.run(arrays, settings, told)
    return told_of(Result(results))


def profile(
    vertices: "ArrayLike | Any",
    faces: "ArrayLike | Sequence[Sequence[int]] | None" = None,
    descriptor: str = "mean_curvature",
    radii: Sequence[float] | None = None,
    at: "ArrayLike | None" = None,
    *,
    radius_unit: words.RadiusUnit = "diagonal",
    sharp_edges: "ArrayLike | None" = None,
    progress: Progress | None = None,
    **more: Any,
) -> "Profile":
    """Measures the mean curvature at several radii, its errors by noise and by blur, and the radius of the least error.

    Parameters
    ----------
    vertices, faces
        The mesh, as compute() takes it.
    descriptor : str
        Only "mean_curvature", the one descriptor whose standard error is known.
    radii : sequence of float
        Two radii or more; by default from the mean edge to 16 % of the diagonal, in steps of about √2.
    at : (j,) array_like of int
        The vertices that the arrays describe; by default all.
    radius_unit, sharp_edges, progress, **more
        The same as in compute(). The estimator is "shape-operator" or "extrapolated".

    Returns
    -------
    Profile
        The radii (k,), with values, standard_error and bias (k, n), best (n,), radius and expected.

    Raises
    ------
    InputError, TypeError, ParadescError
        As compute() does; also for normals="mesh" and graphics cards, where noise is not known.

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
    from .numpy_api import work

    work.options.check_names(profile, more, (*work.options.DEFAULTS, *work.options.WHOLE, "backend"))
    with work.plain_errors():
        if descriptor != work.balance.MEAN:
            raise InputError(f"descriptor is {work.options.shown(descriptor)}; only mean_curvature has a standard error.")
        settings = work.options.settings_of(descriptor, 0.02, {**more, "radius_unit": radius_unit})
        if settings.options.normals != "fitted" or uses_texture_space(work.job.backend_for(settings)):
            raise InputError(work.balance.UNKNOWN)
        points, polygons = work.surface_of(vertices, faces)
        arrays = work.inputs.mesh_arrays(points, polygons, None, None, sharp_edges)
        rising = None if radii is None else work.options.rising(radii)
        told = work.cancelling(progress)
        found = work.balance.profile(settings, arrays, rising, lambda asked: work.job.run(arrays, asked, told))
        return found if at is None else found.at(work.inputs.vertices_of(at, len(points)))


class Mesh:
    """A mesh that is kept for several computations: for other descriptors and radii, or for frames of an animation.

    Everything that does not depend on positions is prepared once. Each frame has the same bits as compute() gives.
    Threads that use one mesh wait for each other.

    Parameters
    ----------
    vertices, faces, uvs, sharp_edges, backend, device_index, threads, memory_limit
        The same as in compute().

    Raises
    ------
    InputError, ParadescError
        As compute() does.

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
        backend: words.Backend = "auto",
        device_index: int = -1,
        threads: int = 0,
        memory_limit: int = 0,
    ) -> None:
        from .numpy_api import work

        self._machine = {
            "backend": backend, "device_index": device_index, "threads": threads, "memory_limit": memory_limit,
        }  # fmt: skip
        with work.plain_errors():
            settings = work.options.settings_of("mean_curvature", 0.02, self._machine)
            self._points, self._polygons = work.surface_of(vertices, faces)
            arrays = work.inputs.mesh_arrays(self._points, self._polygons, uvs, None, sharp_edges)
            self._near = work.origin.near_origin(self._points)  # the points as the library reads them
            self._stream: Stream | None = work.Stream(arrays, settings)
        self._lock = threading.RLock()
        self._finalizer = weakref.finalize(self, self._stream.leave)
        self._finalizer.atexit = False  # a thread may still use it then

    @property
    def positions(self) -> NDArray[np.float64]:
        """The positions, (n, 3) float64. The array is read-only; assign a new (n, 3) array for the next frame."""
        shown = self._points.view()
        shown.flags.writeable = False
        return shown

    @positions.setter
    def positions(self, vertices: "ArrayLike") -> None:
        from .numpy_api import work

        with work.plain_errors(), self._lock:
            points = work.inputs.points_of(vertices)
            if points.shape != self._points.shape:
                raise InputError(f"positions has the shape {points.shape}, but the mesh has {self._points.shape}.")
            self._points, self._near = points, work.origin.near_origin(points)

    @property
    def report(self) -> dict[str, float | int]:
        """A dict of what was found in the mesh at its positions: counts of parts and defects, diagonal, mean edge."""
        from .numpy_api import work

        with work.plain_errors(), self._lock:
            stream = self._opened()
            return stream.mesh_at(self._arrays(stream)).report()

    def compute(
        self,
        descriptors: str | Sequence[str] = ("mean_curvature",),
        radius: float | Sequence[float] | Literal["auto"] = 0.02,
        *,
        radius_unit: words.RadiusUnit = "diagonal",
        samples: int = 256,
        corner_normals: "ArrayLike | None" = None,
        creases: words.Creases = "auto",
        normals: words.Normals = "fitted",
        estimator: words.Estimator = "shape-operator",
        distance: words.Distance = "euclidean",
        map_descriptor: str = "sphere_volume_normalized",
        progress: Progress | None = None,
        **more: "Unpack[words.MoreOptions]",
    ) -> Result:
        """Computes descriptors at the current positions.

        A radius as a share of the diagonal grows with the mesh; radius_unit="absolute" keeps it the same in all frames.

        Parameters
        ----------
        descriptors, radius, radius_unit, samples, corner_normals, creases
            The same as in paradesc.compute().
        normals, estimator, distance, map_descriptor, progress, **more
            The same as in paradesc.compute().

        Returns
        -------
        Result
            The values at vertices.

        Raises
        ------
        InputError, TypeError, ParadescError
            As paradesc.compute() does. A mesh that was closed is a ParadescError.
        """
        from .numpy_api import work

        named = {
            "radius_unit": radius_unit, "samples": samples, "creases": creases, "normals": normals,
            "estimator": estimator, "distance": distance, "map_descriptor": map_descriptor,
        }  # fmt: skip
        if "domain" in more:
            raise TypeError("A paradesc.Mesh has values at vertices; paradesc.compute() has them at faces.")
        work.options.check_names(Mesh.compute, more)
        with work.plain_errors(), self._lock:
            stream = self._opened()
            settings = work.options.settings_of(descriptors, radius, {**named, **more, **self._machine})
            told = work.cancelling(progress)
            work.check_normals(settings, corner_normals)
            own_normals = work.inputs.normals_of(corner_normals, len(self._points), self._polygons)
            positions = self._arrays(stream).positions
            stream.settings = work.job.fitted(settings, self._arrays(stream))
            results = stream.compute(positions, told, own_normals)
        return told_of(Result(results))

    def close(self) -> None:
        """Frees the memory and the device. Results stay valid."""
        with self._lock:
            self._finalizer.detach()
            if self._stream is not None:
                self._stream.close()
            self._stream = None

    def __reduce__(self) -> str:
        raise TypeError("A paradesc.Mesh cannot be copied or go to another process; make one there of the same arrays.")

    def __enter__(self) -> "Mesh":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _opened(self) -> "Stream":
        if self._stream is None:
            raise ParadescError(abi.STATUS_INVALID_OPERATION, "The mesh is closed.")
        return self._stream

    def _arrays(self, stream: "Stream") -> MeshArrays:
        """The mesh at its positions; polygons that have bent may be cut into other triangles."""
        from .numpy_api import work

        triangles = stream.arrays.triangle_corners
        if len(triangles) != len(self._polygons.sizes):
            triangles = work.triangle_corners(self._polygons, self._points)
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
