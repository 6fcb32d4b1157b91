"""One job as users of each Python package write it: mean and Gaussian curvature at every vertex of a triangle mesh.

A job takes (n, 3) float64 vertices, (m, 3) int64 faces and a radius in the vertices' unit, and gives two (n,) arrays;
None where the package has no such curvature. The body of its function is run and timed, and its lines are counted.
"""

import inspect
import io
import textwrap
import tokenize
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

Found = tuple[np.ndarray, np.ndarray | None]
NOT_CODE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}


def paradesc(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """Paradesc, with its defaults."""
    import paradesc

    names = ["mean_curvature", "gaussian_curvature"]
    result = paradesc.compute(vertices, faces, names, radius, radius_unit="absolute")
    return result["mean_curvature"], result["gaussian_curvature"]


def paradesc_auto(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """Paradesc, at the radius and by the estimator that it chooses itself."""
    import paradesc

    result = paradesc.compute(vertices, faces, ["mean_curvature", "gaussian_curvature"], "auto")
    return result["mean_curvature"], result["gaussian_curvature"]


def libigl_rings(vertices: np.ndarray, faces: np.ndarray, radius: float, rings: int) -> Found:
    """libigl's quadrics, fitted to rings of the mesh."""
    import igl

    _, _, high, low, _ = igl.principal_curvature(vertices, faces, rings)
    return (high + low) / 2, high * low


def libigl_ball(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """libigl's quadrics in a ball, whose radius is a whole number of mean edges, at least 2."""
    import igl

    edges = max(2, round(radius / igl.avg_edge_length(vertices, faces)))
    _, _, high, low, _ = igl.principal_curvature(vertices, faces, edges, False)
    return (high + low) / 2, high * low


def pymeshlab_quadric(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """MeshLab's quadrics in a ball; a pass gives one kind of curvature."""
    import pymeshlab

    meshes, ball, found = pymeshlab.MeshSet(), pymeshlab.PureValue(radius), []
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    for kind in ("Mean Curvature", "Gaussian Curvature"):
        meshes.compute_curvature_principal_directions_per_vertex(
            method="Scale Dependent Quadric Fitting", curvcolormethod=kind, scale=ball, autoclean=False
        )
        found.append(meshes.current_mesh().vertex_scalar_array())
    return found[0], found[1]


def pymeshlab_apss(vertices: np.ndarray, faces: np.ndarray, radius: float, scale: float) -> Found:
    """MeshLab's algebraic spheres, whose scale is relative to the distance of vertices; "Mean" is twice H."""
    import pymeshlab

    meshes, found = pymeshlab.MeshSet(), []
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    for kind in ("Mean", "Gauss"):
        meshes.compute_curvature_and_color_apss_per_vertex(filterscale=scale, curvaturetype=kind)
        found.append(meshes.current_mesh().vertex_scalar_array())
    return found[0] / 2, found[1]


def pymeshlab_discrete(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """MeshLab's cotangents and angle defects."""
    import pymeshlab

    meshes, found = pymeshlab.MeshSet(), []
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    for kind in ("Mean Curvature", "Gaussian Curvature"):
        meshes.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype=kind)
        found.append(meshes.current_mesh().vertex_scalar_array())
    return found[0], found[1]


def trimesh_ball(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """The curvature that trimesh measures in a ball, over the area of a disk."""
    import trimesh

    mesh, area = trimesh.Trimesh(vertices, faces, process=False), np.pi * radius**2
    mean = trimesh.curvature.discrete_mean_curvature_measure(mesh, vertices, radius) / area
    return mean, trimesh.curvature.discrete_gaussian_curvature_measure(mesh, vertices, radius) / area


def pyvista_discrete(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """VTK's angles of edges and angle defects, by PyVista."""
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    return mesh.curvature("mean"), mesh.curvature("gaussian")


def potpourri3d_cotangents(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """The length of the cotangent Laplacian of the positions; the sign is by the faces around a vertex."""
    import potpourri3d

    around = potpourri3d.cotan_laplacian(vertices, faces) @ vertices
    mean = np.linalg.norm(around, axis=1) / (2 * potpourri3d.vertex_areas(vertices, faces))
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], np.cross(b - a, c - a))
    return np.copysign(mean, (around * normals).sum(axis=1)), None


def meshlib_discrete(vertices: np.ndarray, faces: np.ndarray, radius: float) -> Found:
    """MeshLib's angles of edges, and its angle defects over a third of the area around a vertex."""
    from meshlib import mrmeshnumpy

    mesh = mrmeshnumpy.meshFromFacesVerts(faces, vertices)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    thirds = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    areas = np.bincount(faces.ravel(), np.repeat(thirds, 3), len(vertices))
    return mrmeshnumpy.getNumpyMeanCurvature(mesh), mrmeshnumpy.getNumpyGaussianCurvature(mesh) / areas


@dataclass(frozen=True)
class Job:
    """One row of the table."""

    label: str
    package: str  # as pip installs it
    function: Callable[..., Found]
    size: str  # over what curvature is measured
    lacks: str = ""
    same_radius: bool = False


NO_SIZE, NO_DIRECTIONS = "a size", "directions"
TWO_PASSES = "H and K in one pass"
JOBS: dict[str, Job] = {
    "paradesc": Job("Paradesc", "paradesc", paradesc, "a radius", same_radius=True),
    "paradesc_auto": Job("Paradesc, `radius=\"auto\"`", "paradesc", paradesc_auto, "a radius of its choice"),
    "libigl2": Job("libigl, 2 rings", "libigl", partial(libigl_rings, rings=2), "2 rings", "a size in lengths"),
    "libigl5": Job("libigl, 5 rings", "libigl", partial(libigl_rings, rings=5), "5 rings", "a size in lengths"),
    "libigl_ball": Job("libigl, ball", "libigl", libigl_ball, "whole mean edges", "a size in lengths"),
    "pymeshlab_quadric": Job(
        "PyMeshLab, quadric", "pymeshlab", pymeshlab_quadric, "a radius", TWO_PASSES, same_radius=True
    ),
    "pymeshlab_apss4": Job(
        "PyMeshLab, APSS, scale 4",
        "pymeshlab",
        partial(pymeshlab_apss, scale=4),
        "4 × the distance of vertices",
        f"a size in lengths, {TWO_PASSES}, {NO_DIRECTIONS}",
    ),
    "pymeshlab_apss8": Job(
        "PyMeshLab, APSS, scale 8",
        "pymeshlab",
        partial(pymeshlab_apss, scale=8),
        "8 × the distance of vertices",
        f"a size in lengths, {TWO_PASSES}, {NO_DIRECTIONS}",
    ),
    "pymeshlab_apss16": Job(
        "PyMeshLab, APSS, scale 16",
        "pymeshlab",
        partial(pymeshlab_apss, scale=16),
        "16 × the distance of vertices",
        f"a size in lengths, {TWO_PASSES}, {NO_DIRECTIONS}",
    ),
    "pymeshlab_discrete": Job(
        "PyMeshLab, discrete", "pymeshlab", pymeshlab_discrete, "one ring", f"{NO_SIZE}, {NO_DIRECTIONS}"
    ),
    "trimesh": Job(
        "trimesh, ball measure",
        "trimesh scipy rtree",
        trimesh_ball,
        "a radius",
        NO_DIRECTIONS,
        same_radius=True,
    ),
    "pyvista": Job("PyVista (VTK)", "pyvista vtk", pyvista_discrete, "one ring", f"{NO_SIZE}, {NO_DIRECTIONS}"),
    "potpourri3d": Job(
        "potpourri3d, cotangents",
        "potpourri3d",
        potpourri3d_cotangents,
        "one ring",
        f"K, a sign of H, {NO_SIZE}, {NO_DIRECTIONS}",
    ),
    "meshlib": Job(
        "MeshLib", "meshlib-core", meshlib_discrete, "one ring", f"K (angle defects only), {NO_SIZE}, {NO_DIRECTIONS}"
    ),
}


def lines_of(function: Callable[..., Found]) -> int:
    """How many lines of code stand in a function: imports count; its head, docstring, comments and blanks do not."""
    function = getattr(function, "func", function)
    source = textwrap.dedent(inspect.getsource(function))
    tokens = list(tokenize.generate_tokens(io.StringIO(source).readline))
    body = next(number for number, token in enumerate(tokens) if token.type == tokenize.INDENT)
    code = [token for token in tokens[body:] if token.type not in NOT_CODE]
    if function.__doc__:
        code = code[1:]
    return len({line for token in code for line in range(token.start[0], token.end[0] + 1)})
