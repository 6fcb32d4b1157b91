"""The functions behind api.py and its results. The first call imports them, so that `import paradesc` is quick."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from ..bridge import InputError, ParadescError, ProgressFunction, abi, descriptors, origin
from ..core import balance, face_centers, job, legend
from ..core.distributions import statistics
from ..core.polygons import Polygons, triangle_corners
from ..core.stream import Stream
from . import inputs, options, other_meshes


def surface_of(vertices: object, faces: object) -> tuple[NDArray[np.float64], Polygons]:
    """(n, 3) float64 points and the polygons of what was given: two arrays, or a mesh of another package."""
    kind = type(vertices).__name__
    first = faces[0] if isinstance(faces, (list, tuple)) and faces else faces
    if isinstance(first, str) and any(row.name == first for row in descriptors()):
        raise InputError(f"faces is {options.shown(faces)}; give it as descriptors= if a mesh is in place of two arrays.")
    if faces is None:
        vertices, faces = other_meshes.vertices_and_faces(vertices)
    if faces is None:
        raise InputError(f"faces is missing; give two arrays, or one mesh of trimesh, PyVista or Open3D, not a {kind}.")
    points = inputs.points_of(vertices)
    return points, inputs.polygons_of(faces, len(points))


def check_normals(settings: job.Settings, corner_normals: object) -> None:
    """Refuses to measure by the mesh's own normals where there are none."""
    if settings.options.normals == "mesh" and corner_normals is None:
        raise InputError('corner_normals is missing; give them, or choose normals "fitted" or "max".')


def cancelling(progress: Callable[[str, float], object] | None) -> ProgressFunction | None:
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
