"""Builds the native programs of the benchmarks if they are missing, runs them, and reads what they print."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from paradesc.bridge import MeshArrays

ROOT = Path(__file__).resolve().parents[2]
OBJECT_SPACE, CGAL = "paradesc_object_space", "paradesc_cgal_curvature"
# The requirements of a program beyond those of the library.
NEEDS = {CGAL: "it needs CGAL 6: bash tests/bench/cgal.sh"}


class MissingError(Exception):
    """A sentence about what cannot be measured here."""


@dataclass
class Values:
    """The values of one method at some vertices."""

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


def printed(build: Path, name: str, words: list[str]) -> str:
    """The output of a program; raises MissingError with its complaint."""
    done = subprocess.run([str(program(build, name)), *words], capture_output=True, text=True, check=False)
    if done.returncode:
        raise MissingError(f"{name}: {done.stderr.strip()}")
    return done.stdout


def read_values(path: Path) -> Values:
    """Reads a file of paradesc_object_space."""
    data = path.read_bytes()
    count = int(np.frombuffer(data, np.int32, 1)[0])
    return Values(np.frombuffer(data, np.int32, count, 4), np.frombuffer(data, np.float32, count, 4 + 4 * count))
