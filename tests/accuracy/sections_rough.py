"""Sections on surfaces that are not smooth: noise, stairs and folds; which edges count as creases; one bad vertex.

As a program it prints the errors of ours alone:

    python tests/accuracy/sections_rough.py [--rows noise] [--estimator integral] [--radii 0.04,auto]
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon"))

import meshes
import rough_peers
import rough_scans
import rough_surfaces as rough
from bench import errors
from rough_rows import ROWS, SEEDS
from surfaces import Surface

import paradesc

H, K = rough.CURVATURES[:2]
LABELS = {H: "Mean curvature", K: "Gaussian curvature"}
RADII = (0.02, 0.04, 0.08, 0.12)
OTHERS = ("local_bending_energy", "sphere_volume_normalized", "euclidean_area")
BENDS = (20, 25, 30, 45, 60, 90, 120, 150)
NORMAL = 1.96  # standard errors on either side hold 95 % of what is spread normally


def percent(radius):
    """A radius as people read it."""
    return radius if isinstance(radius, str) else f"{100 * radius:g} %"


# ---- Ours


@dataclass
class Error:
    """Errors of one descriptor on one row at one radius, over its seeds."""

    mean: float
    largest: float
    covered: float | None  # % of the vertices whose truth lies within the error bars, if there are any

    def __str__(self):
        return f"{self.mean:.2f} ({self.largest:.0f})" if np.isfinite(self.mean) else "–"


def standard_error(result, name):
    """(n,) the standard error of the mean curvature; None beside another."""
    return result.get("standard_error") if name == H else None


def asked():
    """The names of the curvatures, and of the standard error of the first."""
    return [*rough.CURVATURES, "standard_error"]


def at_length(points, faces, radius):
    """The mean curvature at a radius in the unit of the points."""
    return paradesc.compute(points, faces, H, radius, radius_unit="absolute", backend="cpu")[H]


def ours(row, radii, seeds, **chosen):
    """By radius and descriptor the errors over so many seeds, and the most edges that were taken for creases."""
    found, creases, names = {radius: [] for radius in radii}, 0, asked()
    for seed in range(min(seeds, row.seeds)):
        case = row.make(seed)
        with paradesc.Mesh(case.points, case.faces, backend="cpu") as mesh:
            for radius in radii:
                result = mesh.compute(names, radius, **chosen)
                found[radius].append({name: error_of(result, name, exact) for name, exact in case.truth.items()})
                creases = max(creases, result.report["field_report"]["crease_edges"])
    return {radius: over_seeds(of_each) for radius, of_each in found.items()}, creases


def error_of(result, name, exact):
    """The errors of one mesh."""
    stats, bars = errors(name, result[name], exact, result.radius), standard_error(result, name)
    covered = None if bars is None else 100 * float(np.mean(np.abs(result[name] - exact) <= NORMAL * bars))
    return Error(stats.mean, stats.max, covered)


def over_seeds(of_each):
    """Means of means and of shares, and the largest of all."""
    found = {}
    for name in of_each[0]:
        every = [one[name] for one in of_each]
        covered = None if every[0].covered is None else np.mean([one.covered for one in every])
        found[name] = Error(np.mean([one.mean for one in every]), max(one.largest for one in every), covered)
    return found


# ---- The section


def accuracy(_bench, out, quick):
    """Writes the errors of the default on all rows, error bars, other programs, published surfaces and a scan."""
    out.say(
        "Tori (R 1, r 0.4; about 40,000 triangles), ellipsoids (1.5, 1, 0.7; 20,000), staircases (marching cubes of "
        "binary voxels), irregular: vertices are moved along the surface by up to 0.2 of a cell; *folds*: by up to as "
        "much as the row says, and from 0.35 on triangles fold over. Noise is Gaussian in each coordinate, or along the "
        "normal alone, in mean edges. The truth is that of the nearest point of the smooth body, under noise "
        f"of the unmoved vertex. {'One seed' if quick else 'Three seeds'} where there is chance."
    )
    radii = (*RADII, "auto")
    seeds = 1 if quick else SEEDS
    found = {row: ours(row, radii, seeds) for row in ROWS}
    extrapolated = {row: ours(row, RADII, seeds, estimator="extrapolated")[0] for row in ROWS}
    for name, label in LABELS.items():
        folds = max(at[r][name].largest for row, (at, _) in found.items() for r in RADII if row.kind == "folds")
        out.table(
            f"{label}, defaults: mean (largest) error in %, and edges taken for creases, of which there are none. The "
            f"largest on folds: {folds:.1f} %",
            ["surface", *map(percent, radii), "creases"],
            [[row.name, *(str(at[radius][name]) for radius in radii), count] for row, (at, count) in found.items()],
        )
        out.table(
            f"{label}, extrapolated: mean (largest) error in %",
            ["surface", *map(percent, RADII)],
            [[row.name, *(str(at[radius][name]) for radius in RADII)] for row, at in extrapolated.items()],
        )
    found = {row: at for row, (at, _) in found.items()}
    error_bars(out, found, radii, "defaults")
    error_bars(out, extrapolated, RADII, "extrapolated")
    against(out, found, extrapolated, rough_peers.Kept(measure=False))
    rough_scans.published(out, radii[len(RADII) :])
    if not quick:
        others(out)
        rough_scans.stability(out)


def error_bars(out, found, radii, which):
    """Writes how often the truth lies within the error bars."""
    out.table(
        f"The share of vertices whose true H lies within ±{NORMAL} standard errors of noise, in %, {which}; what the radius blurs "
        "is not in them",
        ["surface", *map(percent, radii)],
        [[row.name, *(f"{at[r][H].covered:.0f}" for r in radii)] for row, at in found.items()],
    )


def others(out):
    """Writes what noise does to what is no curvature."""
    rows = []
    for row in [row for row in ROWS if row.body == "torus" and row.kind in ("clean", "noise", "stairs")]:
        case = row.make()
        surface = Surface(row.name, None, None, case.truth[H], case.truth[K], None)
        for radius in RADII[1:3]:
            result = paradesc.compute(case.points, case.faces, OTHERS, radius, backend="cpu")
            flat = {"sphere_volume_normalized": 0.5, "euclidean_area": np.pi * result.radius**2}
            cells = [errors(OTHERS[0], result[OTHERS[0]], surface.exact(OTHERS[0], result.radius), result.radius).mean]
            for name in OTHERS[1:]:
                cells.append(100 * np.nanmean(np.abs(result[name] - surface.exact(name, result.radius))) / flat[name])
            rows.append([row.name, percent(radius), *cells])
    out.table(
        "Bending energy (mean error in % of its range), and the volume in the ball and the area (in % of a plane's)",
        ["surface", "r", "LBE", "V / ball", "EA"],
        rows,
    )


# ---- Beside other programs


def against(out, found, extrapolated, kept):
    """Writes our errors beside those of other programs, at equal support and at the best one of each."""
    theirs, edges = {}, {}  # the latter: how many mean edges the diagonal has
    for row in found:
        case = row.make()
        every = {peer: rough_peers.errors(kept, peer, case) for peer in rough_peers.PEERS}
        theirs[row], edges[row] = {peer: ones for peer, ones in every.items() if ones}, case.diagonal / case.edge
    lacking = sum(peer not in of_row for of_row in theirs.values() for peer in rough_peers.PEERS)
    if lacking:
        out.lacks(f"{lacking} rows of other programs, which python tests/accuracy/rough_peers.py measures once.")
    if not any(theirs.values()):
        return
    four = rough_peers.TRIED[0]
    beyond = rough_peers.measured_reach(lambda *given: [at_length(*given[:2], four * given[3])], four) - four
    out.say(rough_peers.explained(kept, beyond))
    for name, label in LABELS.items():
        equal, best, counts = [], [], [0, 0, 0, 0]
        for row, at in found.items():
            cells = []
            for radius in RADII:
                other = rough_peers.best_at(theirs[row], name, radius * edges[row] + beyond)
                both = at[radius][name].mean, extrapolated[row][radius][name].mean
                cells.append(f"{both[0]:.2f} / {both[1]:.2f} · {other}")
                counts[0] += other.mean > min(both)
                counts[1] += np.isfinite(other.mean)
            own = at["auto"][name].mean
            other = rough_peers.best(theirs[row], name)
            counts[2] += row.noisy and other.mean >= 2 * own
            counts[3] += row.noisy
            equal.append([row.name, *cells])
            each = [rough_peers.best({peer: theirs[row].get(peer, [])}, name) for peer in rough_peers.PEERS]
            best.append([row.name, f"{own:.2f}", *(one.short for one in each)])
        out.table(
            f"{label} at equal support, mean error in %: ours at the radius, as fitted / extrapolated · the best of the others. The "
            f"smaller of ours is smaller than theirs in {counts[0]} of {counts[1]} cells",
            ["surface", *map(percent, RADII)],
            equal,
        )
        out.table(
            f"{label}, ours at the radius that is chosen by itself, each of the others at its best size, mean error in % (its size). "
            f"On {counts[2]} of {counts[3]} rows with noise of 0.1 edges and more ours is at least twice as good as the best of the others",
            ["surface", "Paradesc, auto", *(peer.label for peer in rough_peers.PEERS)],
            best,
        )


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
    "rough": (
        accuracy,
        "Noise, stairs and folds",
        "“robustness in the presence of noise is achieved by computations at multiple scales”",
        400,
        120,
    ),
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
    sys.stdout.write(f"{'mean (largest) error in %':36}" + "".join(f"{percent(radius):>18}" for radius in radii) + "\n")
    for row in [row for row in ROWS if given["rows"] in row.name]:
        found, count = ours(row, radii, given["seeds"], **chosen)
        for name in rough.CURVATURES if given["all"] else (H, K):
            label = f"{row.name} {dict(zip(rough.CURVATURES, ('H', 'K', 'k1', 'k2'), strict=True))[name]}"
            label += f" [{count} creases]" * bool(count)
            sys.stdout.write(f"{label:36}" + "".join(f"{found[radius][name]!s:>18}" for radius in radii) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
