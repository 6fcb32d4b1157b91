"""The parts of a run. Each measures one thing on one mesh and gives a dictionary of which figures.py makes ratios."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import meshes
import numpy as np
import peers
import programs
import surfaces
import timing
from figures import ALLOWED_ERROR, FINE_ERROR
from programs import MissingError
from timing import NAME

from paradesc import bridge
from paradesc.bridge import MeshArrays, Options

HERE = Path(__file__).resolve().parent
EIGHT = (
    "mean_curvature",
    "gaussian_curvature",
    "principal_curvature_max",
    "principal_curvature_min",
    "shape_index",
    "curvedness",
    "local_bending_energy",
    "sphere_volume",
)
THREE_RADII = (0.01, 0.02, 0.04)  # the middle one alone is what they are compared with
FEWEST_IN_COMMON = 50


@dataclass
class Run:
    """The settings that all parts share, and their results."""

    bench: timing.Bench
    build: Path
    folder: Path
    baseline_seconds: float = 2.0  # a sample of the baseline runs about so long
    reference_points: int = 400
    scale: float = 1.0  # of the meshes, to try the script itself
    measured: dict[str, dict] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    cpu_seconds: dict[str, float] = field(default_factory=dict)  # of all cores, those of other processes too

    @contextmanager
    def part(self, *names: str):
        """Goes on if something cannot be measured, and keeps the reason for all these parts."""
        start, cpu = time.perf_counter(), cpu_time()
        say(f"{names[0]} … ")
        try:
            yield
        except (MissingError, bridge.ParadescError, ImportError, OSError) as error:
            for name in names:
                self.reasons[name] = str(error)
        self.seconds[names[0]] = time.perf_counter() - start
        self.cpu_seconds[names[0]] = cpu_time() - cpu
        say(f"{self.seconds[names[0]]:.0f} s{' (not measured)' if names[0] in self.reasons else ''}\n")


def cpu_time() -> float:
    """Seconds of all cores, of this process and of those that it has waited for."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def say(text: str) -> None:
    """Prints progress for people."""
    sys.stderr.write(text)
    sys.stderr.flush()


@contextmanager
def open_run(arguments: object):
    """The engine on the CPU and a folder for files."""
    with tempfile.TemporaryDirectory() as folder:
        run = Run(timing.Bench(), arguments.build, Path(folder))
        run.scale = arguments.scale
        run.baseline_seconds *= min(1.0, run.scale)
        yield run


def against_baseline(run: Run, arrays: MeshArrays, fraction: float, normals: tuple[str, ...] = ("fitted",)) -> dict:
    """Measures the baseline before and after our frames, and their errors."""
    path = programs.write_mesh(run.folder / "mesh", arrays)
    radius = fraction * meshes.diagonal(arrays)
    taken, found = programs.object_space(run.build, path, radius, run.baseline_seconds, run.reference_points)
    truth = found["reference"]
    result = ways(run.bench, arrays, Options(radius=fraction), truth, normals)
    again, _ = programs.object_space(run.build, path, radius, run.baseline_seconds, methods="baseline")
    base = timing.fastest([taken["baseline"], again["baseline"]])
    return result | {
        "triangles": len(arrays.triangle_corners),
        "vertices": len(arrays.positions),
        "radius": fraction,
        "baseline": base | {"error": common_error(found["baseline"], truth, radius)},
        "reference_points": len(truth.vertices),
    }


def ways(
    bench: timing.Bench,
    arrays: MeshArrays,
    options: Options,
    truth: programs.Values,
    normals: tuple[str, ...],
) -> dict:
    """Measures our frames and their errors: 256 samples, and the fewest that keep an error."""
    mesh, once = bench.mesh(arrays, options)
    few = 1 if len(arrays.triangle_corners) > 500_000 else 2

    def frame(chosen: Options, repeats: int) -> dict:
        return timing.with_error(bench.frame(mesh, arrays, chosen, repeats=repeats), truth)

    with mesh:
        found = {"once": once, "at_256": frame(options, few)}
        fewest = bench.cheapest(mesh, arrays, options, truth, ALLOWED_ERROR)
        found["fewest"] = frame(fewest, 2 * few)
        found["fine"] = frame(bench.cheapest(mesh, arrays, options, truth, FINE_ERROR), 2 * few)
        if "max" in normals:
            found["max_normals"] = frame(replace(fewest, normals="max"), few)
    return found


