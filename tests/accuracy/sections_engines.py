"""The section that measures every descriptor by the engine on the CPU, by mesh and radius."""

import numpy as np
import surfaces
from bench import errors, options, registry
from sections_models import MODELS, models
from sections_surfaces import CURVATURES, LABELS

RADII = (0.01, 0.02, 0.04)
MIDDLE = 0.02
TOGETHER, ALONE = "together", "each alone"
MESHES = (*MODELS, "fandisk", "barracks", "pirate")
SURFACES = ("torus", "ellipsoid")
# Those of the shape operator, and what the CPU may err there; the others may err by more.
SHAPE_OPERATOR = {name for name in CURVATURES if name != "local_bending_energy"}
MOST_MEAN, MOST_P99, MOST_OTHER_MEAN = 0.1, 1.0, 0.3


def engines(bench, out, quick):
    out.say(
        "Mean and 99th percentile of the error in percent against the reference, over all vertices with a face, with "
        "the default options. Those of the shape operator (H, K, k1, k2, shape index, curvedness) may err by "
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
    out.table("Every case: mean / 99th percentile", ["mesh", "triangles", "r", "asked for", *titles], rows)


def measure(bench, case, names, rows, found):
    """Adds a row for each engine; found gets the errors by engine."""
    mesh, arrays, radius = case
    chosen = options(radius=radius)
    truth = bench.reference(arrays, names, chosen)
    runs = {TOGETHER: bench.run(arrays, names, chosen).values}
    runs[ALONE] = {name: bench.run(arrays, (name,), chosen).values[name] for name in names}
    for engine, values in runs.items():
        stats = {name: errors(name, values[name], truth.values[name], truth.radius) for name in names}
        found.setdefault(engine, []).append(stats)
        cells = [shown(name, stats[name]) for name in names]
        rows.append([mesh, len(arrays.triangle_corners), f"{100 * radius:g} %", engine, *cells])


def shown(name, stats):
    """Mean / 99th percentile, bold if it is beyond its bounds."""
    text = f"{stats.mean:.3f} / {stats.p99:.3f}"
    most_mean, most_p99 = (MOST_MEAN, MOST_P99) if name in SHAPE_OPERATOR else (MOST_OTHER_MEAN, np.inf)
    beyond = stats.mean > most_mean or stats.p99 > most_p99
    return f"**{text}**" if beyond else text


def worst(every, part):
    """The largest of a statistic that is defined."""
    values = [getattr(stats, part) for stats in every]
    return float(np.nanmax(values)) if np.isfinite(values).any() else np.nan


SECTIONS = {"engines": (engines, "Every descriptor by the engine on the CPU", "not measured", 900, 15)}
