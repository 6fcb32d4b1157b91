"""Section on surfaces that are not smooth: which edges count as creases, and what one bad vertex does to its surroundings."""

import meshes
import numpy as np
import rough_surfaces as rough
from bench import errors

import paradesc

BODIES = {
    "torus": rough.torus,
    "sphere": lambda *chosen: rough.round_body(np.ones(3), *chosen),
    "ellipsoid": lambda *chosen: rough.round_body(rough.AXES, *chosen),
}
MOVED, NOISE, CELLS = (0, 0.2, 0.3, 0.35, 0.4, 0.45), (0.02, 0.1, 0.2, 0.3), (0.05, 0.025)
BENDS = (20, 25, 30, 45, 60, 90, 120, 150)


def smooth_surfaces(quick):
    """Yields name, points, triangles and mean curvature of surfaces without a crease."""
    for body, make in BODIES.items():
        for vertices in (10000,) if quick else (2500, 10000, 48000):
            for moved in MOVED:
                yield f"{body}, moved {moved:g}", *make(vertices, moved)
            points, faces, exact = make(vertices, 0.2)
            for amount in NOISE:
                yield f"{body}, noise {amount:g}", rough.noisy(points, faces, amount), faces, exact
        for cell in CELLS[: 1 if quick else None]:
            yield f"{body}, staircase of {cell:g}", *rough.staircase(body, cell)


def solids():
    """Yields name, points, triangles and the number of creases of solids; None: what is found without noise."""
    for cells in (8, 32):
        yield f"cube, {cells} cells", *rough.box(cells), 12 * cells
    for bend in BENDS:
        yield f"ridge of {bend}°", *rough.ridge(bend), None
    for name in ("fandisk", "barracks"):
        arrays = meshes.find(name)
        if arrays is not None:
            yield name, arrays.positions, arrays.corner_vertices[arrays.triangle_corners], None


def measured(points, faces, radius, creases="auto"):
    """The mean curvature, and how many edges were creases."""
    found = paradesc.compute(points, faces, radius=radius, creases=creases, backend="cpu")
    return found["mean_curvature"], found.report["field_report"]["crease_edges"]


def creases(_bench, out, quick):
    """Writes the tables of creases and of one vertex beside another."""
    radii = (0.02,) if quick else (0.01, 0.02, 0.04)
    rows = []
    for name, points, faces, exact in smooth_surfaces(quick):
        cells = []
        for radius in radii:
            (found, count), (without, _) = (measured(points, faces, radius, kind) for kind in ("auto", "none"))
            both = [errors("mean_curvature", part, exact, radius).mean for part in (found, without)]
            cells.append(f"{count}: {both[0]:.3f} ({both[1]:.3f})")
        rows.append([f"{name}, {len(faces):,}", *cells])
    head = [f"r = {100 * radius:g} %" for radius in radii]
    out.table(
        "Smooth surfaces, and what scanners and remeshers make of them: edges taken for creases, mean error of H in %, "
        "and in parentheses without creases. Noise is in mean edges; vertices are moved by up to that share of a cell",
        ["surface, triangles", *head],
        rows,
    )
    rows = []
    for name, points, faces, count in solids():
        found = [measured(points if not a else rough.noisy(points, faces, a), faces, 0.02)[1] for a in (0, 0.02, 0.1)]
        rows.append([name, found[0] if count is None else count, *found])
    out.table("Solids: creases found at r = 2 %", ["solid", "creases", "as it is", "noise 0.02", "noise 0.1"], rows)
    out.table(
        "One vertex more, so many edges from a corner of the triangle that it divides, in 8 random directions: the "
        "largest change of H at any other vertex of a torus of 11,520 triangles, r = 2 %, in % of the range",
        ["edges", "median", "largest"],
        [[distance, *changes(distance)] for distance in (1e-6, 1e-4, 1e-2, 1e-1)],
    )


def changes(distance):
    """The median and the largest over eight places."""
    points, faces, exact = rough.torus(5760)
    before = measured(points, faces, 0.02)[0]
    reach = np.ptp(np.percentile(exact, [2.5, 97.5]))
    largest = []
    for seed in range(8):
        generator = np.random.default_rng(seed)
        number, way = generator.integers(len(faces)), generator.normal(size=3)
        p, q, r = faces[number]
        added = points[p] + way / np.linalg.norm(way) * distance * np.linalg.norm(points[p] - points[q])
        n = len(points)
        divided = np.concatenate([np.delete(faces, number, 0), [[p, q, n], [q, r, n], [r, p, n]]])
        found = measured(np.concatenate([points, [added]]), divided, 0.02)[0][:-1]
        largest.append(100 * np.max(np.abs(found - before)) / reach)
    return np.median(largest), np.max(largest)


SECTIONS = {"creases": (creases, "Creases, folds and slivers", "not measured", 240, 40)}
