"""Times other programs' curvature of the same mesh, and takes their H if they have one. Each is optional.

Conventions of sign differ, so the sign that agrees better with the truth is taken. Only the call that computes counts,
and neither the import nor making the mesh.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import programs

from paradesc.bridge import MeshArrays

INSTALL = "pip install libigl pymeshlab trimesh scipy rtree vtk"
SAMPLED = 1000  # vertices that the slowest are timed at


@dataclass
class Task:
    """The input of a peer, and the folder of native peers."""

    arrays: MeshArrays
    radius: float  # in units of the positions
    build: Path
    folder: Path  # for files


@dataclass
class Found:
    """How long a peer took for all vertices, and its H at some."""

    seconds: float
    values: np.ndarray | None  # (n,) H
    vertices: np.ndarray | None = None  # (n,) where not at all
    note: str = ""


def timed(action: Callable[[], object]) -> tuple[float, object]:
    """Seconds by the clock, and the result."""
    start = time.perf_counter()
    result = action()
    return time.perf_counter() - start, result


def points_and_faces(arrays: MeshArrays) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) float64 and (t, 3) int32"""
    return arrays.positions.astype(np.float64), np.ascontiguousarray(arrays.triangle_vertices, np.int32)


def libigl(arrays: MeshArrays, rings: int) -> Found:
    """Runs libigl, which fits quadrics to rings of the mesh."""
    import igl

    points, faces = points_and_faces(arrays)
    seconds, found = timed(lambda: igl.principal_curvature(points, faces, rings, True))
    return Found(seconds, (np.asarray(found[2]) + np.asarray(found[3])).ravel() / 2)


def pymeshlab_directions(arrays: MeshArrays, method: str, radius: float | None) -> Found:
    """Runs one of its fits within a ball; without a radius at its own scale, a tenth of the diagonal."""
    import pymeshlab

    meshes = pymeshlab_set(arrays)
    scale = {} if radius is None else {"scale": pymeshlab.PureValue(radius)}
    wanted = {"method": method, "curvcolormethod": "Mean Curvature", "autoclean": False, **scale}
    seconds, _ = timed(lambda: meshes.compute_curvature_principal_directions_per_vertex(**wanted))
    return Found(seconds, pymeshlab_values(meshes, arrays))


def pymeshlab_discrete(arrays: MeshArrays) -> Found:
    """Runs its cotangents over one ring."""
    meshes = pymeshlab_set(arrays)
    seconds, _ = timed(lambda: meshes.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype="Mean Curvature"))
    return Found(seconds, pymeshlab_values(meshes, arrays))


def pymeshlab_set(arrays: MeshArrays) -> object:
    import pymeshlab

    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(*points_and_faces(arrays)))
    return meshes


def pymeshlab_values(meshes: object, arrays: MeshArrays) -> np.ndarray | None:
    """(n,) H, unless it has removed vertices."""
    values = meshes.current_mesh().vertex_scalar_array()
    return values if len(values) == len(arrays.positions) else None


def trimesh_measure(arrays: MeshArrays, radius: float) -> Found:
    """Takes the curvature of the edges in a ball over the area of a disk, at some vertices only: it is slow."""
    import trimesh

    points, faces = points_and_faces(arrays)
    mesh = trimesh.Trimesh(points, faces, process=False)
    _ = mesh.face_adjacency_angles, mesh.face_adjacency_convex  # not counted
    chosen = np.random.default_rng(1).permutation(len(points))[:SAMPLED]
    seconds, found = timed(lambda: trimesh.curvature.discrete_mean_curvature_measure(mesh, points[chosen], radius))
    note = f"extrapolated from {len(chosen)} vertices"
    return Found(seconds * len(points) / len(chosen), found / (math.pi * radius**2), chosen, note)


