"""Builds the native programs of the benchmarks if they are missing, runs them, and reads what they print."""

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from paradesc.bridge import MeshArrays

ROOT = Path(__file__).resolve().parents[2]
OBJECT_SPACE, GATHER, CGAL = "paradesc_object_space", "paradesc_gather_bench", "paradesc_cgal_curvature"
FRAME_HOST = "paradesc_frame_host"
# What a program needs beyond the library's own.
NEEDS = {GATHER: "it needs libbenchmark-dev", CGAL: "it needs CGAL 6: bash tests/bench/cgal.sh"}


class MissingError(Exception):
    """A sentence about what cannot be measured here."""


@dataclass
class Values:
    """What one method found at some vertices."""

    vertices: np.ndarray  # (n,) int32
    values: np.ndarray  # (n,) float32


def write_mesh(path: Path, arrays: MeshArrays) -> Path:
    """Writes the file that mesh_file.h reads: three corners for each triangle, one after the other."""
    corners = arrays.triangle_corners.ravel()
    vertices = arrays.corner_vertices[corners]
    uvs = np.zeros((len(corners), 2), np.float32) if arrays.corner_uvs is None else arrays.corner_uvs[corners]
    counts = np.array([len(arrays.positions), len(vertices)], np.int32)
    path.write_bytes(b"".join(part.tobytes() for part in (counts, arrays.positions, vertices, uvs)))
    return path


def program(build: Path, name: str) -> Path:
    """The program in a build folder, built if it is not there; MissingError says what stands in the way."""
    path = build / name
    if not path.is_file():
        steps = [
            ["cmake", "-S", str(ROOT), "-B", str(build), "-DPARADESC_BENCHMARKS=ON"],
            ["cmake", "--build", str(build), "--target", name],
        ]
        for step in steps:
            try:
                done = subprocess.run(step, capture_output=True, text=True, check=False)
            except OSError:
                raise MissingError(f"{name} is not built, and there is no CMake to build it.") from None
            if done.returncode:
                hint = f" ({NEEDS[name]})" if name in NEEDS else ""
                raise MissingError(f'{name} could not be built{hint}; see "{" ".join(step)}".')
    return path


def object_space(
    build: Path,
    mesh: Path,
    radius: float,
    seconds: float = 0.0,
    points: int = 0,
    methods: str = "both",
    normals: str = "fitted",
) -> tuple[dict[str, dict], dict[str, Values]]:
    """Times and values of the baseline and the reference, by method; radius in units of the positions."""
    words = [methods, str(mesh), repr(radius), "normals", normals]
    words += ["seconds", str(seconds), "points", str(points)]
    files = {method: mesh.with_suffix(f".{method}") for method in ("baseline", "reference")}
    for method, file in files.items():
        words += [f"{method}_values", str(file)]
    taken = {row.pop("method"): row for row in map(json.loads, printed(build, OBJECT_SPACE, words).splitlines())}
    return taken, {method: read_values(files[method]) for method in taken}


def cgal(build: Path, mesh: Path, radius: float, *kind: str) -> tuple[float, Values]:
    """Seconds and H of CGAL's interpolated corrected curvatures; with the word gaussian K."""
    file = mesh.with_suffix(".values")
    seconds = float(printed(build, CGAL, [str(mesh), repr(radius), str(file), *kind]))
    return seconds, read_values(file)


def frame_host(build: Path, mesh: Path, fraction: float, gpu: bool) -> dict:
    """What a frame in texture space asks of the processor; fraction: the radius as a part of the diagonal."""
    return json.loads(printed(build, FRAME_HOST, [str(mesh), repr(fraction), "gpu" if gpu else "software"]))


def printed(build: Path, name: str, words: list[str]) -> str:
    """What a program prints; MissingError says what it complains of."""
    done = subprocess.run([str(program(build, name)), *words], capture_output=True, text=True, check=False)
    if done.returncode:
        raise MissingError(f"{name}: {done.stderr.strip()}")
    return done.stdout


def read_values(path: Path) -> Values:
    """Reads a file of paradesc_object_space."""
    data = path.read_bytes()
    count = int(np.frombuffer(data, np.int32, 1)[0])
    return Values(np.frombuffer(data, np.int32, count, 4), np.frombuffer(data, np.float32, count, 4 + 4 * count))


def gather(build: Path, mesh: Path, texels: float, samples: int, size: int, gpu: bool) -> dict[str, dict]:
    """Seconds of the bare fetches at a mesh's vertices, by the way of fetching; texels: how many the radius spans."""
    setting = {"MESH": mesh, "TEXELS": texels, "SAMPLES": samples, "SIZE": size} | ({"GPU": 1} if gpu else {})
    environment = os.environ | {f"PARADESC_BENCH_{name}": str(value) for name, value in setting.items()}
    out = mesh.with_suffix(".gather")
    words = [program(build, GATHER), f"--benchmark_out={out}", "--benchmark_min_time=0.2", "--benchmark_repetitions=3"]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise MissingError(f"{GATHER}: {done.stderr.strip()}")
    found: dict[str, dict] = {}
    for row in json.loads(out.read_text())["benchmarks"]:
        if row.get("error_occurred"):
            raise MissingError(f"{GATHER}: {row['error_message']}")
        if row["run_type"] != "iteration":
            continue
        kept = found.setdefault(row["name"].split("/")[0].removeprefix("gather_by_"), {"seconds": np.inf})
        kept["seconds"] = min(kept["seconds"], 1e-3 * row["real_time"])
        if "gpu_ms" in row:
            kept["gpu_seconds"] = min(kept.get("gpu_seconds", np.inf), 1e-3 * row["gpu_ms"])
    return found
