"""Bakes changing meshes with changing options, backends and endings in one process, whose memory and files stay level.

Usage: python tests/soak.py [--bakes 1000] [--seed 1] [--every 25] [--backends software,cpu,reference] [--json FILE]
Ends with 1 if something grew, or if a bake ended in another way than it should.
"""

import argparse
import ctypes
import gc
import json
import sys
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "tests" / "addon")]

from allocator import give_back, megabytes_in_use  # noqa: E402

from paradesc import bridge  # noqa: E402
from paradesc.bridge import ParadescError, abi  # noqa: E402
from paradesc.core import contexts, job  # noqa: E402
from paradesc.core.stream import Stream  # noqa: E402
from paradesc.core.threads import Worker  # noqa: E402
from shapes import as_arrays, cube_sphere  # noqa: E402

BACKENDS = ("software", "cpu", "reference")
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of glibc's malloc.h
# The most steps along the side of a chart: 26 to 488 vertices.
FINEST = 9
# The growth that one bake may leave behind. A lost field of these meshes is some 10 kB, a lost mesh 100 kB, a lost
# context 10 MB.
HEAP_PER_BAKE = 1024
# Pages of freed memory come and go, so only the whole growth after the warm-up counts, in megabytes.
RESIDENT_GROWTH = 24.0


# ---- What is baked


def random_mesh(chance: np.random.Generator) -> bridge.MeshArrays:
    """A sphere of six charts of any fineness, with one or two of the changes below."""
    arrays = as_arrays(*cube_sphere(int(chance.integers(2, FINEST + 1)), radius=float(chance.uniform(0.01, 100))))
    for change in chance.choice(len(CHANGES), size=int(chance.integers(0, 3)), replace=False):
        arrays = CHANGES[change](arrays, chance)
    return arrays


def holes(arrays: bridge.MeshArrays, chance: np.random.Generator) -> bridge.MeshArrays:
    """Removes some triangles."""
    kept = chance.random(len(arrays.triangle_corners)) > 0.2
    kept[0] = True
    smooth = None if arrays.triangle_smooth is None else arrays.triangle_smooth[kept]
    return replace(arrays, triangle_corners=arrays.triangle_corners[kept], triangle_smooth=smooth)


def bumps(arrays: bridge.MeshArrays, chance: np.random.Generator) -> bridge.MeshArrays:
    """Adds noise of two per cent of the size."""
    noise = chance.normal(size=arrays.positions.shape).astype(np.float32) * np.ptp(arrays.positions) * 0.02
    return replace(arrays, positions=arrays.positions + noise)


def loose(arrays: bridge.MeshArrays, chance: np.random.Generator) -> bridge.MeshArrays:
    """Adds vertices without a face."""
    more = chance.normal(size=(5, 3)).astype(np.float32)
    return replace(arrays, positions=np.concatenate([arrays.positions, more]))


def split(arrays: bridge.MeshArrays, _chance: np.random.Generator) -> bridge.MeshArrays:
    """Gives every corner a vertex of its own, as some exporters do."""
    positions = arrays.positions[arrays.corner_vertices]
    return replace(arrays, positions=positions, corner_vertices=np.arange(len(positions), dtype=np.int32))


def overlapping(arrays: bridge.MeshArrays, _chance: np.random.Generator) -> bridge.MeshArrays:
    """Lays charts on each other."""
    return replace(arrays, corner_uvs=(2 * arrays.corner_uvs % 1).astype(np.float32))


def sparse(arrays: bridge.MeshArrays, _chance: np.random.Generator) -> bridge.MeshArrays:
    """Makes the charts fill little of the square."""
    return replace(arrays, corner_uvs=arrays.corner_uvs * np.float32(0.1))


def flat_triangles(arrays: bridge.MeshArrays, chance: np.random.Generator) -> bridge.MeshArrays:
    """Makes triangles without area in space, and others without area in the UV map."""
    corners, uvs = arrays.corner_vertices.copy(), arrays.corner_uvs.copy()
    first, second, *_ = chance.permutation(len(arrays.triangle_corners))
    corners[arrays.triangle_corners[first, 1]] = corners[arrays.triangle_corners[first, 0]]
    uvs[arrays.triangle_corners[second]] = uvs[arrays.triangle_corners[second, 0]]
    return replace(arrays, corner_vertices=corners, corner_uvs=uvs)


