"""Sections that measure the engine on the CPU beside the device: every descriptor, by mesh and radius."""

import numpy as np
import surfaces
from bench import errors, options, registry
from sections_models import MODELS, models
from sections_surfaces import CURVATURES, LABELS, inside

RADII = (0.01, 0.02, 0.04)
MIDDLE = 0.02
ALONE = "CPU, each alone"
MESHES = (*MODELS, "fandisk", "barracks", "pirate")
SURFACES = ("torus", "ellipsoid")
# Those of the shape operator, and what the CPU may err there; the others may err by more.
SHAPE_OPERATOR = {name for name in CURVATURES if name != "local_bending_energy"}
MOST_MEAN, MOST_P99, MOST_OTHER_MEAN = 0.1, 1.0, 0.3


def engines(bench, out, quick):
    out.say(
        "Mean and 99th percentile of the error in percent against the reference, over all vertices with a face, with "
        f"the default options. *Device*: in texture space, at {100 * MIDDLE:g} % alone, since it takes long without a "
        "graphics card. On the CPU those of the shape operator (H, K, k1, k2, shape index, curvedness) may err by "
        f"{MOST_MEAN:g} in the mean and {MOST_P99:g} at the 99th percentile, all others by {MOST_OTHER_MEAN:g} in the "
        f"mean; what is beyond that is bold. *{ALONE}*: a descriptor that is asked for by itself has the samples that "
        "it needs; beside areas it has theirs, which are more."
    )
    names = registry()
    rows, found = [], {}
    for model, arrays, _ in models(out, MESHES[:1] if quick else MESHES):
        for radius in (MIDDLE,) if quick else RADII:
            measure(bench, (model, arrays, radius), names, rows, found)
        bench.forget()
    for name in SURFACES[:1] if quick else SURFACES:
        surface = surfaces.SURFACES[name](irregular=True)
        measure(bench, (f"{name} of the tests", surface.arrays, MIDDLE), names, rows, found)
        bench.forget()
    titles = [LABELS.get(name, name.replace("_", " ")) for name in names]
    summary = [
        [title, *(worst([one[name] for one in found[engine]], part) for engine in found for part in ("mean", "p99"))]
        for title, name in zip(titles, names, strict=True)
    ]
    head = [f"{engine}: worst {part}" for engine in found for part in ("mean", "99 %")]
    out.table("Over all meshes and radii", ["descriptor", *head], summary)
    out.table("Every case: mean / 99th percentile", ["mesh", "triangles", "r", "engine", *titles], rows)
    closed(bench, out, quick)


def measure(bench, case, names, rows, found):
    """Adds a row for each engine; found gets the errors by engine."""
    mesh, arrays, radius = case
    chosen = options(radius=radius)
    truth = bench.reference(arrays, names, chosen)
    together = {"CPU": bench.on_cpu} | ({"device": bench.run} if radius == MIDDLE else {})
    runs = {engine: run(arrays, names, chosen).values for engine, run in together.items()}
    runs[ALONE] = {name: bench.on_cpu(arrays, (name,), chosen).values[name] for name in names}
    for engine, values in runs.items():
        stats = {name: errors(name, values[name], truth.values[name], truth.radius) for name in names}
        found.setdefault(engine, []).append(stats)
        cells = [shown(name, stats[name], engine != "device") for name in names]
        rows.append([mesh, len(arrays.triangle_corners), f"{100 * radius:g} %", engine, *cells])


def shown(name, stats, bounded):
    """Mean / 99th percentile, bold if the engine on the CPU is beyond its bounds."""
    text = f"{stats.mean:.3f} / {stats.p99:.3f}"
    most_mean, most_p99 = (MOST_MEAN, MOST_P99) if name in SHAPE_OPERATOR else (MOST_OTHER_MEAN, np.inf)
    beyond = stats.mean > most_mean or stats.p99 > most_p99
    return f"**{text}**" if bounded and beyond else text


def worst(every, part):
    """The largest of a statistic that is defined."""
    values = [getattr(stats, part) for stats in every]
    return float(np.nanmax(values)) if np.isfinite(values).any() else np.nan


def closed(bench, out, quick):
    """Mean error against the closed form of smooth surfaces, of both engines and the reference."""
    names = [name for name in registry() if name in CURVATURES]
    rows = []
    for surface_name in SURFACES[:1] if quick else SURFACES:
        for irregular in (False, True):
            surface = surfaces.SURFACES[surface_name](irregular=irregular)
            for radius in (MIDDLE,) if quick else RADII:
                chosen = options(radius=radius)
                for engine, compute in (("device", bench.run), ("CPU", bench.on_cpu), ("reference", bench.reference)):
                    results = compute(surface.arrays, names, chosen)
                    r = results.radius
                    cells = [
                        errors(name, results.values[name], surface.exact(name, r), r, inside(surface, r)).mean
                        for name in names
                    ]
                    kind = "irregular" if irregular else "regular"
                    rows.append([surface_name, kind, f"{100 * radius:g} %", engine, *cells])
            bench.forget()
    head = ["surface", "triangles", "r", "engine", *(LABELS[name] for name in names)]
    out.table("Smooth surfaces: mean error in percent against the limit r → 0", head, rows)


SECTIONS = {"engines": (engines, "The engine on the CPU beside the device", "not measured", 1800, 15)}
