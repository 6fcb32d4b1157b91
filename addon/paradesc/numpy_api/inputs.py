"""Turns arrays as users have them into the arrays that the library reads, or says in one sentence what is wrong.

The arrays are never changed. Numbers of any type, order of bytes and layout in memory are taken. Never imports bpy.
"""

from itertools import chain

import numpy as np

from ..bridge import InputError, MeshArrays, origin
from ..core.polygons import Polygons, triangle_corners

FACES_WANTED = "(m, 3) triangles, (m, k) polygons or a list of lists of vertices are needed"
LARGEST_COUNT = 2**31 - 1


def mesh_arrays(
    points: np.ndarray,
    polygons: Polygons,
    uvs: object = None,
    corner_normals: object = None,
    sharp_edges: object = None,
) -> MeshArrays:
    """The mesh of (n, 3) float64 points and of polygons as the library reads it, with the other inputs given."""
    return MeshArrays(
        positions=points,
        corner_vertices=polygons.corner_vertices,
        triangle_corners=triangle_corners(polygons, points),
        corner_uvs=None if uvs is None else at_corners(uvs, "uvs", 2, len(points), polygons),
        corner_normals=normals_of(corner_normals, len(points), polygons),
        sharp_edges=None if sharp_edges is None else edges_of(sharp_edges, len(points)),
    )


def normals_of(corner_normals: object, vertex_count: int, polygons: Polygons) -> np.ndarray | None:
    """(corner_count, 3) float32 normals, if they were given."""
    return None if corner_normals is None else at_corners(corner_normals, "corner_normals", 3, vertex_count, polygons)


def points_of(vertices: object) -> np.ndarray:
    """(n, 3) float64 finite positions."""
    array = numbers(vertices, "vertices", "(n, 3) numbers are needed")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"vertices has the shape {array.shape}, but (n, 3) is needed.")
    if len(array) == 0:
        raise InputError("vertices is empty; give at least one triangle.")
    if len(array) > LARGEST_COUNT:
        raise InputError(f"vertices has {len(array)} rows, which is more than {LARGEST_COUNT}.")
    points = array.astype(np.float64)
    origin.check_finite(points)
    return points


def polygons_of(faces: object, vertex_count: int) -> Polygons:
    """The polygons of an (m, k) array, a list of lists, or Polygons; raises if a corner names no vertex."""
    if isinstance(faces, Polygons):
        corners, sizes = faces.corner_vertices, faces.sizes
    else:
        corners, sizes = rows_of(faces)
    if len(sizes) == 0:
        raise InputError("faces is empty; give at least one triangle.")
    if len(corners) > LARGEST_COUNT:
        raise InputError(f"faces has {len(corners)} corners, which is more than {LARGEST_COUNT}.")
    if sizes.min() < 3:
        face = int(sizes.argmin())
        raise InputError(f"Face {face} has {counted(int(sizes[face]), 'corner')}; at least three are needed.")
    sizes = sizes.astype(np.int64)

    def face_of(corner: int) -> str:
        return f"Face {int(np.searchsorted(np.cumsum(sizes), corner, side='right'))}"

    return Polygons(indices(corners, vertex_count, face_of), sizes)


def rows_of(faces: object) -> tuple[np.ndarray, np.ndarray]:
    """The corners of all faces one after the other, and how many each has."""
    if isinstance(faces, (list, tuple)):
        try:
            lengths = list(map(len, faces))
            flat = list(chain.from_iterable(faces)) if len(set(lengths)) > 1 else []
        except TypeError:
            flat = []  # some may not be lists, which is reported below
        if flat:
            return whole(flat, "faces", FACES_WANTED, 1), np.array(lengths)
    array = whole(faces, "faces", FACES_WANTED, 2)
    return array.reshape(-1), np.full(len(array), array.shape[1])


def vertices_of(given: object, vertex_count: int) -> np.ndarray:
    """(n,) vertices asked for, counted from 0."""
    array = np.atleast_1d(whole(given, "at", "vertices counted from 0 are needed", 1))
    return indices(array, vertex_count, lambda place: f"Entry {place} of at")