def displaced(arrays: bridge.MeshArrays, chance: np.random.Generator) -> bridge.MeshArrays:
    """Adds a displacement map."""
    heights = chance.random((32, 48)).astype(np.float32)
    return replace(arrays, maps=bridge.SurfaceMaps(heights=heights, scale=float(np.ptp(arrays.positions)) * 0.01))


def with_shading(arrays: bridge.MeshArrays, chance: np.random.Generator) -> bridge.MeshArrays:
    """Adds normals of its own, flat faces and sharp edges."""
    places = arrays.positions[arrays.corner_vertices]
    normals = places / np.maximum(np.linalg.norm(places, axis=1, keepdims=True), 1e-9)
    smooth = (chance.random(len(arrays.triangle_corners)) > 0.3).astype(np.uint8)
    edges = arrays.triangle_vertices[:7, :2].astype(np.int32)
    return replace(arrays, corner_normals=normals.astype(np.float32), triangle_smooth=smooth, sharp_edges=edges)


CHANGES = (holes, bumps, loose, split, overlapping, sparse, flat_triangles, displaced, with_shading)


def random_settings(chance: np.random.Generator, arrays: bridge.MeshArrays, backend: str) -> job.Settings:
    """Any options that go together, in sizes that are quick."""
    options = bridge.Options(
        radius=float(chance.uniform(0.05, 0.15)),
        samples=int(chance.choice([16, 32, 64])),
        buffer_size=int(chance.choice([64, 100, 128, 256])),
        seed=int(chance.integers(1000)),
        texels=int(chance.choice([16, 64])),
        adaptive=float(chance.choice([0, 0, 0.05])),
        max_jumps=int(chance.choice([1, 8])),
    )
    for name, (choices, _) in bridge.CHOICES.items():
        if name != "radius_unit" and chance.random() < 0.25:
            setattr(options, name, str(chance.choice(list(choices))))
    if options.relocation == "connected":
        options.geodesic = "local"
    if options.normals == "mesh" and arrays.corner_normals is None:
        options.normals = "max"
    names = [row.name for row in bridge.descriptors()]
    if options.evaluate == "texel":
        names = [row.name for row in bridge.descriptors() if not row.map_degree]
    asked = tuple(map(str, chance.choice(names, size=int(chance.integers(1, 5)), replace=False)))
    more = (options.radius * 0.7,) if chance.random() < 0.15 else ()
    return job.Settings(asked, options, backend, more_radii=more)


# ---- How a bake goes


def whole(arrays: bridge.MeshArrays, settings: job.Settings, _chance: np.random.Generator) -> str:
    """Runs a bake from start to end."""
    job.run(
        arrays, settings, with_buffers=bridge.uses_texture_space(settings.backend) and settings.options.seed % 4 == 0
    )
    return "done"


def in_thread(arrays: bridge.MeshArrays, settings: job.Settings, _chance: np.random.Generator) -> str:
    """Runs a bake on a thread of its own, as under Blender's window."""
    worker = Worker(partial(job.run, arrays, settings))
    worker.result()
    return "done in a thread"


def cancelled(arrays: bridge.MeshArrays, settings: job.Settings, chance: np.random.Generator) -> str:
    """Cancels a bake at some fraction of the way."""
    stop = float(chance.choice([0.0, 0.15, 0.25, 0.5, 0.9]))
    try:
        job.run(arrays, settings, lambda _stage, fraction: fraction < stop)
    except ParadescError as error:
        if error.status != abi.STATUS_CANCELLED:
            raise
        return "cancelled"
    return "done"  # it never came that far


def interrupted(arrays: bridge.MeshArrays, settings: job.Settings, _chance: np.random.Generator) -> str:
    """Raises an exception in the callback, as Ctrl-C does."""

    def press(_stage: str, _fraction: float) -> bool:
        raise KeyboardInterrupt

    try:
        job.run(arrays, settings, press)
    except KeyboardInterrupt:
        return "interrupted"
    raise AssertionError("The interrupt was lost.")


