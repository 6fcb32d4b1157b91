"""Times mean and Gaussian curvature by Python packages, arrays to arrays, and counts errors and lines of code.

    .venv/bin/python tests/bench/python_peers.py                 # some three minutes; results/python_peers.json
    .venv/bin/python tests/bench/python_peers.py --page          # and tests/bench/REPORT.md, the manual's table
    .venv/bin/python tests/bench/python_peers.py --rough --page  # noise, stairs, folds alone: times are kept
    .venv/bin/python tests/bench/python_peers.py --quick         # the torus once: to try it; nothing is kept

The jobs are those of python_jobs.py. A package that is not installed is left out with a sentence. Time is everything
but the import: each package runs once before, and the fastest of three runs counts, packages in turns. Errors are
against the closed form on a torus, and on the bunny against the reference at the radius, by the one definition
(core/compare.py).
"""

import argparse
import importlib.metadata
import json
import os
import sys
import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1] / "addon"), str(HERE.parent / "accuracy"), str(HERE)]

import meshes  # noqa: E402
import parts  # noqa: E402
import peer_parts  # noqa: E402
import peers  # noqa: E402
import rough_rows  # noqa: E402
import run  # noqa: E402
import speed_page  # noqa: E402
import surfaces  # noqa: E402
import timing  # noqa: E402
from programs import MissingError  # noqa: E402
from python_jobs import JOBS, Job, lines_of  # noqa: E402

import paradesc  # noqa: E402

H, K = "mean_curvature", "gaussian_curvature"
FRACTION = 0.02  # of the diagonal: the radius
# Surfaces that are not smooth, by the heads of the manual's columns: of those of the accuracy report.
ROUGH = {
    "noise 0.1 edges": rough_rows.Row("torus", "noise", 0.1),
    "staircase": rough_rows.Row("torus", "stairs"),
    "folds": rough_rows.Row("torus", "folds", moved=0.45),
}
SMALL = 600  # vertices of the torus on which each job runs once, untimed


@dataclass
class Case:
    """A mesh as users have it, and the truth."""

    vertices: np.ndarray  # (n, 3) float64
    faces: np.ndarray  # (m, 3) int64
    radius: float  # in units of the vertices
    mean: np.ndarray  # (n,)
    gaussian: np.ndarray  # (n,)


def parse(words: list[str] | None) -> argparse.Namespace:
    """Parses the words of the command line."""
    lines = __doc__.splitlines()
    parser = argparse.ArgumentParser(
        description=lines[0], epilog="\n".join(lines[1:]), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="the torus alone, one turn; kept only with --json")
    parser.add_argument("--json", type=Path, help="where the figures go (default: results/python_peers.json)")
    parser.add_argument("--page", action="store_true", help="write REPORT.md and the manual's table from all results")
    parser.add_argument("--rough", action="store_true", help="add errors under noise, stairs and folds to what is kept")
    arguments = parser.parse_args(words)
    if arguments.quick and arguments.page:
        parser.error("--quick is for trying, not for the page")
    return arguments


def torus(vertices: int) -> Case:
    """Irregular triangles of a surface with a closed form."""
    surface = surfaces.torus(vertices)
    points, faces = peers.points_and_faces(surface.arrays)
    return Case(points, faces.astype(np.int64), FRACTION * surface.diagonal, surface.mean, surface.gaussian)


def bunny() -> Case:
    """A scan, with the values of the reference; MissingError if its file is not there."""
    arrays = meshes.find("stanford-bunny")
    if arrays is None:
        raise MissingError("stanford-bunny.obj is not in shared/meshes beside the checkout.")
    points, faces = peers.points_and_faces(arrays)
    radius = FRACTION * meshes.diagonal(arrays)
    truth = paradesc.compute(points, faces, (H, K), radius, radius_unit="absolute", backend="reference")
    return Case(points, faces.astype(np.int64), radius, truth[H], truth[K])


def once(job: Job, case: Case) -> dict[str, object]:
    """One run of a job: seconds by the clock and of all cores, and its errors; MissingError if it cannot be run."""
    start, cpu = time.perf_counter(), time.process_time()
    try:
        mean, gaussian = job.function(case.vertices, case.faces, case.radius)
        taken = {"seconds": time.perf_counter() - start, "cpu_seconds": time.process_time() - cpu}
        return taken | {"error_mean": error_of(H, mean, case), "error_gaussian": error_of(K, gaussian, case)}
    except ImportError:
        raise MissingError(f"{job.package.split()[0]} is not installed (pip install {job.package}).") from None
    except Exception as error:  # noqa: BLE001
        raise MissingError(f"{job.label} failed: {error}") from None


def error_of(name: str, values: np.ndarray | None, case: Case) -> float | None:
    """Mean %AE of H with its better sign, or of K; None if there are no values."""
    if values is None:
        return None
    values = np.asarray(values, np.float64)
    truth = case.mean if name == H else case.gaussian
    signed = peers.with_sign(values, truth) if name == H else values
    return timing.percent_error(signed, truth, case.radius, name)


