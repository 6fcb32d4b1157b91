"""Compares sampling choices on real meshes, as a table of error, coverage and seconds.

PYTHONPATH=addon python tests/bench/sampling_choices.py choices spot.obj
PYTHONPATH=addon python tests/bench/sampling_choices.py jumps spot.obj bob.obj
PYTHONPATH=addon python tests/bench/sampling_choices.py fragments stanford-bunny.obj \\
    --charts 500 --radius 0.1 0.16 --samples 64 --no-errors
"""

import argparse
import sys
import time
from dataclasses import replace
from heapq import heappop, heappush
from pathlib import Path

import numpy as np

from paradesc.bridge import Context, MeshArrays, Options

DESCRIPTORS = ["mean_curvature", "gaussian_curvature", "local_bending_energy", "sphere_volume_normalized"]
PAPER = {"relocation": "paper", "max_jumps": 1}
AS_PRINTED = PAPER | {"pattern": "stratified", "estimator": "integral", "variance_reduction": "none"}
CHOICES = {
    "affine": {"relocation": "affine"},
    "affine, stratified": {"relocation": "affine", "pattern": "stratified"},
    "affine, directional": {"relocation": "affine", "ellipse": "directional"},
    "paper, 1 jump": PAPER,
    "paper, 8 jumps": PAPER | {"max_jumps": 8},
    "paper, 1 jump, stratified, integral, plain": AS_PRINTED,
    "paper, 1 jump, the same, chords": AS_PRINTED | {"geodesic": "chords"},
}


def read_obj(path: Path) -> MeshArrays:
    """Reads the triangles (fans of larger faces) and UVs of a Wavefront file."""
    points, uvs, corners, corner_uvs = [], [], [], []
    for line in path.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            points.append([float(word) for word in words[:3]])
        elif kind == "vt":
            uvs.append([float(word) for word in words[:2]])
        elif kind == "f":
            face = [word.split("/") for word in words]
            for i in range(1, len(face) - 1):
                for corner in (face[0], face[i], face[i + 1]):
                    corners.append(int(corner[0]) - 1)
                    corner_uvs.append(int(corner[1]) - 1 if len(corner) > 1 and corner[1] else -1)
    placed = np.asarray(uvs, np.float32)[corner_uvs] if uvs else None
    return MeshArrays(
        np.asarray(points, np.float32),
        np.asarray(corners, np.int32),
        np.arange(len(corners), dtype=np.int32).reshape(-1, 3),
        placed,
    )


def triangles_beside(faces: np.ndarray) -> list[list[int]]:
    """For each triangle, those that share an edge with it."""
    beside: list[list[int]] = [[] for _ in faces]
    sides: dict[tuple[int, int], int] = {}
    for triangle, face in enumerate(faces.tolist()):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            other = sides.setdefault((min(a, b), max(a, b)), triangle)
            if other != triangle:
                beside[triangle].append(other)
                beside[other].append(triangle)
    return beside