def streamed(arrays: bridge.MeshArrays, settings: job.Settings, chance: np.random.Generator) -> str:
    """Streams positions of several frames, then a mesh of another topology, then some more frames."""
    settings = replace(settings, options=replace(settings.options, normals="fitted"))
    with Stream(replace(arrays, corner_normals=None), settings) as stream:
        for _ in range(3):
            noise = chance.normal(size=arrays.positions.shape) * np.ptp(arrays.positions) * 1e-3
            stream.compute((arrays.positions + noise).astype(np.float32))
        other = as_arrays(*cube_sphere(int(chance.integers(2, 6))))
        stream.replace(other)
        stream.compute(other.positions)
    return "streamed"


def refused(arrays: bridge.MeshArrays, settings: job.Settings, chance: np.random.Generator) -> str:
    """Tries a bake with an error in the mesh, or in the options."""
    positions = arrays.positions.copy()
    positions[0, 1] = np.nan
    corners = arrays.corner_vertices.copy()
    corners[-1] = len(positions)
    wrong = [
        (replace(arrays, positions=positions), settings),
        (replace(arrays, corner_vertices=corners), settings),
        (replace(arrays, triangle_corners=arrays.triangle_corners[:0]), settings),
        (arrays, replace(settings, options=replace(settings.options, radius=5.0))),
        (arrays, replace(settings, options=replace(settings.options, samples=1))),
        (arrays, replace(settings, descriptors=("pointiness",))),
        (arrays, replace(settings, backend="software", device_index=99)),
        (replace(arrays, corner_uvs=None), replace(settings, backend="software")),
    ]
    mesh, asked = wrong[int(chance.integers(len(wrong)))]
    try:
        job.run(mesh, asked)
    except ParadescError as error:
        if error.status == abi.STATUS_UNKNOWN:
            raise
        return "refused"
    raise AssertionError("What cannot be computed was computed.")


# The ways in which a bake goes, with their weights.
WAYS: dict[Callable[..., str], float] = {
    whole: 0.4,
    in_thread: 0.1,
    cancelled: 0.2,
    interrupted: 0.05,
    streamed: 0.1,
    refused: 0.15,
}


def bake(chance: np.random.Generator, backends: tuple[str, ...] = BACKENDS) -> str:
    """One bake of the soak; gives how it ended, which is as it should be."""
    way = list(WAYS)[int(chance.choice(len(WAYS), p=list(WAYS.values())))]
    backend = str(chance.choice(backends))
    arrays = random_mesh(chance)
    if backend == "reference":  # which computes the maps of operators at every piece, for minutes
        arrays = replace(arrays, maps=None)
    settings = random_settings(chance, arrays, backend)
    if arrays.maps is not None:
        settings.options.evaluate = "vertex"
    if backend == "cpu" and job.backend_for(replace(settings, backend="auto")) != "cpu":
        settings = replace(settings, backend="software")
    return way(arrays, settings, chance)


# ---- What the process holds


@dataclass
class Sample:
    """The memory and handles of the process after a number of bakes."""

    bakes: int
    seconds: float
    resident: float  # megabytes that are this process's own: pages of libraries come and go with what others need
    heap: float  # megabytes in use
    files: int
    threads: int


def give_back_at_once() -> None:
    """Makes malloc return large blocks once they are freed; it would keep more of them, the larger they have been."""
    library = ctypes.CDLL(None)
    for option in (M_MMAP_THRESHOLD, M_TRIM_THRESHOLD):
        library.mallopt(option, 2**17)


def fill_numpys_cache() -> None:
    """Fills numpy's cache: it keeps up to seven freed blocks of each size below 1 kB, which would grow slowly."""
    held = [np.empty(size, np.uint8) for size in range(1, 1024) for _ in range(8)]
    held.clear()


def holdings(bakes: int, seconds: float) -> Sample:
    """The holdings of this process, without memory that waits to be given back and devices that wait for a bake."""
    contexts.close_idle()
    gc.collect()
    give_back()
    status = Path("/proc/self/status").read_text()
    return Sample(
        bakes,
        seconds,
        int(status.split("RssAnon:")[1].split()[0]) / 1024,
        megabytes_in_use(),
        len(list(Path("/proc/self/fd").iterdir())),
        len(threads() - drivers_own()),
    )


def threads() -> set[str]:
    """The threads of this process."""
    return {path.name for path in Path("/proc/self/task").iterdir()}