def torus(run: Run, triangles: int, charts: int = 2) -> MeshArrays:
    """The smooth shape of the detail sweep, irregularly triangulated; charts: 1, or blocks along a side."""
    return surfaces.torus(int(run.scale * triangles) // 2, irregular=True, charts=charts).arrays


def detail(run: Run, triangles: int, name: str) -> None:
    """Measures Fig. 11, left: one smooth shape, r = 4 %."""
    with run.part(name):
        run.measured[name] = against_baseline(run, torus(run, triangles), 0.04, ("fitted", "max"))


def radius(run: Run, triangles: int = 600_000, radii: tuple[float, float] = (0.01, 0.08)) -> None:
    """Measures Fig. 11, right: the radius grows eight times."""
    with run.part("radius"):
        arrays = torus(run, triangles)

        bench = run.bench
        mesh, _ = bench.mesh(arrays, Options(radius=radii[0]))
        with mesh:
            chosen = {
                name + label: Options(radius=fraction, samples=samples)
                for label, samples in (("", 256), ("_32_samples", 32))
                for name, fraction in zip(("small", "large"), radii, strict=True)
            }
            found = in_turns({name: partial(bench.frame, mesh, arrays, one, repeats=1) for name, one in chosen.items()})
        run.measured["radius"] = found | {"triangles": len(arrays.triangle_corners)}


def in_turns(frames: dict[str, Callable[[], dict]], turns: int = 2) -> dict[str, dict]:
    """The fastest frame of each name, without its values."""
    taken = [{name: frame() for name, frame in frames.items()} for _ in range(turns)]
    best = {name: timing.fastest([one[name] for one in taken]) for name in frames}
    return {name: {key: value for key, value in frame.items() if key != "values"} for name, frame in best.items()}


def bunny(run: Run) -> MeshArrays | None:
    """Measures a scan as users have it: the whole frame at r = 2 %."""
    with run.part("bunny"):
        arrays, sentence = meshes.with_charts("stanford-bunny")
        if arrays is None:
            raise MissingError(sentence)
        run.measured["bunny"] = against_baseline(run, arrays, 0.02, ("fitted", "max"))
        return arrays
    return None


def together(run: Run) -> None:
    """Measures several descriptors from one sampling, and three radii of one frame."""
    with run.part("together"):
        arrays = torus(run, 70_000)
        rows = bridge.descriptors()
        names = {
            "one": (NAME,),
            "eight": EIGHT,
            "sixteen": tuple(row.name for row in rows if not row.map_degree),
            "twenty": tuple(row.name for row in rows),
        }

        options, bench = Options(radius=THREE_RADII[1]), run.bench
        mesh, _ = bench.mesh(arrays, options)
        with mesh:
            frames = {name: partial(bench.frame, mesh, arrays, options, some, 1) for name, some in names.items()}
            frames["three_radii"] = partial(three_radii, mesh, arrays, options)
            run.measured["together"] = in_turns(frames, 3)


def three_radii(mesh: bridge.Mesh, arrays: MeshArrays, options: Options) -> dict[str, float]:
    """Measures a frame at three radii, as job.run_radii computes them; the faster of two."""
    taken = []
    for turn in (1, 2):
        start = time.perf_counter()
        mesh.set_positions(timing.positions_of(arrays, turn))
        for fraction in THREE_RADII:
            with mesh.compute((NAME,), replace(options, radius=fraction)) as found:
                found.values(NAME)
        taken.append(time.perf_counter() - start)
    return {"seconds": min(taken)}


def memory(run: Run, triangles: int = 1_000_000) -> None:
    """Measures the memory of a mesh and a frame."""
    alone(run, "memory", triangles)


def first_bake(run: Run, triangles: int = 70_000) -> None:
    """Measures the first bake of a process and later ones."""
    alone(run, "first_bake", triangles)


def alone(run: Run, measure: str, triangles: int) -> None:
    """Measures in a process of its own."""
    with run.part(measure):
        run.measured[measure] = timing.in_a_process_of_its_own(measure, int(run.scale * triangles))


def blender(run: Run, arrays: MeshArrays | None) -> None:
    """Measures Python's overhead and Dirty Vertex Colors in a process of their own."""
    with run.part("python", "dirty"):
        given = torus(run, 70_000) if arrays is None else arrays
        path = run.folder / "blender.npz"
        corners = given.triangle_corners.ravel()
        vertices, uvs = given.corner_vertices[corners], given.corner_uvs[corners]
        np.savez(path, positions=given.positions, corner_vertices=vertices, corner_uvs=uvs)
        words = [sys.executable, str(HERE / "blender_times.py"), str(path)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or ["no output"])[-1]
            raise MissingError(f"Blender's Python module bpy cannot be used: {last}")
        found = json.loads(done.stdout.strip().splitlines()[-1])
        run.measured["python"] = found
        run.measured.setdefault("peers", {})
        if arrays is not None:
            label = f"Dirty Vertex Colors of Blender {found['blender']}"
            run.measured["peers"]["dirty"] = {"label": label, "seconds": found["dirty_seconds"]}
        else:
            run.reasons["dirty"] = "There is no bunny to measure it on."


def common_error(
    found: programs.Values, truth: programs.Values, radius: float, either_sign: bool = False
) -> float | None:
    """Mean %AE at the vertices that both have; None if these are too few."""
    _, here, there = np.intersect1d(found.vertices, truth.vertices, return_indices=True)
    if len(here) < FEWEST_IN_COMMON:
        return None
    expected = truth.values[there]
    values = peers.with_sign(found.values[here], expected) if either_sign else found.values[here]
    return timing.percent_error(values, expected, radius)
