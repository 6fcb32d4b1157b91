"""Measures whether preprocessing is worth keeping in a .blend: seconds to make it again, and to load and check it.

    cmake -S . -B build -DPARADESC_BENCHMARKS=ON && ninja -C build
    PYTHONPATH=addon python tests/bench/preprocessing_cache.py --bench build/paradesc_preprocessing_bench --json FILE
    PYTHONPATH=addon python tests/bench/preprocessing_cache.py --bench … --mesh human.obj

It needs Blender's module bpy. Every time is the least of several, by the clock and of all cores (which other programs
on the machine disturb less). The steps are those of preprocessing_bench.cpp. Peak memory is that of a process of its
own that reads the mesh and computes once.
"""

import argparse
import hashlib
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
from sampling_choices import read_obj
from timing import resident, status_bytes

from paradesc.bridge import Context, MeshArrays, Options

# A file could keep these results of each step.
STEPS = {
    "half_edges": ["twin", "corner_point", "point_vertex", "point_half_edge", "vertex_point"],
    "charts": ["triangle_chart", "corner_wedge", "half_edge_border", "point_wedge"],
    "normal_rings": ["corner_fan", "fan_point", "ring_begin", "ring_point", "face_begin", "face", "own_faces"],
}
KEPT = [name for names in STEPS.values() for name in names]
REBUILT_ANYWAY = ["triangles", "border_grid"]
UNDER_SUSPICION = ["cut"]  # where texels are claimed twice, as they are at a million triangles
DOMAINS = {"POINT": "vertices", "CORNER": "loops", "FACE": "polygons"}


def torus(triangles: int, across: int = 10, around: int = 6) -> MeshArrays:
    """A torus of across × around charts with gutters, with about that many triangles."""
    columns, rows = (
        max(int(np.sqrt(triangles / 2 * ratio)) // part, 1) * part for ratio, part in ((5 / 3, across), (0.6, around))
    )
    u, v = (grid.ravel() for grid in np.meshgrid(np.arange(columns), np.arange(rows)))
    angle, tube = 2 * np.pi * u / columns, 2 * np.pi * v / rows
    width = 1 + 0.4 * np.cos(tube)
    positions = np.stack([width * np.cos(angle), width * np.sin(angle), 0.4 * np.sin(tube)], axis=1)
    steps = np.array([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]])
    cells = np.stack([u, v], axis=1)
    places = cells[:, None] + steps
    size = np.array([columns, rows])
    wrapped = places % size
    part = size // (across, around)
    chart = cells // part
    inside = (places - (chart * part)[:, None]) / part
    uvs = (chart[:, None] + 0.04 + 0.92 * inside) / (across, around)
    corners = (wrapped[..., 1] * columns + wrapped[..., 0]).ravel()
    return mesh_of(positions, corners, uvs.reshape(-1, 2))


def mesh_of(positions: np.ndarray, corners: np.ndarray, uvs: np.ndarray) -> MeshArrays:
    """A mesh with three corners for each triangle, one after the other."""
    faces = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    return MeshArrays(positions.astype(np.float32), corners.astype(np.int32), faces, uvs.astype(np.float32))


def subdivided(mesh: MeshArrays, triangles: int) -> MeshArrays:
    """Cuts each triangle into four at the middles of its edges, until there are that many."""
    while len(mesh.triangle_corners) < triangles:
        corners = mesh.corner_vertices[mesh.triangle_corners]
        ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1).astype(
            np.int64
        )
        edges, of_corner = np.unique(ends[:, 0] << 32 | ends[:, 1], return_inverse=True)
        middles = mesh.positions[edges >> 32] * 0.5 + mesh.positions[edges & 0xFFFFFFFF] * 0.5
        middle = len(mesh.positions) + of_corner.reshape(-1, 3)
        uvs = mesh.corner_uvs[mesh.triangle_corners]
        between = 0.5 * (uvs + np.roll(uvs, -1, axis=1))
        mesh = mesh_of(
            np.concatenate([mesh.positions, middles]),
            four_of(corners, middle).ravel(),
            four_of(uvs, between).reshape(-1, 2),
        )
    return mesh


