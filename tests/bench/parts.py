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
from pathlib import Path

import meshes
import numpy as np
import peers
import programs
import surfaces
import timing
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
AT_TEXELS = {"evaluate": "texel", "texels": 128, "buffer_size": 512}  # the paper's way, for many vertices
PEER_MESH = 12000  # vertices of the torus on which errors against the closed form are taken


@dataclass
class Run:
    """What all parts share, and what they have found."""

    bench: timing.Bench
    build: Path
    folder: Path
    backend: str
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
    """The device and a folder for files."""
    with tempfile.TemporaryDirectory() as folder:
        run = Run(timing.Bench(arguments.backend), arguments.build, Path(folder), arguments.backend)
        run.scale = arguments.scale
        run.baseline_seconds *= min(1.0, run.scale)
        yield run


def against_baseline(
    run: Run, arrays: MeshArrays, fraction: float, normals: tuple[str, ...] = ("fitted",), texels: bool = False
) -> dict:
    """Measures the baseline and our frames: with the fewest samples, with 256, at texels; and their errors."""
    path = programs.write_mesh(run.folder / "mesh", arrays)
    radius = fraction * meshes.diagonal(arrays)
    taken, found = programs.object_space(run.build, path, radius, run.baseline_seconds, run.reference_points)
    truth = found["reference"]
    options = Options(radius=fraction)
    mesh, once = run.bench.mesh(arrays, options)
    with mesh:
        big = len(arrays.triangle_corners) > 500_000
        result = {
            "triangles": len(arrays.triangle_corners),
            "vertices": len(arrays.positions),
            "radius": fraction,
            "once": once,
            "baseline": taken["baseline"] | {"error": common_error(found["baseline"], truth, radius)},
            "reference_points": len(truth.vertices),
            "at_256": timing.with_error(run.bench.frame(mesh, arrays, options, repeats=1 if big else 2), truth),
        }
    # This is another mesh, because small buffers may have laid the first one out afresh.
    mesh, _ = run.bench.mesh(arrays, replace(options, buffer_size=timing.SMALLER[0]))
    with mesh:
        fewest = timing.cheapest(mesh, arrays, options, truth)
        result["fewest"] = timing.with_error(run.bench.frame(mesh, arrays, fewest, repeats=2 if big else 4), truth)
        if "max" in normals:
            cheap = replace(fewest, normals="max")
            result["max_normals"] = timing.with_error(
                run.bench.frame(mesh, arrays, cheap, repeats=1 if big else 2), truth
            )
            paper = timing.cheapest(mesh, arrays, replace(options, normals="max", **AT_TEXELS), truth)
            result["at_texels"] = timing.with_error(run.bench.frame(mesh, arrays, paper, repeats=3), truth)
        if texels:
            chosen = timing.cheapest_texels(mesh, arrays, options, truth)
            result["at_fewest_texels"] = timing.with_error(run.bench.frame(mesh, arrays, chosen, repeats=2), truth) | {
                "texels": chosen.texels
            }
    return result


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
        options = Options(radius=radii[0])
        mesh, _ = run.bench.mesh(arrays, options)
        with mesh:
            found = {"triangles": len(arrays.triangle_corners)}
            for label, samples in (("", 256), ("_32_samples", 32)):
                for name, fraction in zip(("small", "large"), radii, strict=True):
                    chosen = replace(options, radius=fraction, samples=samples)
                    frame = run.bench.frame(mesh, arrays, chosen, repeats=1)
                    frame.pop("values")
                    found[name + label] = frame
        run.measured["radius"] = found


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
    """Measures eight descriptors from one sampling, and three radii of one frame."""
    with run.part("together"):
        arrays = torus(run, 70_000)
        options = Options(radius=THREE_RADII[1])
        mesh, _ = run.bench.mesh(arrays, options)
        with mesh:
            one = run.bench.frame(mesh, arrays, options)
            eight = run.bench.frame(mesh, arrays, options, EIGHT)
            three = {"seconds": fastest(lambda turn: three_radii(mesh, timing.positions_of(arrays, turn), options))}
        del one["values"], eight["values"]
        run.measured["together"] = {"one": one, "eight": eight, "three_radii": three}


def three_radii(mesh: bridge.Mesh, positions: np.ndarray, options: Options) -> None:
    """Measures one frame at three radii, as job.run_radii computes them."""
    mesh.set_positions(positions)
    for fraction in THREE_RADII:
        with mesh.compute((NAME,), replace(options, radius=fraction)) as found:
            found.values(NAME)


def fastest(action: Callable[[int], object], times: int = 5) -> float:
    """Seconds of the fastest of several turns; the action gets the number of its turn."""
    taken = []
    for turn in range(1, times + 1):
        start = time.perf_counter()
        action(turn)
        taken.append(time.perf_counter() - start)
    return min(taken)