def grow_charts(faces: np.ndarray, points: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gives each triangle's chart and the charts' normals. Charts grow by distance from triangles drawn at random, and
    none tilts by more than 60 degrees."""
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    middles = corners.mean(axis=1)
    beside = triangles_beside(faces)
    chart = np.full(len(faces), -1)
    seeds = np.random.default_rng(1).permutation(len(faces)).tolist()
    chosen: list[int] = []
    queue: list[tuple[float, int, int]] = []
    while seeds and len(chosen) < count:
        chosen.append(seeds.pop())
        heappush(queue, (0.0, chosen[-1], len(chosen) - 1))
    while True:
        while queue:
            away, triangle, number = heappop(queue)
            if chart[triangle] >= 0 or normals[triangle] @ normals[chosen[number]] < 0.5:
                continue
            chart[triangle] = number
            for other in beside[triangle]:
                if chart[other] < 0:
                    heappush(queue, (away + float(np.linalg.norm(middles[other] - middles[triangle])), other, number))
        rest = np.flatnonzero(chart < 0)
        if not len(rest):
            return chart, normals[chosen]
        chosen.append(int(rest[0]))
        queue.append((0.0, chosen[-1], len(chosen) - 1))


def fragment(mesh: MeshArrays, count: int) -> MeshArrays:
    """The same mesh with an atlas of `count` charts or more, each projected to the plane of its first triangle."""
    faces = mesh.corner_vertices[mesh.triangle_corners]
    chart, normals = grow_charts(faces, mesh.positions.astype(float), count)
    flat = np.zeros((len(faces), 3, 2))
    sizes = np.zeros((len(normals), 2))
    for number, normal in enumerate(normals):
        across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        across /= np.linalg.norm(across)
        own = chart == number
        flat[own] = mesh.positions[faces[own]] @ np.stack([across, np.cross(normal, across)], axis=1)
        flat[own] -= flat[own].min(axis=(0, 1))
        sizes[number] = flat[own].max(axis=(0, 1))
    gap = 0.1 * np.sqrt(sizes.prod(axis=1)).mean()
    side = np.sqrt((sizes + gap).prod(axis=1).sum()) * 1.08
    x = y = shelf = 0.0
    for number in np.argsort(-sizes[:, 1]):
        if x + sizes[number, 0] + gap > side:
            x, y, shelf = 0.0, y + shelf, 0.0
        flat[chart == number] += (x + gap / 2, y + gap / 2)
        x += sizes[number, 0] + gap
        shelf = max(shelf, sizes[number, 1] + gap)
    flat /= max(side, y + shelf)
    return replace(mesh, corner_uvs=flat.reshape(-1, 2).astype(np.float32))


def percent_error(values: np.ndarray, expected: np.ndarray) -> float:
    """Mean %AE over the vertices where both are defined."""
    defined = np.isfinite(values) & np.isfinite(expected)
    low, high = np.percentile(expected[defined], [2.5, 97.5])
    return float(100 * np.abs(values - expected)[defined].mean() / (high - low))


def measure(context: Context, mesh: MeshArrays, options: Options, expected: dict[str, np.ndarray]) -> str:
    """Measures one row: coverage, its least, vertices below 0.9, seconds of evaluation, and errors against expected."""
    with context.mesh(mesh) as loaded, loaded.compute(DESCRIPTORS, options) as field:
        report, coverage = field.report(), field.values("coverage")
        found = f"{np.nanmean(coverage):.4f} | {np.nanmin(coverage):.3f} | {(coverage < 0.9).sum()}"
        row = f"{found} | {report['seconds_evaluate']:.2f}"
        return row + "".join(f" | {percent_error(field.values(name), values):.3f}" for name, values in expected.items())


def reference(mesh: MeshArrays, options: Options) -> dict[str, np.ndarray]:
    """The reference's values by descriptor."""
    with Context("reference") as context, context.mesh(mesh) as loaded, loaded.compute(DESCRIPTORS, options) as field:
        return {name: field.values(name) for name in DESCRIPTORS}


def print_rows(mesh: MeshArrays, rows: dict[str, Options], context: Context, with_errors: bool) -> None:
    """Prints a row for each of the options, with errors against the reference if asked."""
    known: dict[str, dict[str, np.ndarray]] = {}
    for name, options in rows.items():
        if with_errors and options.estimator not in known:
            known[options.estimator] = reference(mesh, options_of_reference(options))
        line = measure(context, mesh, options, known.get(options.estimator, {}))
        sys.stdout.write(f"| {name} | {line} |\n")
        sys.stdout.flush()


def options_of_reference(options: Options) -> Options:
    """Those of the options that the reference reads."""
    return Options(radius=options.radius, estimator=options.estimator)


def main() -> None:
    """Reads the command line and prints a table for each mesh and radius."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", choices=["choices", "jumps", "fragments"])
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--radius", nargs="+", type=float, default=[0.02])
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--buffer-size", type=int, default=1024)
    parser.add_argument("--charts", type=int, default=0, help="cut the mesh into so many charts first")
    parser.add_argument("--no-errors", action="store_true", help="leave out the oracle, which is slow at large radii")
    parser.add_argument("--backend", default="software")
    arguments = parser.parse_args()
    with Context(arguments.backend) as context:
        sys.stdout.write(f"{context.device}, {time.strftime('%Y-%m-%d')}\n")
        for path in arguments.meshes:
            mesh = read_obj(path)
            if arguments.charts:
                mesh = fragment(mesh, arguments.charts)
            for radius in arguments.radius:
                base = Options(radius=radius, samples=arguments.samples, buffer_size=arguments.buffer_size)
                rows = {name: replace(base, **choice) for name, choice in CHOICES.items()}
                if arguments.table == "jumps":
                    rows = {}
                    for jumps in (0, 1, 2, 4, 8, 16):
                        rows[f"affine, {jumps} jumps"] = replace(base, relocation="affine", max_jumps=jumps)
                elif arguments.table == "fragments":
                    rows = {name: rows[name] for name in ("affine", "paper, 1 jump")}
                with context.mesh(mesh) as loaded:
                    charts = loaded.report()["charts"]
                sys.stdout.write(f"\n{path.stem}, {charts} charts, radius {radius}\n")
                print_rows(mesh, rows, context, not arguments.no_errors)


if __name__ == "__main__":
    main()
