"""Measures frames through the Python bridge: seconds by stage, error against the reference, memory."""

import json
import os
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from paradesc.bridge import Context, Mesh, MeshArrays, Options, ParadescError
from paradesc.core import compare
from paradesc.core.job import registry_row

NAME = "mean_curvature"
STAGES = ("prepare", "evaluate", "total")
FEWEST = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
FIRST_FRAMES = 3  # of meshes made anew, if each takes no more than so many seconds
LONG = 4.0
LATER_BAKES = 4


class Bench:
    """An engine that is warmed up: its programs are compiled and its threads exist."""

    def __init__(self, backend: str = "cpu", threads: int = 0) -> None:
        self.context = Context(backend, threads=threads)
        self._warm: set[tuple] = set()

    def warm(self, names: tuple[str, ...], options: Options) -> None:
        """Compiles what these descriptors and options need, on another mesh."""
        key = (names, options.relocation, options.estimator, options.evaluate, options.precision, options.adaptive > 0)
        if key not in self._warm:
            with self.context.mesh(small_torus()) as mesh:
                mesh.compute(names, replace(options, radius=0.1, radius_unit="diagonal", buffer_size=256)).close()
            self._warm.add(key)

    def mesh(self, arrays: MeshArrays, options: Options) -> tuple[Mesh, dict[str, float]]:
        """The native mesh after its first frame, and the seconds of everything that later frames need not do again, as
        the least of several meshes."""
        self.warm((NAME,), options)
        once: dict[str, float] = {}
        for turn in range(FIRST_FRAMES):
            start = time.perf_counter()
            mesh = self.context.mesh(arrays)
            made = time.perf_counter() - start
            first = timed(mesh, arrays.positions, (NAME,), options)["seconds"]
            once = {
                "mesh": min(made, once.get("mesh", made)),
                "first_frame": min(first, once.get("first_frame", first)),
            }
            if turn == FIRST_FRAMES - 1 or made + first > LONG:
                break
            mesh.close()
        return mesh, once

    def frame(
        self, mesh: Mesh, arrays: MeshArrays, options: Options, names: tuple[str, ...] = (NAME,), repeats: int = 2
    ) -> dict:
        """The fastest of two frames a repeat, from positions to arrays; "values" are those of the mesh itself."""
        self.warm(names, options)
        best: dict = {}
        for turn in range(1, 2 * repeats + 1):
            one = timed(mesh, positions_of(arrays, turn), names, options)
            if not best or one["seconds"] < best["seconds"]:
                best |= {key: value for key, value in one.items() if key != "values"}
            if turn % 2 == 0:
                best["values"] = one["values"]
        return best

    def cheapest(self, mesh: Mesh, arrays: MeshArrays, options: Options, truth: object, allowed: float) -> Options:
        """The fewest samples whose mean error in percent at some vertices (Values) is small enough."""
        tries = [replace(options, samples=samples) for samples in FEWEST]
        good = (tried for tried in tries[:-1] if error_of(mesh, arrays, tried, truth) <= allowed)
        return next(good, tries[-1])


def positions_of(arrays: MeshArrays, turn: int) -> np.ndarray:
    """(n, 3) the mesh's positions in even turns, others in odd ones, because a mesh that stays is not baked again."""
    return arrays.positions if turn % 2 == 0 else arrays.positions * np.float32(1 + 1e-5)


def small_torus() -> MeshArrays:
    """A mesh to warm up the device with."""
    import surfaces

    return surfaces.torus(600).arrays