def drivers_own() -> set[str]:
    """The threads that write Mesa's shader cache; it starts up to four for the process, as it has more to write."""
    own = set()
    for path in Path("/proc/self/task").iterdir():
        with suppress(OSError):  # it has just ended
            if ":disk$" in (path / "comm").read_text():
                own.add(path.name)
    return own


def soak(
    bakes: int,
    every: int,
    seed: int = 1,
    backends: tuple[str, ...] = BACKENDS,
    tell: Callable[[Sample], None] | None = None,
) -> tuple[list[Sample], Counter]:
    """Bakes that often; gives what was held on the way, and how often bakes ended in each way."""
    give_back_at_once()
    fill_numpys_cache()
    chance = np.random.default_rng(seed)
    ends: Counter = Counter()
    samples = []
    start = time.perf_counter()
    for number in range(bakes + 1):
        if number % every == 0:
            samples.append(holdings(number, time.perf_counter() - start))
            if tell:
                tell(samples[-1])
        if number < bakes:
            ends[bake(chance, backends)] += 1
    return samples, ends


# ---- Whether it is level


def slope(samples: list[Sample], member: str) -> float:
    """The growth of each bake, as the median of the slopes of all pairs (Theil and Sen)."""
    at = np.array([sample.bakes for sample in samples], float)
    held = np.array([getattr(sample, member) for sample in samples], float)
    first, second = np.triu_indices(len(at), 1)
    return float(np.median((held[second] - held[first]) / (at[second] - at[first])))


def growths(samples: list[Sample], warm_up: float = 0.3, heap_per_bake: int = HEAP_PER_BAKE) -> list[str]:
    """One sentence about each thing that is not level after the warm-up, the first share of the bakes."""
    settled = [sample for sample in samples if sample.bakes >= warm_up * samples[-1].bakes]
    first, last = settled[0], settled[-1]
    found = []
    heap = slope(settled, "heap") * 2**20
    if heap > heap_per_bake:
        found.append(f"The heap grows by {heap:,.0f} bytes a bake; {heap_per_bake:,} may be noise.")
    resident = slope(settled, "resident") * (last.bakes - first.bakes)
    if resident > RESIDENT_GROWTH:
        found.append(
            f"Resident memory grew by {resident:.1f} MB after the warm-up; {RESIDENT_GROWTH:.0f} may be noise."
        )
    for member in ("files", "threads"):
        before, after = getattr(first, member), getattr(last, member)
        if after > before:
            found.append(f"There are {after} {member} at the end, and there were {before} after the warm-up.")
    return found


# ---- The command


def row(sample: Sample) -> str:
    """One line of the curve; a mark stands for four megabytes."""
    marks = "#" * round(sample.resident / 4)
    return (
        f"{sample.bakes:6d} {sample.seconds:7.1f} s {sample.resident:8.1f} MB {sample.heap:8.2f} MB "
        f"{sample.files:4d} files {sample.threads:3d} threads  {marks}\n"
    )


def main(words: list[str] | None = None) -> int:
    """Prints the curve and whether it is level."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bakes", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=25, help="bakes between two looks at the process")
    parser.add_argument("--backends", default=",".join(BACKENDS))
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args(words)
    sys.stdout.write(" bakes    time   resident        heap\n")
    backends = tuple(asked.backends.split(","))

    def tell(sample: Sample) -> None:
        sys.stdout.write(row(sample))
        sys.stdout.flush()

    samples, ends = soak(asked.bakes, asked.every, asked.seed, backends, tell)
    settled = [sample for sample in samples if sample.bakes >= 0.3 * asked.bakes]
    grown = growths(samples)
    sys.stdout.write(f"ends: {', '.join(f'{count} {name}' for name, count in ends.most_common())}\n")
    sys.stdout.write(f"heap: {slope(settled, 'heap') * 2**20:+,.0f} bytes a bake after the warm-up\n")
    sys.stdout.write(f"resident: {slope(settled, 'resident') * 2**20:+,.0f} bytes a bake after the warm-up\n")
    sys.stdout.write("".join(f"{sentence}\n" for sentence in grown) or "level\n")
    if asked.json:
        content = {"samples": [asdict(sample) for sample in samples], "ends": ends, "grown": grown}
        asked.json.write_text(json.dumps(content, indent=1))
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main())
