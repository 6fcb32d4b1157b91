"""Reads surfaces of GIFTI and FreeSurfer, and writes values for either (.gii, .curv), by nibabel. Never imports bpy.

nibabel is not part of Blender: it is imported where it is used, and a sentence says how to install it.
"""

import importlib.util
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..bridge import origin
from ..core.polygons import PolygonMesh, vertices_at
from .results import Baked

# FreeSurfer names surfaces and values by suffixes for their kind, as in lh.white and lh.curv.
SURFACES = (".white", ".pial", ".smoothwm", ".inflated", ".orig", ".sphere")
SUFFIXES = (".gii", ".curv")  # of values that are written
INSTALL = "pip install paradesc[neuro]"
LONGEST = 200  # of a sentence of nibabel's


def fault() -> str:
    """The reason why these formats can be neither read nor written here, or ""."""
    found = importlib.util.find_spec("nibabel")
    return "" if found else f"it needs nibabel, which is not installed; {INSTALL}"


def surface_of(load: Callable[[Path], tuple[object, object]]) -> Callable[[Path], PolygonMesh | None]:
    """A reader of surfaces, from one that gives points and triangles; it raises ValueError whatever is wrong."""

    def read(path: Path) -> PolygonMesh | None:
        if fault():
            raise ValueError(fault())
        try:
            points, triangles = load(path)
        except (MemoryError, OSError):
            raise
        except Exception as error:  # nibabel says what is wrong with a file by errors of any type
            raise ValueError(f"nibabel finds it damaged ({str(error)[:LONGEST] or type(error).__name__})") from error
        if np.ndim(points) != 2 or np.shape(points)[1] != 3 or np.ndim(triangles) != 2 or np.shape(triangles)[1] != 3:
            raise ValueError("it holds no triangles of points, but values perhaps; give the surface of those")
        corners = vertices_at(triangles.reshape(-1), len(points)).astype(np.int32)
        return PolygonMesh(origin.stored(points.astype(np.float64)), corners, np.full(len(triangles), 3, np.int64))

    return read


@surface_of
def read_gifti(path: Path) -> tuple[object, object]:
    """The first points and triangles of a GIFTI file, as they are stored: no transform is applied to them."""
    import nibabel

    image = nibabel.GiftiImage.from_bytes(path.read_bytes())
    found = [image.get_arrays_from_intent(f"NIFTI_INTENT_{kind}") for kind in ("POINTSET", "TRIANGLE")]
    points, triangles = (arrays[0].data if arrays else None for arrays in found)
    return points, triangles


@surface_of
def read_freesurfer(path: Path) -> tuple[object, object]:
    """The points and triangles of a surface of FreeSurfer, in its coordinates of the surface."""
    from nibabel import freesurfer

    with path.open("rb") as file:
        if file.read(3) == b"\xff\xff\xff" and path.stat().st_size % 4 == 3:  # so begin values, and ancient quads
            return None, None
    return freesurfer.read_geometry(path)


def write_gifti(path: Path, baked: Baked) -> None:
    """Writes an array of the intent SHAPE for each descriptor, the coverage and the mask; directions by components."""
    import nibabel

    arrays = [
        nibabel.gifti.GiftiDataArray(
            np.ascontiguousarray(values, np.float32), "NIFTI_INTENT_SHAPE", "NIFTI_TYPE_FLOAT32", meta={"Name": name}
        )
        for name, values in baked.columns.items()
    ]
    path.write_bytes(nibabel.GiftiImage(darrays=arrays).to_bytes())


def write_curv(path: Path, baked: Baked) -> None:
    """Writes FreeSurfer's values of a surface, of which a file has one at each vertex."""
    from nibabel import freesurfer

    (values,) = baked.results.values.values()
    with path.open("wb") as file:
        freesurfer.write_morph_data(file, values, len(baked.arrays.triangle_corners))
