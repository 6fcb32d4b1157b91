"""Surfaces that others published with their methods' errors, and a scan that is meshed in other ways."""

import time
from dataclasses import dataclass
from pathlib import Path

import meshes
import numpy as np
import rough_surfaces as rough

import paradesc

PUBLISHED = Path(__file__).resolve().parents[3] / "shared" / "meshes" / "published"
SHOWN = ("mean_curvature", "principal_curvature_max", "principal_curvature_min")
THEIR_MINUTES = 32  # of the staircase sphere R 30, on ten processes, by their log
SCAN_RADII = (0.02, 0.04)


@dataclass(frozen=True)
class Published:
    """A surface of PyCurv's, and mean errors of H, k1 and k2 in % that its authors have at a radius `rh` in voxels."""

    title: str
    file: str
    radius: float  # of the sphere or cylinder
    rh: float
    methods: dict[str, tuple[float, float, float]]
    is_cylinder: bool = False

    @property
    def reaches(self):
        """The radius, and as chords what one of their two passes and both reach: π/2 times it along the surface."""
        along = np.array([np.pi / 2 * self.rh, np.pi * self.rh])
        if not self.is_cylinder:
            along = 2 * self.radius * np.sin(np.minimum(along / self.radius, np.pi) / 2)
        return [self.rh, *along]


NOISY = "noisy_sphere_r30.vtk"
SURFACES = (
    Published(
        "smooth sphere R 10",
        "smooth_sphere_r10.vtk",
        10,
        10,
        {
            "AVV": (0.19, 0.90, 1.2),
            "SSVV": (0.27, 0.21, 0.47),
            "VTK": (75, 53, 150),
            "FreeSurfer": (77, 71, 113),
            "Mindboggle": (117, 470, 264),
        },
    ),
    Published(
        "staircase sphere R 10",
        "noisy_sphere_r10.vtk",
        10,
        10,
        {
            "AVV": (4.6, 6.0, 3.2),
            "SSVV": (5.1, 7.3, 3.4),
            "VTK": (123, 353, 345),
            "FreeSurfer": (332, 459, 414),
            "Mindboggle": (19, 327, 298),
        },
    ),
    Published(
        "staircase sphere R 30",
        NOISY,
        30,
        10,
        {"AVV": (3.1, 5.2, 3.2), "VTK": (382, 942, 922), "FreeSurfer": (873, 1103, 1044), "Mindboggle": (96, 957, 960)},
    ),
    Published("staircase sphere R 30", NOISY, 30, 8, {"SSVV": (11.8, 15.1, 14.6)}),
    Published("staircase sphere R 30", NOISY, 30, 28, {"AVV": (1.4, 2.6, 0.8), "SSVV": (1.5, 2.0, 1.0)}),
    Published(
        "cylinder with its borders",
        "smooth_cylinder_r10_h25.vtk",
        10,
        5,
        {
            "AVV": (9.9, 7.9, 0.0025),
            "SSVV": (6.5, 4.5, 0.0023),
            "VTK": (48, 32, 0.024),
            "Mindboggle": (186, 188, 0.002),
        },
        is_cylinder=True,
    ),
)


def read(path):
    """Points and triangles of a legacy VTK file in ASCII, wound outwards."""
    words = path.read_text().split()
    at = words.index("POINTS")
    points = np.array(words[at + 3 : at + 3 + 3 * int(words[at + 1])], float).reshape(-1, 3)
    at = words.index("POLYGONS")
    faces = np.array(words[at + 3 : at + 3 + int(words[at + 2])], int).reshape(-1, 4)[:, 1:]
    middle = points.mean(0)
    corners = points[faces] - middle
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outwards = np.einsum("ij,ij->", corners.mean(1), normals)
    return points, faces if outwards > 0 else faces[:, ::-1]


def measured(surface, points, faces, reach):
    """The radius, mean errors of H, k1 and k2 in % (absolute where the truth is 0) over triangles, and seconds."""
    start = time.monotonic()
    unit = "diagonal" if reach == "auto" else "absolute"
    found = paradesc.compute(points, faces, SHOWN, reach, radius_unit=unit, backend="cpu")
    taken = time.monotonic() - start
    k1, k2 = 1 / surface.radius, 0.0 if surface.is_cylinder else 1 / surface.radius
    errors = []
    for name, truth in zip(SHOWN, ((k1 + k2) / 2, k1, k2), strict=True):
        error = np.nanmean(np.abs(found[name][faces].mean(1) - truth))
        errors.append(error if truth == 0 else 100 * error / truth)
    return found.radius, errors, taken