def four_of(corner: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """(n, 4, 3, …) triangles: three at the corners and one between the middles; middle i follows corner i."""
    rows = [(corner[:, i], middle[:, i], middle[:, (i + 2) % 3]) for i in range(3)] + [
        tuple(middle[:, i] for i in range(3))
    ]
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


Seconds = dict[str, float]  # by the clock ("wall") and of all cores ("cpu")


def least(action: Callable[[], object], times: int = 3) -> Seconds:
    """The times of the fastest run."""
    wall, cpu = [], []
    for _ in range(times):
        start = time.perf_counter(), time.process_time()
        action()
        wall.append(time.perf_counter() - start[0])
        cpu.append(time.process_time() - start[1])
    return {"wall": min(wall), "cpu": min(cpu)}


def total(*seconds: Seconds) -> Seconds:
    """The sum of these times."""
    return {kind: sum(one[kind] for one in seconds) for kind in ("wall", "cpu")}


# ---- Making it again


def run_bench(
    program: Path, mesh: MeshArrays, folder: Path, repetitions: int
) -> tuple[dict[str, dict], dict[str, np.ndarray]]:
    """Seconds of each step as {"wall", "cpu"}, and the arrays that a file could keep."""
    path = folder / "mesh"
    counts = np.array([len(mesh.positions), len(mesh.corner_vertices)], np.int32)
    path.write_bytes(b"".join(a.tobytes() for a in (counts, mesh.positions, mesh.corner_vertices, mesh.corner_uvs)))
    environment = os.environ | {"PARADESC_BENCH_MESH": str(path)}
    subprocess.run([program], env=environment | {"PARADESC_BENCH_DUMP": str(folder)}, check=True)
    out = folder / "steps.json"
    options = [f"--benchmark_out={out}", "--benchmark_min_time=0.1", f"--benchmark_repetitions={repetitions}"]
    subprocess.run(
        [program, *options], env=environment, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    steps: dict[str, dict] = {}
    for row in json.loads(out.read_text())["benchmarks"]:
        if row["run_type"] != "iteration" or row.get("error_occurred"):
            continue
        step = steps.setdefault(row["name"].split("/")[0], {"wall": np.inf, "cpu": np.inf})
        step["wall"] = min(step["wall"], row["real_time"] * 1e-3)
        step["cpu"] = min(step["cpu"], row["cpu_time"] * 1e-3)
    return steps, {name: np.fromfile(folder / name, np.int32) for name in KEPT}


# ---- Keeping it


def measure_files(mesh: MeshArrays, kept: dict[str, np.ndarray], folder: Path) -> dict[str, dict[str, object]]:
    """Bytes and seconds of a .blend with and without the arrays, plain and compressed."""
    import bpy

    results = {}
    for compress in (False, True):
        for arrays in ({}, kept):
            bpy.ops.wm.read_factory_settings(use_empty=True)
            keep(arrays, make_object(mesh).data)
            name = f"{'kept' if arrays else 'bare'}, {'compressed' if compress else 'plain'}"
            path = folder / f"{name}.blend"
            save = least(
                lambda path=path, compress=compress: bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=compress),
                2,
            )
            load = least(lambda path=path: bpy.ops.wm.open_mainfile(filepath=str(path)))
            back: dict[str, np.ndarray] = {}
            read = least(lambda back=back, names=arrays: back.update(fetch(names)))
            for key, values in arrays.items():
                np.testing.assert_array_equal(back[key], values)
            results[name] = {"bytes": path.stat().st_size, "save": save, "load": load, "fetch": read}
    return results


def make_object(mesh: MeshArrays) -> object:
    """An object of the triangles and their UV map in the open file."""
    import bpy

    made = bpy.data.meshes.new("Bench")
    made.vertices.add(len(mesh.positions))
    made.vertices.foreach_set("co", mesh.positions.ravel())
    made.loops.add(len(mesh.corner_vertices))
    made.loops.foreach_set("vertex_index", mesh.corner_vertices)
    made.polygons.add(len(mesh.triangle_corners))
    made.polygons.foreach_set("loop_start", mesh.triangle_corners[:, 0].copy())
    made.update(calc_edges=True)
    made.uv_layers.new(do_init=False).uv.foreach_set("vector", mesh.corner_uvs.ravel())
    target = bpy.data.objects.new("Bench", made)
    bpy.context.scene.collection.objects.link(target)
    return target


def keep(arrays: dict[str, np.ndarray], mesh: object) -> None:
    """Stores arrays as attributes if a domain has that many elements, else as a custom property."""
    for name, values in arrays.items():
        domain = next((key for key, member in DOMAINS.items() if len(getattr(mesh, member)) == len(values)), None)
        if domain:
            mesh.attributes.new(f".hide_{name}", "INT", domain).data.foreach_set("value", values)
        else:
            mesh[name] = values


def fetch(names: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Reads the arrays from the open file's mesh."""
    import bpy

    mesh = bpy.data.meshes["Bench"]
    result = {}
    for name in names:
        attribute = mesh.attributes.get(f".hide_{name}")
        if attribute is None:
            result[name] = np.array(mesh[name], np.int32)
            continue
        result[name] = np.empty(len(attribute.data), np.int32)
        attribute.data.foreach_get("value", result[name])
    return result


def digest(mesh: MeshArrays, kept: dict[str, np.ndarray], kind: str) -> str:
    """A digest of the arrays and of all that they depend on, because the file may have been edited.

    Positions are part of that: triangles without area and vertices at one place depend on them.
    """
    found = hashlib.new(kind)
    for array in (mesh.positions, mesh.corner_vertices, mesh.triangle_corners, mesh.corner_uvs, *kept.values()):
        found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()


# ---- Memory


def measure_memory(path: Path) -> dict[str, float]:
    """Bytes that reading the mesh and one compute add to a process with its arrays and a device."""
    with np.load(path) as file:
        mesh = MeshArrays(*(file[name] for name in ("positions", "corners", "faces", "uvs")))
    with Context("software") as context:
        context.mesh(torus(1000)).compute(
            ["mean_curvature"], Options(samples=8)
        ).close()  # makes programs and the stacks of threads
        before = resident()
        start = time.perf_counter()
        native = context.mesh(mesh)
        create, created = time.perf_counter() - start, status_bytes("VmHWM")
        report = native.compute(["mean_curvature"], Options(samples=8)).report()
    given = sum(a.nbytes for a in (mesh.positions, mesh.corner_vertices, mesh.triangle_corners, mesh.corner_uvs))
    return {
        "input_bytes": given,
        "create_bytes": created - before,
        "compute_bytes": status_bytes("VmHWM") - before,
        "buffer_bytes": 1e6 * report["buffer_megabytes"],
        "create_seconds": create,
        **{name: report[name] for name in ("seconds_prepare", "seconds_bake", "seconds_evaluate", "seconds_total")},
    }


def memory_of_its_own(mesh: MeshArrays, folder: Path) -> dict[str, float]:
    """Runs measure_memory in a fresh process."""
    path = folder / "mesh.npz"
    np.savez(
        path, positions=mesh.positions, corners=mesh.corner_vertices, faces=mesh.triangle_corners, uvs=mesh.corner_uvs
    )
    done = subprocess.run([sys.executable, __file__, "--memory-of", path], check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


# ---- All of it


def processor() -> str:
    """The name of the processor, and how many there are."""
    names = [
        line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in line
    ]
    return f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores"


def measure(arguments: argparse.Namespace, mesh: MeshArrays, folder: Path) -> dict[str, object]:
    """Measures everything about one mesh."""
    steps, kept = run_bench(arguments.bench.resolve(), mesh, folder, arguments.repetitions)
    files = measure_files(mesh, kept, folder)
    million = 1e-6 * len(mesh.triangle_corners)
    checks = {kind: least(lambda kind=kind: digest(mesh, kept, kind)) for kind in ("blake2b", "sha256", "sha1")}
    check = min(checks.values(), key=lambda seconds: seconds["cpu"])
    loading = {}
    for compression in ("plain", "compressed"):
        bare, full = files[f"bare, {compression}"], files[f"kept, {compression}"]
        opening = {kind: full["load"][kind] - bare["load"][kind] for kind in ("wall", "cpu")}
        loading[compression] = total(opening, full["fetch"], check, steps["take_over"])
    every = total(*(steps[name] for name in [*STEPS, *REBUILT_ANYWAY, *UNDER_SUSPICION] if name in steps))
    return {
        "triangles": len(mesh.triangle_corners),
        "steps": steps,
        "kept_bytes": {step: sum(kept[name].nbytes for name in names) for step, names in STEPS.items()},
        "files": files,
        "hash_seconds": checks,
        "rebuild_seconds": total(*(steps[name] for name in STEPS)),
        "load_seconds": loading,
        "preprocess_s_per_million": {kind: seconds / million for kind, seconds in every.items()},
        "memory": None if arguments.no_memory else memory_of_its_own(mesh, folder),
    }


def main() -> None:
    """Prints the figures, and writes them where --json says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bench", type=Path, help="the program paradesc_preprocessing_bench")
    parser.add_argument("--mesh", type=Path, help="a Wavefront file to subdivide (default: a torus of 60 charts)")
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--no-memory", action="store_true", help="leave out the compute, which takes longest")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--memory-of", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.memory_of:
        sys.stdout.write(json.dumps(measure_memory(arguments.memory_of)) + "\n")
        return
    if arguments.bench is None:
        parser.error("--bench is needed")
    mesh = subdivided(read_obj(arguments.mesh), arguments.triangles) if arguments.mesh else torus(arguments.triangles)
    with tempfile.TemporaryDirectory() as folder:
        results = measure(arguments, mesh, Path(folder))
    name = arguments.mesh.stem if arguments.mesh else "torus"
    results = {"mesh": name, "date": date.today().isoformat(), "processor": processor(), **results}
    text = json.dumps(results, indent=2)
    sys.stdout.write(text + "\n")
    if arguments.json:
        arguments.json.write_text(text + "\n")


if __name__ == "__main__":
    main()