def edges_of(edges: object, vertex_count: int) -> np.ndarray | None:
    """(k, 2) int32 pairs of vertices; None if there are no edges."""
    wanted = "(k, 2) pairs of vertices are needed"
    array = numbers(edges, "sharp_edges", wanted)
    if array.size == 0:
        return None
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(f"sharp_edges has the shape {array.shape}, but {wanted}.")
    array = whole(array, "sharp_edges", wanted, 2)
    return indices(array.reshape(-1), vertex_count, lambda at: f"Sharp edge {at // 2}").reshape(-1, 2)


def indices(array: np.ndarray, vertex_count: int, owner: object) -> np.ndarray:
    """(c,) int32 vertex numbers. owner(index): the part of the input with a wrong number, for the error."""
    wrong = (array < 0) | (array >= vertex_count)
    if wrong.any():
        at = int(wrong.argmax())
        there = f"there {'is' if vertex_count == 1 else 'are'} {counted(vertex_count, 'vertex')}"
        raise InputError(f"{owner(at)} names vertex {array[at]:.20g}, but {there}, counted from 0.")
    return np.ascontiguousarray(array, np.int32)


def at_corners(values: object, name: str, width: int, vertex_count: int, polygons: Polygons) -> np.ndarray:
    """(corner_count, width) float32 of values at vertices (n, width), at corners (c, width) or in faces (m, k, width).

    Rows that fit both vertices and corners belong to vertices.
    """
    array = numbers(values, name, f"numbers for {width} coordinates are needed")
    corners, sizes = polygons.corner_vertices, polygons.sizes
    if array.shape == (len(sizes), sizes[0], width) and (sizes == sizes[0]).all():
        array = array.reshape(-1, width)
    elif array.shape == (vertex_count, width):
        array = array[corners]
    elif array.shape != (len(corners), width):
        wanted = f"({vertex_count}, {width}) for vertices or ({len(corners)}, {width}) for corners"
        raise InputError(f"{name} has the shape {array.shape}, but {wanted} is needed.")
    with np.errstate(invalid="ignore"):
        fits = np.abs(array) <= origin.LARGEST
    if not fits.all():
        corner = int((~fits.all(axis=1)).argmax())
        raise InputError(f"{name} is not a finite 32-bit float at corner {corner}, which is vertex {corners[corner]}.")
    return np.ascontiguousarray(array, np.float32)


def whole(values: object, name: str, wanted: str, dimensions: int) -> np.ndarray:
    """Whole numbers in an array of this many dimensions; floats without a fraction count as well."""
    array = numbers(values, name, wanted)
    if array.ndim != dimensions:
        raise InputError(f"{name} has the shape {array.shape}, but {wanted}.")
    if array.dtype.kind == "f":
        fraction = ~np.isfinite(array) | (array != np.rint(array))
        if fraction.any():
            row = int(np.argwhere(fraction)[0][0])
            where = f" in row {row}" if dimensions == 2 else ""
            raise InputError(f"{name} has the value {array[fraction][0]:g}{where}; vertices are whole numbers.")
    return array


def numbers(values: object, name: str, wanted: str) -> np.ndarray:
    """An array of integers or floats; refuses text, Python objects, truth values and masked values."""
    try:
        array = np.asarray(values)
    except (ValueError, TypeError, OverflowError, AttributeError, RuntimeError, RecursionError) as error:
        raise InputError(f"{name} cannot be read as an array; {wanted}.") from error
    if array.size == 0 and array.dtype.kind != "O":
        return array.astype(np.float64) if array.dtype.kind not in "iuf" else array
    if array.dtype.kind not in "iuf":
        raise InputError(f"{name} holds {KINDS.get(array.dtype.kind, str(array.dtype))}; {wanted}.")
    if np.ma.is_masked(values):
        raise InputError(f"{name} has masked values; leave out the vertices and faces that have none.")
    return array


# Words for arrays whose type is not a real number, by the kind of numpy's dtype.
KINDS = {
    "b": "truth values",
    "c": "complex numbers",
    "O": "Python objects or rows of different lengths",
    "S": "bytes",
    "U": "text",
    "M": "dates",
    "m": "times",
    "V": "records",
}


def counted(count: int, noun: str) -> str:
    """A number with its noun: "1 corner", "4 vertices"."""
    plural = {"vertex": "vertices"}.get(noun, noun + "s")
    return f"{count} {noun if count == 1 else plural}"
