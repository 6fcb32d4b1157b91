"""Frames on the processor of surfaces that are rough, in many parts, of needles, or very large, beside a clean sheet."""

from collections.abc import Callable

import numpy as np
import page
import parts
import rough_surfaces
import surfaces
import timing

from paradesc.bridge import MeshArrays, Options, ParadescError

MILLION = 1_000_000


def grid_of_torus(around: int, along: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a regular torus: (around * along, 3) and (2 * around * along, 3)."""
    u, v = np.meshgrid(
        np.arange(around) * 2 * np.pi / around, np.arange(along) * 2 * np.pi / along, indexing="ij"
    )
    ring = 1 + 0.4 * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)], -1).reshape(-1, 3)
    i, k = (axis.ravel() for axis in np.meshgrid(np.arange(around), np.arange(along), indexing="ij"))
    a, b = i * along + k, (i + 1) % around * along + k
    c, d = (i + 1) % around * along + (k + 1) % along, i * along + (k + 1) % along
    return points, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])


def noisy(points: np.ndarray, faces: np.ndarray, edges: float) -> MeshArrays:
    """The same mesh with noise of so many mean edges."""
    return surfaces.as_arrays(rough_surfaces.noisy(points, faces, edges), faces)


def shuffled(points: np.ndarray, faces: np.ndarray) -> MeshArrays:
    """The same mesh with vertices and triangles in a random order."""
    generator = np.random.default_rng(1)
    order = generator.permutation(len(points))
    place = np.argsort(order)
    return surfaces.as_arrays(points[order], generator.permutation(place[faces]))


def cubes(count: int) -> MeshArrays:
    """Cubes of 12 triangles on a lattice, as far from each other as they are wide."""
    side = int(np.ceil(count ** (1 / 3)))
    lattice = np.stack(np.meshgrid(*3 * [np.arange(side)], indexing="ij"), -1).reshape(-1, 3)[:count]
    corners = np.stack(np.meshgrid(*3 * [np.arange(2)], indexing="ij"), -1).reshape(-1, 3)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    one = np.array([triangle for a, b, c, d in faces for triangle in ((a, b, c), (a, c, d))])
    points = (2 * lattice[:, None] + corners).reshape(-1, 3).astype(float)
    return surfaces.as_arrays(points, (8 * np.arange(count)[:, None, None] + one).reshape(-1, 3))


def can(sides: int) -> MeshArrays:
    """A cylinder of needles: a fan at both ends, and a ring of long triangles between them."""
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([np.cos(angle), np.sin(angle)], -1)
    low, high = (np.column_stack([ring, np.full(sides, z)]) for z in (-1.0, 1.0))
    points = np.concatenate([low, high, [[0, 0, -1], [0, 0, 1]]])
    i, k = np.arange(sides), (np.arange(sides) + 1) % sides
    ends = np.full(sides, 2 * sides)
    walls = [np.stack([i, k, k + sides], -1), np.stack([i, k + sides, i + sides], -1)]
    caps = [np.stack([k, i, ends], -1), np.stack([i + sides, k + sides, ends + 1], -1)]
    return surfaces.as_arrays(points, np.concatenate(walls + caps))


def frame_of(bench: timing.Bench, arrays: MeshArrays, options: Options) -> tuple[float, float, float, int]:
    """Seconds of a frame, of a vertex of it, and of what later frames need not do again; bytes that are kept."""
    before = timing.resident()
    mesh, once = bench.mesh(arrays, options)
    with mesh:
        seconds = bench.frame(mesh, arrays, options, repeats=1)["seconds"]
        return seconds, seconds / len(arrays.positions), sum(once.values()) - seconds, timing.resident() - before


def sweep(run: parts.Run, out: page.Section) -> None:
    """Measures each surface's frame, and what a vertex costs beside one of the clean sheet at 2 %."""
    out.say(
        "Mean curvature with the defaults, creases among them, on the processor: frames from positions to results in "
        "Python. *× clean*: what a vertex costs, over what it costs on the clean torus of a million triangles at 2 %. "
        "*Wanted* is in those units, or in seconds. Tori are irregular only in their noise; needles are from 1:80 to "
        "1:240."
    )
    bench = run.bench
    million = grid_of_torus(1250, 400)
    long, longer = grid_of_torus(2592, 9), grid_of_torus(8276, 29)
    cases: list[tuple[str, Callable[[], MeshArrays], float, str]] = [
        ("torus, clean", lambda: surfaces.as_arrays(*million), 0.02, ""),
        # It stands here because the rows below leave too little free memory.
        ("torus, ten million triangles", lambda: surfaces.as_arrays(*grid_of_torus(3953, 1265)), 0.02, "≤ 6 s"),
        *((f"noise of {size:g} edges", lambda size=size: noisy(*million, size), 0.02, f"≤ {wanted:g}")
          for size, wanted in ((0.3, 1.5), (1.4, 2.5), (5.6, 4))),
        ("shuffled", lambda: shuffled(*million), 0.02, "≤ 1.2"),
        *((f"{count:,} cubes", lambda count=count: cubes(count), radius, "≤ 2")
          for count in (50_000, 100_000) for radius in (0.005, 0.05)),
        ("cylinder of 4,000 sides", lambda: can(4000), 0.02, "≤ 10"),
        ("torus of long triangles", lambda: surfaces.as_arrays(*long), 0.1, "≤ 0.3 s"),
        ("the same, ten times as many", lambda: surfaces.as_arrays(*longer), 0.1, "≤ 3 s"),
    ]  # fmt: skip
    rows, clean = [], None
    for name, made, fraction, wanted in cases:
        arrays = made()
        about = [name, len(arrays.triangle_corners), f"{100 * fraction:g} %"]
        try:
            seconds, vertex, set_up, kept = frame_of(bench, arrays, Options(radius=fraction))
        except ParadescError as error:
            out.say(f"{name}: {error}")
            rows.append([*about, None, None, None, wanted, None, None])
            continue
        clean = clean or vertex
        rows.append([*about, seconds, 1e6 * vertex, vertex / clean, wanted, set_up, kept / 1e6])
        parts.say(f"{name}: {seconds:.2f} s\n")
    head = ["surface", "triangles", "r", "s", "µs a vertex", "× clean", "wanted", "set-up s", "MB kept"]
    out.table("Hard", head, rows)
