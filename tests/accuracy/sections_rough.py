"""Sections on surfaces that are not smooth: noise, stairs and folds; which edges count as creases; one bad vertex.

    python tests/accuracy/sections_rough.py [--rows noise] [--estimator integral] …     # ours alone, to the terminal
"""

import argparse
import sys
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon"))

import meshes
import rough_surfaces as rough
from bench import errors
from rough_rows import ROWS

import paradesc

H, K = rough.CURVATURES[:2]
RADII = (0.02, 0.04, 0.08, 0.12)
BENDS = (20, 25, 30, 45, 60, 90, 120, 150)


def percent(radius):
    """A radius as people read it."""
    return radius if isinstance(radius, str) else f"{100 * radius:g} %"


# ---- Ours


def ours(row, radii, seeds, **chosen):
    """Stats of all curvatures by radius, over the seeds of a row: means of means, the largest of all; and creases."""
    found, creases = {radius: [] for radius in radii}, 0
    for seed in range(min(seeds, row.seeds)):
        case = row.make(seed)
        with paradesc.Mesh(case.points, case.faces, backend="cpu") as mesh:
            for radius in radii:
                result = mesh.compute(rough.CURVATURES, radius, **chosen)
                found[radius].append(
                    {name: errors(name, result[name], exact, result.radius) for name, exact in case.truth.items()}
                )
                creases = max(creases, result.report["field_report"]["crease_edges"])
    return {radius: over_seeds(of_each) for radius, of_each in found.items()}, creases


def over_seeds(of_each):
    """(mean, largest) by descriptor."""
    return {name: (np.mean([one[name].mean for one in of_each]), max(one[name].max for one in of_each)) for name in of_each[0]}


def accuracy(_bench, out, quick):
    """Writes the errors of the default on all rows."""
    rows = {H: [], K: []}
    for row in ROWS:
        found, creases = ours(row, RADII, 1 if quick else row.seeds)
        for name, written in rows.items():
            written.append([row.name, *(shown(found[radius][name]) for radius in RADII), creases])
    for name, written in rows.items():
        out.table(
            f"{name}: mean error in %, and in parentheses the largest; edges taken for creases, of which there are none",
            ["surface", *map(percent, RADII), "creases"],
            written,
        )


def shown(error):
    """Mean and largest."""
    return f"{error[0]:.2f} ({error[1]:.0f})" if np.isfinite(error[0]) else "–"


# ---- Creases


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


def measured(points, faces, radius):
    """The mean curvature, and how many edges were creases."""
    found = paradesc.compute(points, faces, radius=radius, backend="cpu")
    return found[H], found.report["field_report"]["crease_edges"]


def creases(_bench, out, quick):
    """Writes the tables of creases of solids and of one vertex beside another."""
    rows = []
    for name, points, faces, count in solids():
        found = [measured(points if not a else rough.noisy(points, faces, a), faces, 0.02)[1] for a in (0, 0.02, 0.1)]
        rows.append([name, found[0] if count is None else count, *found])
    out.table(
        "Solids: creases found at r = 2 %, also with noise in mean edges",
        ["solid", "creases", "as it is", "noise 0.02", "noise 0.1"],
        rows,
    )
    out.table(
        "One vertex more, so many edges from a corner of the triangle that it divides, in 8 random directions: the "
        "largest change of H at any other vertex of a torus of 11,520 triangles, r = 2 %, in % of the range",
        ["edges", "median", "largest"],
        [[distance, *changes(distance, 2 if quick else 8)] for distance in (1e-6, 1e-4, 1e-2, 1e-1)],
    )


def changes(distance, places):
    """The median and the largest over so many places."""
    points, faces = rough.torus(5760)
    before = measured(points, faces, 0.02)[0]
    reach = np.ptp(np.percentile(rough.exact("torus", points)[H], [2.5, 97.5]))
    largest = []
    for seed in range(places):
        generator = np.random.default_rng(seed)
        number, way = generator.integers(len(faces)), generator.normal(size=3)
        p, q, r = faces[number]
        added = points[p] + way / np.linalg.norm(way) * distance * np.linalg.norm(points[p] - points[q])
        n = len(points)
        divided = np.concatenate([np.delete(faces, number, 0), [[p, q, n], [q, r, n], [r, p, n]]])
        found = measured(np.concatenate([points, [added]]), divided, 0.02)[0][:-1]
        largest.append(100 * np.max(np.abs(found - before)) / reach)
    return np.median(largest), np.max(largest)


SECTIONS = {
    "rough": (accuracy, "Noise, stairs and folds", "not measured", 400, 120),
    "creases": (creases, "Creases and slivers", "not measured", 60, 30),
}


def main(words):
    """Prints the errors of ours alone."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", default="", help="those alone whose name has this")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--all", action="store_true", help="k1 and k2 too")
    parser.add_argument("--radii", default=",".join(map(str, RADII)), help="shares of the diagonal, or auto")
    for name in ("estimator", "creases", "normals"):
        parser.add_argument(f"--{name}")
    given = vars(parser.parse_args(words))
    chosen = {name: given[name] for name in ("estimator", "creases", "normals") if given[name]}
    radii = [word if word == "auto" else float(word) for word in given["radii"].split(",")]
    names = rough.CURVATURES if given["all"] else (H, K)
    sys.stdout.write(f"{'mean (largest) error in %':32}" + "".join(f"{percent(radius):>20}" for radius in radii) + "\n")
    for row in ROWS:
        if given["rows"] not in row.name:
            continue
        found, count = ours(row, radii, given["seeds"], **chosen)
        for name in names:
            label = f"{row.name} {''.join(part[0] for part in name.split('_'))}" + (f" [{count}]" if count else "")
            sys.stdout.write(f"{label:32}" + "".join(f"{shown(found[radius][name]):>20}" for radius in radii) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