def published(out, also=()):
    """Writes the table of the published surfaces, at what their methods reach and at other radii."""
    rows = []
    for surface in SURFACES:
        path = PUBLISHED / surface.file
        if not path.is_file():
            out.lacks(f"{surface.file} is not in ../shared/meshes/published.")
            continue
        points, faces = read(path)
        rows += [
            [f"{surface.title}, rh {surface.rh:g}", name, "", *values, "", ""]
            for name, values in surface.methods.items()
        ]
        best = np.min(list(surface.methods.values()), 0)
        for reach in (*surface.reaches, *also):
            radius, errors, taken = measured(surface, points, faces, reach)
            better = sum(error <= least for error, least in zip(errors, best, strict=True))
            name = "Paradesc, auto" if reach == "auto" else "Paradesc"
            rows.append([f"{surface.title}, rh {surface.rh:g}", name, radius, *errors, f"{better} of 3", taken])
    out.table(
        "Surfaces that PyCurv's authors published (Salfer et al. 2020), with their own figures: mean error over "
        "triangles in %, of a curvature that is 0 the mean itself. Their two passes reach π/2 rh along the surface "
        "each; ours is measured at rh, at the chord of one pass and at that of both (a sphere's diameter where they reach "
        f"around it). A triangle has the mean of its corners. Their log has {THEIR_MINUTES} minutes on ten processes "
        "for the sphere R 30",
        ["surface", "method", "radius", "H", "k1", "k2", "as good as their best", "s"],
        rows,
    )


# ---- A scan that is meshed in other ways


def remeshed(out, points, faces):
    """Yields the name and PyVista's mesh of other meshes of the same surface."""
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(points, faces)
    yield "subdivided", mesh.subdivide(1, "linear")
    yield "decimated by half", mesh.decimate(0.5)
    try:
        import pymeshlab
    except ImportError:
        out.lacks("pymeshlab, which meshes a surface anew, is not installed (pip install pymeshlab).")
        return
    anew = pymeshlab.MeshSet(verbose=False)
    anew.add_mesh(pymeshlab.Mesh(points, faces))
    length = pymeshlab.PureValue(rough.mean_edge(points, faces))
    anew.meshing_isotropic_explicit_remeshing(iterations=3, targetlen=length)
    found = anew.current_mesh()
    yield "meshed anew, evenly", pyvista.PolyData.from_regular_faces(found.vertex_matrix(), found.face_matrix())


def carried(mesh, values, points):
    """Values of a PyVista mesh at its points that are nearest to (n, 3) points."""
    cells, near = mesh.find_closest_cell(points, return_closest_point=True)
    corners = mesh.regular_faces[cells]
    a, b, c = np.moveaxis(np.asarray(mesh.points, float)[corners], 1, 0)
    normal = np.cross(b - a, c - a)
    weights = [(np.cross(q - near, r - near) * normal).sum(1) for q, r in ((b, c), (c, a), (a, b))]
    weights = np.stack(weights, 1) / np.maximum((normal * normal).sum(1, keepdims=True), 1e-300)
    return (values[corners] * weights).sum(1)


def stability(out):
    """Writes how the value of a vertex of a scan changes with its mesh."""
    arrays = meshes.find("stanford-bunny")
    if arrays is None:
        out.lacks("stanford-bunny.obj is not in ../shared/meshes.")
        return
    points, faces = arrays.positions.astype(float), arrays.triangle_vertices
    length, name, rows = meshes.diagonal(arrays), rough.CURVATURES[0], []
    for radius in SCAN_RADII:
        asked = [name, "standard_error"]
        before = paradesc.compute(points, faces, asked, radius * length, radius_unit="absolute", backend="cpu")
        spread, own = np.ptp(np.nanpercentile(before[name], [2.5, 97.5])), before["standard_error"]
        for label, mesh in remeshed(out, points, faces):
            there = paradesc.compute(
                mesh.points, mesh.regular_faces, name, radius * length, radius_unit="absolute", backend="cpu"
            )
            change = np.abs(carried(mesh, there[name].astype(float), points) - before[name])
            within = 100 * np.mean((change <= own)[np.isfinite(change)])
            shares = 100 * np.nanpercentile(change, (50, 75, 99)) / spread
            rows.append([label, mesh.n_cells, f"{100 * radius:g} %", *shares, within])
    out.table(
        f"The bunny ({len(faces):,} triangles) meshed in other ways: how H of the same place differs, in % of its "
        "range, and how many of the places differ by less than the standard error (75 % are wanted)",
        ["mesh", "triangles", "r", "half differ by less", "three in four", "99 in 100", "within the standard error, %"],
        rows,
    )