def vtk_mean(arrays: MeshArrays) -> Found:
    """Runs its angles of edges over one ring."""
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

    points, faces = points_and_faces(arrays)
    places, cells, mesh = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    places.SetData(numpy_to_vtk(points, deep=True))
    offsets = numpy_to_vtkIdTypeArray(np.arange(0, faces.size + 1, 3), deep=True)
    cells.SetData(offsets, numpy_to_vtkIdTypeArray(faces.astype(np.int64).ravel(), deep=True))
    mesh.SetPoints(places)
    mesh.SetPolys(cells)
    curvatures = vtk.vtkCurvatures()
    curvatures.SetInputData(mesh)
    curvatures.SetCurvatureTypeToMean()
    seconds, _ = timed(curvatures.Update)
    return Found(seconds, vtk_to_numpy(curvatures.GetOutput().GetPointData().GetScalars()).astype(np.float64))


def pymeshlab_apss(arrays: MeshArrays, scale: float) -> Found:
    """Runs its fit of algebraic spheres, which gives twice H; the scale is relative to the distance of vertices."""
    meshes = pymeshlab_set(arrays)
    seconds, _ = timed(lambda: meshes.compute_curvature_and_color_apss_per_vertex(filterscale=scale))
    values = pymeshlab_values(meshes, arrays)
    return Found(seconds, None if values is None else values / 2)


def cgal(task: Task) -> Found:
    """Runs CGAL's interpolated corrected curvatures in the same ball."""
    path = programs.write_mesh(task.folder / "cgal", task.arrays)
    seconds, found = programs.cgal(task.build, path, task.radius)
    return Found(seconds, found.values, found.vertices)


@dataclass
class Peer:
    """One row of the table."""

    label: str
    package: str
    function: Callable[[Task], Found]
    same_radius: bool = False


QUADRIC, PCA = "Scale Dependent Quadric Fitting", "Principal Component Analysis"
PEERS: dict[str, Peer] = {
    "libigl2": Peer("libigl, 2 rings", "libigl", lambda task: libigl(task.arrays, 2)),
    "libigl5": Peer("libigl, 5 rings", "libigl", lambda task: libigl(task.arrays, 5)),
    "pymeshlab_discrete": Peer("PyMeshLab, discrete", "pymeshlab", lambda task: pymeshlab_discrete(task.arrays)),
    "pymeshlab_quadric": Peer(
        "PyMeshLab, scale-dependent quadric, the same radius",
        "pymeshlab",
        lambda task: pymeshlab_directions(task.arrays, QUADRIC, task.radius),
        same_radius=True,
    ),
    "pymeshlab_pca": Peer(
        "PyMeshLab, PCA, its own radius", "pymeshlab", lambda task: pymeshlab_directions(task.arrays, PCA, None)
    ),
    "pymeshlab_pca_same_radius": Peer(
        "PyMeshLab, PCA, the same radius",
        "pymeshlab",
        lambda task: pymeshlab_directions(task.arrays, PCA, task.radius),
        same_radius=True,
    ),
    "pymeshlab_apss4": Peer("MeshLab's APSS, scale 4", "pymeshlab", lambda task: pymeshlab_apss(task.arrays, 4)),
    "pymeshlab_apss8": Peer("MeshLab's APSS, scale 8", "pymeshlab", lambda task: pymeshlab_apss(task.arrays, 8)),
    "cgal": Peer("CGAL 6, corrected curvatures, the same radius, one core", "CGAL 6", cgal, same_radius=True),
    "trimesh": Peer(
        "trimesh, ball measure, the same radius",
        "trimesh",
        lambda task: trimesh_measure(task.arrays, task.radius),
        same_radius=True,
    ),
    "vtk": Peer("VTK, mean curvature", "vtk", lambda task: vtk_mean(task.arrays)),
}


def with_sign(values: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """(n,) values or their negatives, whichever agree better with the (n,) truth."""
    both = np.isfinite(values) & np.isfinite(truth)
    product = np.dot(values[both] - values[both].mean(), truth[both] - truth[both].mean()) if both.any() else 1.0
    return -values if product < 0 else values