def measure(cases: dict[str, Case], jobs: dict[str, Job], turns: int) -> tuple[dict[str, dict], dict[str, str]]:
    """A row for each job with its fastest run on each mesh, and why jobs are missing."""
    rows, reasons = {}, {}
    in_turns({"": torus(SMALL)}, jobs, 1, {name: {} for name in jobs}, reasons)  # imports and first allocations
    for name, job in jobs.items():
        about = {key: value for key, value in asdict(job).items() if key != "function"}
        rows[name] = {**about, "lines": lines_of(job.function)}
    in_turns(cases, jobs, turns, rows, reasons)
    return {name: row for name, row in rows.items() if name not in reasons}, reasons


def tried(name: str, jobs: dict[str, Job], case: Case, reasons: dict) -> dict | None:
    """One run of a job, or nothing where something is missing for it, with the reason."""
    try:
        return once(jobs[name], case)
    except MissingError as error:
        reasons[name] = str(error)
        return None


def in_turns(cases: dict[str, Case], jobs: dict[str, Job], turns: int, rows: dict, reasons: dict) -> None:
    """Puts the fastest of several runs of each job into its row, under the mesh's name."""
    for mesh, case in cases.items():
        for _ in range(turns):
            for name in [name for name in jobs if name not in reasons]:
                before = rows[name].get(mesh)
                parts.say(f"{mesh} {name} … ")
                if found := tried(name, jobs, case, reasons):
                    rows[name][mesh] = timing.fastest([found, before] if before else [found])
        parts.say("\n")


def rough_errors(jobs: dict[str, Job], rows: dict, reasons: dict) -> None:
    """Puts the errors on surfaces that are not smooth into the rows of the jobs."""
    for head, row in ROUGH.items():
        made = row.make()
        mean, gaussian = (made.truth[name] for name in (H, K))
        case = Case(made.points, made.faces.astype(np.int64), FRACTION * made.diagonal, mean, gaussian)
        for name in [name for name in jobs if name in rows and name not in reasons]:
            parts.say(f"{head} {name} … ")
            if found := tried(name, jobs, case, reasons):
                rows[name].setdefault("rough", {})[head] = {key: found[key] for key in ("error_mean", "error_gaussian")}
        parts.say("\n")


def versions(jobs: dict[str, Job]) -> dict[str, str]:
    """The versions of the packages that are installed, numpy's first."""
    found = {"numpy": np.__version__, "paradesc": paradesc.__version__}
    for package in sorted({word for job in jobs.values() for word in job.package.split()} - set(found)):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def made(quick: bool) -> tuple[dict[str, Case], dict[str, str]]:
    """The meshes, and why some are missing."""
    makers = {"torus": partial(torus, peer_parts.PEER_MESH)} | ({} if quick else {"bunny": bunny})
    cases, lacking = {}, {}
    for name, maker in makers.items():
        try:
            cases[name] = maker()
        except MissingError as error:
            lacking[name] = str(error)
    return cases, lacking


def add_rough(found: dict[str, object]) -> dict[str, str]:
    """Adds jobs that are new, without times, and errors on surfaces that are not smooth. Gives why any are missing."""
    rows, lacking = found["rows"], {}
    if new := {name: job for name, job in JOBS.items() if name not in rows}:
        measured, lacking = measure(made(False)[0], new, 1)
        rows.update({name: {**row, "untimed": True} for name, row in measured.items()})  # not beside the others
    rough_errors(JOBS, rows, lacking)
    return lacking


def content(arguments: argparse.Namespace, command: str) -> dict[str, object]:
    """Measures everything: the content of the JSON file."""
    stamp = {"device": "CPU alone", **run.where_and_when(command), "versions": versions(JOBS)}
    cases, lacking = made(arguments.quick)
    rows, reasons = measure(cases, JOBS, 1 if arguments.quick else peer_parts.TURNS)
    if not arguments.quick:
        rough_errors(JOBS, rows, reasons)
    sizes = {
        name: {"vertices": len(case.vertices), "triangles": len(case.faces), "radius": case.radius}
        for name, case in cases.items()
    }
    after = {"load_after": round(os.getloadavg()[0], 2)}
    return {**stamp, **after, "meshes": sizes, "rows": rows, "reasons": lacking | reasons}


def main(words: list[str] | None = None) -> int:
    """Measures, prints the table and keeps the figures."""
    arguments = parse(words)
    results = HERE / "results"
    given = sys.argv[1:] if words is None else words
    if arguments.rough:
        found = json.loads((results / speed_page.PYTHON).read_text())
        parts.say("".join(f"{reason}\n" for reason in add_rough(found).values()))
    else:
        found = content(arguments, " ".join(["python tests/bench/python_peers.py", *given]))
    kept = arguments.json or (None if arguments.quick else results / speed_page.PYTHON)
    if kept:
        kept.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n")
    sys.stdout.write("\n".join(speed_page.python_lines(found)))
    if arguments.page:
        run.write_pages(results)
    return 0


if __name__ == "__main__":
    sys.exit(main())