def timed(mesh: Mesh, positions: np.ndarray, names: tuple[str, ...], options: Options) -> dict:
    """Times one frame: upload, compute, results in numpy. Seconds by the clock, of all cores, and by stage."""
    start, cpu = time.perf_counter(), time.process_time()
    mesh.set_positions(positions)
    with mesh.compute(names, options) as field:
        values = {name: field.values(name) for name in names}
        seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - cpu
        report = field.report()
    stages = {f"seconds_{stage}": report[f"seconds_{stage}"] for stage in STAGES}
    return {
        "seconds": seconds,
        "cpu_seconds": cpu_seconds,
        **stages,
        "samples": options.samples,
        "buffer_size": options.buffer_size,
        "radius": report["radius"],
        "radius_in_texels": report["radius_in_texels"],
        "buffer_megabytes": report["buffer_megabytes"],
        "values": values,
    }


def percent_error(values: np.ndarray, truth: np.ndarray, radius: float, name: str = NAME) -> float:
    """Mean %AE of a descriptor, (n,) each, by the definition in compare.py."""
    everywhere = np.ones(len(truth), bool)
    found = compare.percent_errors(values, truth, everywhere, registry_row(name), radius)
    return float(np.nanmean(found.percent))


def error_of(mesh: Mesh, arrays: MeshArrays, options: Options, truth: object) -> float:
    """Mean %AE at the vertices of the truth (Values)."""
    one = timed(mesh, arrays.positions, (NAME,), options)
    return percent_error(one["values"][NAME][truth.vertices], truth.values, one["radius"])


def with_error(frame: dict, truth: object) -> dict:
    """The frame with its error in place of its values."""
    values = frame.pop("values")[NAME]
    return frame | {"error": percent_error(values[truth.vertices], truth.values, frame["radius"])}


def fastest(frames: list[dict]) -> dict:
    """The frame that took the least time."""
    return min(frames, key=lambda frame: frame["seconds"])


# ---- In processes of their own


def status_bytes(name: str) -> int:
    """A line of /proc/self/status: VmHWM is the peak, VmRSS what is in memory now."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(name))
    return int(line.split()[1]) * 1024


def resident() -> int:
    """Bytes in memory; the peak is counted from here if the system allows that."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return status_bytes("VmRSS")


def measure_memory(triangles: int) -> dict[str, float]:
    """Bytes that a mesh and one frame add at most to a process that has its arrays and an engine."""
    import surfaces

    arrays = surfaces.torus(triangles // 2, charts=2).arrays
    bench, options = Bench(), Options()
    bench.warm((NAME,), options)
    before = resident()
    with bench.context.mesh(arrays) as mesh:
        created = status_bytes("VmHWM")
        timed(mesh, arrays.positions, (NAME,), options)
    parts = (arrays.positions, arrays.corner_vertices, arrays.triangle_corners, arrays.corner_uvs)
    return {
        "input_bytes": sum(part.nbytes for part in parts),
        "mesh_bytes": created - before,
        "peak_bytes": status_bytes("VmHWM") - before,
    }


def measure_first_bake(triangles: int) -> dict[str, float]:
    """Seconds from arrays to values: the first time in a process, library and engine included, and later."""
    import surfaces

    arrays = surfaces.torus(triangles // 2).arrays
    taken = []
    for _ in range(LATER_BAKES + 1):
        start = time.perf_counter()
        with Bench().context as context, context.mesh(arrays) as mesh:
            timed(mesh, arrays.positions, (NAME,), Options())
        taken.append(time.perf_counter() - start)
    return {"first": taken[0], "later": min(taken[1:])}


MEASURES = {"memory": measure_memory, "first_bake": measure_first_bake}


def in_a_process_of_its_own(measure: str, triangles: int) -> dict[str, float]:
    """Runs one of MEASURES there."""
    words = [sys.executable, __file__, measure, str(triangles)]
    paths = os.pathsep.join(path for path in sys.path if path)
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=os.environ | {"PYTHONPATH": paths})
    if done.returncode:
        raise ParadescError(0, (done.stderr.strip().splitlines() or ["no output"])[-1])
    return json.loads(done.stdout.splitlines()[-1])


if __name__ == "__main__":
    sys.stdout.write(json.dumps(MEASURES[sys.argv[1]](int(sys.argv[2]))) + "\n")