def gather(run: Run, name: str, charts: int) -> None:
    """Measures an evaluation with 256 samples and the bare fetches of as many, at the same vertices and layout."""
    with run.part(name):
        arrays = torus(run, 100_000, charts)
        options = Options(radius=0.02)
        mesh, _ = run.bench.mesh(arrays, options)
        with mesh:
            frame = run.bench.frame(mesh, arrays, options)
            del frame["values"]
            layout = replace(arrays, corner_uvs=mesh.layout().reshape(-1, 2))
            affine = run.bench.frame(mesh, arrays, replace(options, relocation="affine"), repeats=1)
            del affine["values"]
            count = mesh.report()["charts"]
        path = programs.write_mesh(run.folder / "layout", layout)
        gpu = run.bench.context.backend == "gpu"
        bare = programs.gather(run.build, path, frame["radius_in_texels"], options.samples, options.buffer_size, gpu)
        run.measured[name] = {"charts": count, "evaluate": frame, "bare": bare, "affine": affine}


def memory(run: Run, triangles: int = 1_000_000) -> None:
    """Measures the memory of a mesh and a frame in a process of their own."""
    with run.part("memory"):
        run.measured["memory"] = timing.memory_of_its_own(int(run.scale * triangles), run.backend)


def blender(run: Run, arrays: MeshArrays | None) -> None:
    """Measures Python's overhead and Dirty Vertex Colors in a process of their own."""
    with run.part("python", "dirty"):
        given = torus(run, 70_000) if arrays is None else arrays
        path = run.folder / "blender.npz"
        corners = given.triangle_corners.ravel()
        vertices, uvs = given.corner_vertices[corners], given.corner_uvs[corners]
        np.savez(path, positions=given.positions, corner_vertices=vertices, corner_uvs=uvs)
        words = [sys.executable, str(HERE / "blender_times.py"), str(path), run.backend]
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


def others(run: Run, arrays: MeshArrays | None) -> None:
    """Measures every peer: time and error on the bunny, and the error against the closed form on a torus."""
    if arrays is None:
        run.reasons |= dict.fromkeys(peers.PEERS, run.reasons["bunny"])
        return
    surface = surfaces.torus(PEER_MESH)
    radius, torus_radius = 0.02 * meshes.diagonal(arrays), 0.02 * surface.diagonal
    path = programs.write_mesh(run.folder / "peers", arrays)
    with run.part("truth of the peers", *peers.PEERS):
        truth = programs.object_space(run.build, path, radius, points=2000, methods="reference")[1]["reference"]
    if "truth of the peers" in run.reasons:
        return
    closed = programs.Values(np.arange(len(surface.mean)), surface.mean)
    found = run.measured.setdefault("peers", {})
    for name, (label, package, function) in peers.PEERS.items():
        with run.part(name):
            try:
                here, there = function(arrays, radius), function(surface.arrays, torus_radius)
            except ImportError:
                raise MissingError(f"{package} is not installed ({peers.INSTALL}).") from None
            except Exception as error:  # noqa: BLE001 (a peer's own failure must not end the run)
                raise MissingError(f"{label} failed: {error}") from None
            found[name] = {
                "label": label,
                "seconds": here.seconds,
                "note": here.note,
                "error": peer_error(here, truth, radius),
                "error_closed": peer_error(there, closed, torus_radius),
            }
    ours(run, surface, closed)


def ours(run: Run, surface: surfaces.Surface, closed: programs.Values) -> None:
    """Measures the same errors for us and for the baseline."""
    with run.part("errors on the torus"):
        options = Options(radius=0.02)
        mesh, _ = run.bench.mesh(surface.arrays, options)
        with mesh:
            errors = {}
            for name in ("at_256", "fewest"):
                chosen = {key: run.measured["bunny"][name][key] for key in ("samples", "buffer_size")}
                frame = run.bench.frame(mesh, surface.arrays, replace(options, **chosen), repeats=1)
                errors[name] = timing.with_error(frame, closed)["error"]
        path = programs.write_mesh(run.folder / "peers", surface.arrays)
        found = programs.object_space(run.build, path, 0.02 * surface.diagonal, methods="baseline")[1]["baseline"]
        truth = closed.values[found.vertices]
        errors["baseline"] = timing.percent_error(found.values, truth, 0.02 * surface.diagonal)
        run.measured["errors_closed"] = errors


def peer_error(found: peers.Found, truth: programs.Values, radius: float) -> float | None:
    """Mean %AE at the vertices that both have; None if a peer has no H."""
    if found.values is None:
        return None
    vertices = np.arange(len(found.values)) if found.vertices is None else found.vertices
    return common_error(programs.Values(vertices, found.values), truth, radius, either_sign=True)


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
