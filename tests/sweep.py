"""Computes every real mesh × descriptor × three radii, in both precisions and on the CPU; no value may lack.

Usage: python tests/sweep.py [--quick] [--meshes FOLDER] [--only spot,fox] [--radii 0.01,0.02,0.04] [--json FILE]
                             [--backends software,cpu]
Of a surface that was found, that is. It needs Blender's module bpy, which reads the files as the command line does,
and unwraps meshes without a UV map. A derivative of a map may be missing if the reference has none either: a part
that is thin against the radius, such as a lath, does not determine a quadratic. It ends with 1 if it found something:
a value that is missing or outside its range, an error of the device, memory or files that stay.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "tests"), str(ROOT / "tests" / "addon")]

from soak import Sample, growths, holdings  # noqa: E402

from paradesc import bridge  # noqa: E402
from paradesc.bridge import ParadescError, abi  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc_blender.scene import mesh_io, scene_io  # noqa: E402

MESHES = ROOT.parent / "shared" / "meshes"
RADII = (0.01, 0.02, 0.04)
BACKENDS = ("software", "cpu")
# The radius has to span so many texels. Every bake below warns, and a quadratic of a map may have too few of them.
COARSE = 4.0
SMALLEST = 40_000  # bytes; --quick reads smaller files only
QUICK = {"buffer_size": 256, "samples": 64}
# The limit of shaders/kernel/limits.h: what bends less over the radius, in radians, is a plane without a shape.
PLANE_THRESHOLD = 1e-4
# The range of each descriptor for a radius of 1. A plane in the ball has the area pi r^2, a crumpled surface has more.
RANGES: dict[str, tuple[float, float]] = {
    "shape_index": (-1, 1),
    "curvedness": (0, np.inf),
    "local_bending_energy": (0, np.inf),
    "sphere_volume": (0, np.inf),
    "sphere_volume_normalized": (0, 1),
    "ambient_openness": (0, 1),
    "euclidean_area": (0, np.inf),
    "geodesic_area": (0, np.inf),
    "cavity": (0, 1),
    "convexity": (0, 1),
    "gradient_magnitude": (0, np.inf),
}
# These operators need the least-squares quadratic of a map; paradesc.h says where there is none.
DERIVATIVES = {"gradient_magnitude", "laplacian", "harris"}
ROUNDING = 1e-5
# Device and reference may differ by this share of the values that one of them calls undetermined, and by this share of
# all: sums over samples and exact ones are not on the same side of a threshold everywhere.
AT_THRESHOLD = 0.05
ANYWHERE = 1e-4
INCOMPLETE = abi.MASK_NO_FACE | abi.MASK_LOW_COVERAGE | abi.MASK_NO_TEXEL


@dataclass
class Row:
    """The findings of one bake of a mesh with all descriptors."""

    mesh: str
    triangles: int
    radius: float
    precision: str  # of texture space; elsewhere the backend
    vertices: int = 0
    whole: int = 0  # vertices whose neighborhood was found: faces, a place in the UV map, coverage of 0.9
    planes: int = 0  # of those, without a shape index because they lie in a plane
    coarse: int = 0  # values of operators on a map that are missing because the radius spans less than four texels
    thin: int = 0  # derivatives of a map that are missing in the reference as well
    seconds: float = 0.0
    refused: str = ""  # the sentence of a mesh that cannot be used
    findings: list[str] = field(default_factory=list)


def check(results: job.Results, row: Row, reference: Callable[[tuple[str, ...]], job.Results]) -> None:
    """Looks at every value of every descriptor; asks the reference if operators on a map have none."""
    whole = (results.mask & INCOMPLETE) == 0
    row.vertices, row.whole = len(whole), int(whole.sum())
    bend = np.maximum(
        np.abs(results.values["principal_curvature_max"]), np.abs(results.values["principal_curvature_min"])
    )
    plane = bend * results.radius < PLANE_THRESHOLD * (1 + ROUNDING)
    row.planes = int((plane & whole).sum())
    for name, values in results.values.items():
        columns = values.reshape(len(values), -1)
        missing = np.isnan(columns).any(axis=1) & whole
        if name == "shape_index":
            missing &= ~plane
        if 0 < results.field_report["radius_in_texels"] < COARSE and job.registry_row(name).map_degree:
            row.coarse += int(missing.sum())
            continue
        if missing.any() and name in DERIVATIVES:
            missing = only_here(missing, reference((name,)).values[name], row, whole.sum())
        if missing.any():
            row.findings.append(f"{name}: {missing.sum()} values are missing, the first at vertex {missing.argmax()}")
        if np.isinf(columns).any():
            row.findings.append(f"{name}: {np.isinf(columns).sum()} values are infinite")
        low, high = RANGES.get(name, (-np.inf, np.inf))
        outside = whole & ((columns < low - ROUNDING) | (columns > high + ROUNDING)).any(axis=1)
        if outside.any():
            row.findings.append(
                f"{name}: {outside.sum()} values are outside {low} to {high}, as {columns[outside].ravel()[0]}"
            )
        if columns.shape[1] == 3:
            turned = whole & (np.abs(np.linalg.norm(columns, axis=1) - 1) > 1e-3)
            if turned.any():
                row.findings.append(f"{name}: {turned.sum()} are no unit vectors")


def only_here(missing: np.ndarray, reference: np.ndarray, row: Row, whole: int) -> np.ndarray:
    """(n,) bool the values that only the device lacks; a few of them, at the threshold, are no finding."""
    alone = missing & ~np.isnan(reference)
    row.thin += int((missing & ~alone).sum())
    return alone if alone.sum() > max(AT_THRESHOLD * missing.sum(), ANYWHERE * whole) else missing & False


def names_on(backend: str) -> tuple[str, ...]:
    """All descriptors; texels do not know the noise of positions."""
    unknown = {"standard_error"} if bridge.uses_texture_space(backend) else set()
    return tuple(row.name for row in bridge.descriptors() if row.name not in unknown)


def bakes(
    name: str,
    arrays: bridge.MeshArrays,
    radii: tuple[float, ...],
    backends: tuple[str, ...] = BACKENDS[:1],
    **options: int,
) -> Iterator[Row]:
    """Bakes one mesh at every radius on every backend, in all precisions that it has, with all descriptors at once."""
    for backend in backends:
        names = names_on(backend)
        precisions = tuple(bridge.CHOICES["precision"][0]) if bridge.uses_texture_space(backend) else ("full",)
        with bridge.Context(backend) as context, context.mesh(arrays) as mesh:
            for precision, radius in product(precisions, radii):
                label = precision if bridge.uses_texture_space(backend) else backend
                row = Row(name, len(arrays.triangle_corners), radius, label)
                settings = job.Settings(names, bridge.Options(radius=radius, precision=precision, **options), backend)
                start = time.perf_counter()

                def reference(asked: tuple[str, ...], settings: job.Settings = settings) -> job.Results:
                    return job.run(arrays, replace(settings, descriptors=asked, backend="reference"))

                try:
                    check(job.run_on(mesh, arrays, settings), row, reference)
                except ParadescError as error:  # also an error of OpenGL
                    row.findings.append(error.sentence)
                row.seconds = time.perf_counter() - start
                yield row


def files(folder: Path, quick: bool, only: tuple[str, ...] = ()) -> list[Path]:
    """The meshes to sweep."""
    found = sorted(path for path in folder.rglob("*") if path.suffix in (".obj", ".glb"))
    if quick:
        found = [path for path in found if path.stat().st_size <= SMALLEST]
    return [path for path in found if not only or path.stem in only]


def sweep_file(path: Path, radii: tuple[float, ...], backends: tuple[str, ...], **options: int) -> Iterator[Row]:
    """Makes all bakes of the largest mesh of a file; gives one row if it cannot be used, which is no finding."""
    try:
        scene_io.open_scene(path)
        arrays = mesh_io.read_object(scene_io.choose_object(prefer_active=False), corner_normals=False)
        yield from bakes(path.stem, arrays, radii, backends, **options)
    except ParadescError as error:
        row = Row(path.stem, 0, 0.0, "", refused=error.sentence)
        if error.status not in (abi.STATUS_INVALID_ARGUMENT, abi.STATUS_INVALID_OPERATION):
            row.findings.append(error.sentence)
        yield row


def sweep(
    paths: list[Path],
    radii: tuple[float, ...] = RADII,
    tell: Callable[[Row], None] | None = None,
    backends: tuple[str, ...] = BACKENDS,
    **options: int,
) -> tuple[list[Row], list[Sample]]:
    """Makes all bakes of all files; gives also what the process held after each file."""
    rows, samples = [], []
    start = time.perf_counter()
    for number, path in enumerate(paths):
        for row in sweep_file(path, radii, backends, **options):
            rows.append(row)
            if tell:
                tell(row)
        samples.append(holdings(number, time.perf_counter() - start))
    return rows, samples


def line(row: Row) -> str:
    """One line of the table."""
    if row.refused:
        return f"{row.mesh:28s} refused: {row.refused}\n"
    findings = "".join(f"\n    {sentence}" for sentence in row.findings)
    return (
        f"{row.mesh:28s} {row.triangles:8,d} {100 * row.radius:3.0f} % {row.precision:5s} {row.vertices:8,d} "
        f"{row.whole:8,d} {row.planes:7,d} {row.coarse:7,d} {row.thin:7,d} {row.seconds:7.2f} s{findings}\n"
    )


def main(words: list[str] | None = None) -> int:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small files, small buffers, few samples")
    parser.add_argument("--backends", default=",".join(BACKENDS))
    parser.add_argument("--meshes", type=Path, default=MESHES)
    parser.add_argument("--only", default="", help="names of files without their suffix, with commas between")
    parser.add_argument("--radii", default=",".join(map(str, RADII)), help="shares of the diagonal")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args(words)
    paths = files(asked.meshes, asked.quick, tuple(filter(None, asked.only.split(","))))
    if not paths:
        sys.stderr.write(f"There is no mesh to sweep in {asked.meshes}.\n")
        return 1
    out = sys.stdout.write
    out(f"{'mesh':28s} {'faces':>8s} radius       vertices    whole  planes  coarse    thin      time\n")

    def tell(row: Row) -> None:
        out(line(row))
        sys.stdout.flush()

    radii = tuple(map(float, asked.radii.split(",")))
    backends = tuple(asked.backends.split(","))
    rows, samples = sweep(paths, radii, tell, backends, **(QUICK if asked.quick else {}))
    kept = [sentence for sentence in growths(samples) if "files" in sentence or "threads" in sentence]
    found = sum(len(row.findings) for row in rows) + len(kept)
    done = [row for row in rows if not row.refused]
    values = sum(row.whole for row in done) * len(names_on(backends[0]))
    out("".join(f"{sentence}\n" for sentence in kept))
    out(f"{len(done)} bakes of {len({row.mesh for row in done})} meshes, {values:,} values at whole neighborhoods\n")
    out(f"heap in use after the first and the last mesh: {samples[0].heap:.1f}, {samples[-1].heap:.1f} MB\n")
    out(f"{found} findings\n")
    if asked.json:
        content = {"rows": [asdict(row) for row in rows], "held": [asdict(item) for item in samples], "kept": kept}
        asked.json.write_text(json.dumps(content, indent=1))
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main())
