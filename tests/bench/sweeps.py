"""Measures the performance half of the paper, figure by figure, in minutes, and writes its part of the page."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import figures
import hard
import meshes
import numpy as np
import page
import parts
import programs
import timing
from sections_models import MODELS
from timing import STAGES

from paradesc.bridge import Options

TRIANGLES = (25_000, 50_000, 100_000, 200_000, 400_000, 600_000, 1_000_000, 1_200_000, 2_000_000)
RADII = (0.01, 0.02, 0.04, 0.08)
PAPER_TABLE_1 = {64: ("17.57", "15.94"), 100: ("22.17", "19.54"), 256: ("50.54", "41.44"), 400: ("74.21", "61.75")}
PAPER_TABLE_2 = {(512, "full"): "26.5", (512, "half"): "24.4", (1024, "full"): "74.9", (1024, "half"): "66.8"}


@dataclass
class Sweep:
    """One section of the page."""

    function: Callable[[parts.Run, page.Section], None]
    title: str
    paper: str
    minutes: int


def milliseconds(seconds: float) -> float:
    return 1e3 * seconds


def head_of(*labels: str) -> list[str]:
    """The columns of compared() for each label."""
    return [f"{label}: {word}" for label in labels for word in ("samples", "error %", "ms", "times faster")]


def compared(found: dict, *names: str) -> list[float]:
    """The results of parts.against_baseline for each of these names."""
    cells = []
    for one in (found[name] for name in names):
        cells += [one["samples"], one["error"], milliseconds(one["seconds"])]
        cells.append(found["baseline"]["seconds"] / one["seconds"])
    return cells


def detail(run: parts.Run, out: page.Section) -> None:
    """Measures Fig. 11, left."""
    out.say(
        "A torus, irregularly triangulated, eight charts, r = 4 % of the diagonal, mean curvature. Frames from "
        "positions to results in Python, without preprocessing on both sides; the baseline on all cores, extrapolated "
        "from a random sample of the same mesh's vertices. Errors against the reference at 400 random vertices. "
        f"*Fewest*: samples that keep {figures.ALLOWED_ERROR:g} %; *fine*: {figures.FINE_ERROR:g} %."
    )
    rows, curves = [], []
    for triangles in TRIANGLES:
        found = parts.against_baseline(run, parts.torus(run, triangles), 0.04, ("fitted", "max"))
        base = found["baseline"]
        ways = compared(found, "fewest", "fine", "at_256", "max_normals")
        stages = [milliseconds(found["fine"][f"seconds_{stage}"]) for stage in STAGES]
        rows.append([found["triangles"], base["seconds"], base["neighbors_per_point"], *ways, *stages])
        shown = (base, found["fine"], found["at_256"])
        curves.append((found["triangles"] / 1e3, *(one["seconds"] for one in shown)))
        parts.say(f"{triangles} triangles: {base['seconds']:.2f} s against {shown[1]['seconds']:.3f} s\n")
    head = ["triangles", "baseline s", "neighbors", *head_of("fewest", "fine", "256", "Max's normals")]
    out.table("Detail", head + [f"fine: {stage} ms" for stage in STAGES], rows)

    def draw(axes: object) -> None:
        x, *every = zip(*curves, strict=True)
        for label, y in zip(("baseline", "error below 0.1 %", "256 samples"), every, strict=True):
            axes.loglog(x, y, marker="o", markersize=3, label=label)
        axes.set(xlabel="thousand triangles", ylabel="seconds a frame")
        axes.legend(fontsize=7)

    out.plot("fig11", "Fig. 11 left, time over geometric detail, r = 4 %", draw)


def radius(run: parts.Run, out: page.Section) -> None:
    """Measures Fig. 11, right."""
    arrays = parts.torus(run, 600_000)
    out.say("The same shape at 600 K triangles. Times relative to the smallest radius are the paper's figures.")
    rows, first = [], None
    for fraction in RADII:
        found = parts.against_baseline(run, arrays, fraction)
        times = [one["seconds"] for one in (found["baseline"], found["fine"], found["at_256"])]
        first = first or times
        grown = [now / then for now, then in zip(times, first, strict=True)]
        rows.append([f"{100 * fraction:g} %", found["fine"]["samples"], *times, *grown])
    head = ["r", "fine samples", *(f"{name} {unit}" for unit in ("s", "×") for name in ("baseline", "fine", "256"))]
    out.table("Radius", head, rows)


def samples(run: parts.Run, out: page.Section) -> None:
    """Measures Tables 1 and 2, and Fig. 12, in texture space."""
    arrays, atlas = meshes.with_charts("stanford-bunny")
    if arrays is None:
        out.lacks(atlas)
        return
    out.say(
        "stanford-bunny, r = 2 %, mean curvature, by samples that march over seams (`affine`); errors against the "
        "reference at 2000 vertices. The paper's milliseconds are those of a GTX 670."
    )
    path = programs.write_mesh(run.folder / "mesh", arrays)
    length = 0.02 * meshes.diagonal(arrays)
    truth = programs.object_space(run.build, path, length, points=2000, methods="reference")[1]["reference"]
    device = timing.Bench("software")
    made, _ = device.mesh(arrays, Options())

    def cells(**wanted: object) -> tuple[float, float, float]:
        frame = device.frame(made, arrays, Options(**wanted), repeats=2)
        error = timing.with_error(frame, truth)["error"]
        return error, milliseconds(frame["seconds_evaluate"]), milliseconds(frame["seconds"])

    with made:
        rows = []
        for count in (8, 16, 32, 64, 100, 256, 400):
            full, adaptive = cells(samples=count), cells(samples=count, adaptive=0.05)
            texels = cells(samples=count, evaluate="texel")
            rows.append([count, *PAPER_TABLE_1.get(count, ("", "")), *full, *adaptive, *texels])
        three = ("error %", "evaluate ms", "frame ms")
        head = ["samples", "paper, full ms", "paper, adaptive ms"]
        head += [f"{kind}: {word}" for kind in ("full", "adaptive", "512² texels") for word in three]
        out.table("Table 1 and Fig. 12, samples", head, rows)
        rows = []
        for size in (512, 1024, 2048):
            for precision in ("full", "half"):
                found = cells(buffer_size=size, precision=precision)
                rows.append([f"{size}²", precision, PAPER_TABLE_2.get((size, precision), ""), *found])
        out.table("Table 2, buffers", ["buffer", "precision", "paper ms", *three], rows)
        rows = []
        for texels in (256, 512, 1024):
            for count in (16, 64, 256):
                rows.append([f"{texels}²", count, *cells(evaluate="texel", texels=texels, samples=count)])
        out.table("Fig. 12, texels evaluated", ["texels", "samples", *three], rows)


def charts(run: parts.Run, out: page.Section) -> None:
    """Measures Fig. 13: one chart against many."""
    out.say(
        "A torus of 50 K triangles, 256 samples; `affine` and `paper` carry samples over up to eight seams. The "
        "CPU needs no chart."
    )
    rows, device = [], timing.Bench("software")
    for blocks in (1, 2, 4, 6, 10):
        arrays = parts.torus(run, 50_000, blocks)
        for fraction in (0.02, 0.08):
            on_cpu, _ = run.bench.mesh(arrays, Options(radius=fraction))
            mesh, _ = device.mesh(arrays, Options(radius=fraction))
            with mesh, on_cpu:
                times = []
                for relocation in ("affine", "paper"):
                    frame = device.frame(mesh, arrays, Options(radius=fraction, relocation=relocation), repeats=1)
                    times += [milliseconds(frame["seconds_evaluate"]), milliseconds(frame["seconds"])]
                times.append(milliseconds(run.bench.frame(on_cpu, arrays, Options(radius=fraction))["seconds"]))
                counts = [int(mesh.report()[name]) for name in ("charts", "seam_edges")]
            rows.append([*counts, f"{100 * fraction:g} %", *times])
    head = ["charts", "seam edges", "r"]
    head += [f"{kind}: {word}" for kind in ("affine", "paper") for word in ("evaluate ms", "frame ms")]
    out.table("Charts", [*head, "CPU: frame ms"], rows)


def models(run: parts.Run, out: page.Section) -> None:
    """Measures the average over models."""
    out.say(
        "Models as they are, and subdivided by Loop's scheme to more than 300 K triangles; r = 4 %, the fewest samples "
        "that keep half a percent, and a tenth (*fine*). The paper's average is 49 times a baseline on four cores."
    )
    rows = []
    for name in MODELS:
        arrays, atlas = meshes.with_charts(name)
        if arrays is None:
            out.lacks(atlas)
            continue
        variants = [arrays]
        times = int(np.ceil(np.log(run.scale * 3e5 / len(arrays.triangle_corners)) / np.log(4)))
        if times > 0:
            variants.append(meshes.loop_subdivide(arrays, times))
        for variant in variants:
            found = parts.against_baseline(run, variant, 0.04)
            ways = compared(found, "fewest", "fine", "at_256")
            rows.append([name, found["triangles"], found["baseline"]["seconds"], *ways])
    if not rows:
        return
    head = ["model", "triangles", "baseline s", *head_of("fewest", "fine", "256")]
    columns = [column for column, name in enumerate(head) if name.endswith(("error %", "times faster"))]
    measured, means = run.measured.setdefault("models", {}), []
    for label, big in (("as they are", False), ("subdivided", True)):
        chosen = [row for row in rows if (row[1] > run.scale * 3e5) == big]
        if chosen:
            mean = {column: float(np.mean([row[column] for row in chosen])) for column in columns}
            means.append([f"mean, {label}", *(mean.get(column, "") for column in range(1, len(head)))])
            measured[label] = mean[head.index("fine: times faster")]
    out.table("Models", head, [*rows, *means])


SWEEPS = {
    "detail": Sweep(
        detail, "Geometric detail (Fig. 11 left)", "3 times at 100 K, 137 at 1 M, 181 at 1.2 M triangles", 4
    ),
    "radius": Sweep(radius, "Radius (Fig. 11 right)", "radius × 8: its time × 2.25, the baseline's × 26.45", 2),
    "samples": Sweep(samples, "Samples, buffers, texels (Tables 1 and 2, Fig. 12)", "the columns below", 3),
    "charts": Sweep(charts, "One chart against many (Fig. 13)", "pictures only", 3),
    "models": Sweep(models, "Average over models", "49 times a baseline on four cores, 1.245 %", 4),
    "hard": Sweep(hard.sweep, "Rough surfaces, parts, needles, ten million triangles", "", 6),
}


def measure(name: str, run: parts.Run, stamp: dict[str, object], folder: Path) -> None:
    """Runs one sweep and keeps it."""
    row = SWEEPS[name]
    said = f"{stamp['date']}, {stamp['device']} on {stamp['cpu']} × {stamp['cores']}, commit {stamp['commit']}, "
    said += f"load before {stamp['load_before']}, python tests/bench/run.py --sweep {name}"
    out = page.Section(name, row.title, row.paper, folder, said)
    start = time.monotonic()
    try:
        row.function(run, out)
    except programs.MissingError as missing:
        out.lacks(str(missing))
    out.seconds = time.monotonic() - start
    out.save()
