"""Sections on real meshes, measured against the reference: descriptors, radius, detail, charts, genus 20."""

import importlib.util
import sys
from pathlib import Path

import meshes
import numpy as np
from bench import MissingError, angle, directions, errors, options, registry
from sections_surfaces import LABELS

from paradesc import bridge
from paradesc.core import color_maps
from paradesc.core.job import registry_row

sys.path.append(str(Path(__file__).resolve().parents[2] / "addon" / "manual" / "pictures"))
import picture

MODELS = ("spot", "bob", "human", "beast", "rocker-arm", "stanford-bunny")
# The columns of compare.py in the table of distributions.
DISTRIBUTION = (
    "mean_percent_ae",
    "median_percent_ae",
    "p99_percent_ae",
    "max_percent_ae",
    "seam_mean_percent_ae",
)
SAMPLES_SCRIPT = Path(__file__).resolve().parents[2] / "blend_samples" / "make_samples.py"


def models(out, names):
    """(name, arrays, atlas) of the real meshes that are there."""
    for name in names:
        arrays, atlas = meshes.with_charts(name)
        if arrays is None:
            out.lacks(atlas)
        else:
            yield name, arrays, atlas


def compose(arrays, shown, span, upright=True):
    """One view for each (title, values) in colors of the same span (values, registry row, radius): (h, w, 3) uint8."""
    points = arrays.positions.astype(np.float64)
    if upright:  # y is up in these files, z in the picture; turned, so that spot looks at us
        points = np.stack([-points[:, 0], points[:, 2], points[:, 1]], axis=1)
    value_range = color_maps.value_range(*span)
    views = [picture.View(color_maps.colors(values, value_range), title, value_range) for title, values in shown]
    return picture.compose(points, arrays.triangle_vertices, views)


# ---- All descriptors against the reference


def reference(bench, out, quick):
    out.say(
        "Mean error in percent over all vertices with a face, in texture space by `affine`, r = 2 % of the diagonal. "
        "*Near seams*: vertices with a seam within r. Meshes without a UV map get charts by projection along the axes, in blocks; "
        "overlapping ones are laid out afresh by the library. The picture is by the engine on the CPU."
    )
    # The standard error has no truth: it is that of each engine's own samples.
    names = [name for name in registry() if name != "standard_error"]
    details, rows, means = [], [], []
    for model, arrays, atlas in models(out, MODELS[:2] if quick else MODELS):
        chosen = options(radius=0.02)
        found_rows, found = bench.compare(arrays, names, chosen)
        report = found.mesh_report
        for name in ("mean_curvature", "gaussian_curvature"):
            row = found_rows[name]
            shares = [row[column] for column in DISTRIBUTION]
            details.append([model, LABELS[name], *shares, 100 * row["coverage_mean"], row["undefined"]])
        means.append([found_rows[name]["mean_percent_ae"] for name in names])
        texels = found.field_report["radius_in_texels"]
        rows.append(
            [
                model,
                int(report["triangle_count"]),
                f"{atlas}, {int(report['charts'])}",
                texels,
                *means[-1],
                *turns(bench, arrays, chosen),
            ]
        )
        if model == "spot":
            pictures(bench, out, arrays, registry())
        bench.forget()
    if not rows:
        return
    blank = [""] * len(directions())
    rows.append(["mean", "", "", "", *np.mean(means, axis=0), *blank])
    heads = [LABELS.get(name, name) for name in names] + [name.removeprefix("principal_") for name in directions()]
    out.table("Mean error by descriptor", ["model", "triangles", "charts", "r in texels", *heads], rows)
    head = [
        "model",
        "",
        "mean",
        "median",
        "p99",
        "max",
        "near seams",
        "coverage %",
        "undefined",
    ]
    out.table("Distribution", head, details)
    overall = float(np.mean([row[names.index("mean_curvature")] for row in means]))
    out.say(f"Mean curvature on average over models: **{overall:.3f} %**; the paper's average is 1.245 %.")


def turns(bench, arrays, chosen):
    """Mean angles of the principal directions to the reference's, weighted by |k1 − k2|."""
    if not directions():
        return []
    names = [*directions(), "principal_curvature_max", "principal_curvature_min"]
    found, truth = bench.run(arrays, names, chosen), bench.reference(arrays, names, chosen)
    weight = np.nan_to_num(truth.values["principal_curvature_max"] - truth.values["principal_curvature_min"])
    return [f"{angle(found.values[name], truth.values[name], weight):.2f}°" for name in directions()]


def pictures(bench, out, arrays, names):
    """Draws Fig. 8: every descriptor."""
    found = bench.run(arrays, names, options(radius=0.02))
    panels = []
    for name in names:
        values = found.values[name]
        panels.append(compose(arrays, [(title_of(name), values)], (values, registry_row(name), found.radius)))
    while len(panels) % 4:
        panels.append(np.full_like(panels[0], 255))
    rows = [np.concatenate(panels[i : i + 4], axis=1) for i in range(0, len(panels), 4)]
    out.picture("fig8", "Fig. 8: every descriptor on spot, r = 2 %", halved(np.concatenate(rows, axis=0)))


def title_of(name):
    """A descriptor's name as pictures show it."""
    return name.replace("_", " ").upper()


def halved(image):
    """The picture at half its size."""
    h, w = image.shape[0] // 2 * 2, image.shape[1] // 2 * 2
    return image[:h, :w].reshape(h // 2, 2, w // 2, 2, 3).mean(axis=(1, 3)).round().astype(np.uint8)


# ---- Radius (Fig. 11, right) and detail (Fig. 11, left)


def radius(bench, out, quick):
    out.say(
        "The paper's error rises towards small radii, where its reference sees few vertices, and again at large ones, "
        "where one jump per sample misses parts. Here the reference integrates over triangles, and nothing is missed."
    )
    radii = (0.01, 0.02, 0.04) if quick else (0.005, 0.01, 0.02, 0.04, 0.08)
    names = ["mean_curvature", "gaussian_curvature", "local_bending_energy"]
    rows, curves = [], {}
    for model, arrays, _ in models(out, ("spot",) if quick else ("spot", "bob", "human", "stanford-bunny")):
        for fraction in radii:
            found_rows, _ = bench.compare(arrays, names, options(radius=fraction))
            means = [found_rows[name]["mean_percent_ae"] for name in names]
            rows.append([model, f"{100 * fraction:g} %", *means])
            curves.setdefault(model, []).append((100 * fraction, means[0]))
        bench.forget()
    out.table("Mean error in percent against the reference", ["model", "r", "H", "K", "LBE"], rows)

    def draw(axes):
        for model, points in curves.items():
            axes.loglog(*zip(*points, strict=True), marker="o", markersize=3, label=model)
        axes.set(xlabel="radius, % of the diagonal", ylabel="mean error of H, %")
        axes.legend(fontsize=7)

    out.plot("fig11", "Fig. 11 right, error: mean curvature over the radius", draw)


def detail(bench, out, quick):
    out.say(
        "One smooth surface at growing detail: spot subdivided by Loop's scheme, r = 4 %. *Own reference*: on the same"
        " mesh. *Finest*: the reference on the finest mesh, at the vertices that both have. The paper's error is high "
        "for coarse meshes, because its reference is coarse there, and steady above 100 K triangles."
    )
    spot = meshes.find("spot")
    if spot is None:
        out.lacks("spot.obj is not in shared/meshes beside the checkout.")
        return
    levels = [spot]
    for _ in range(1 if quick else 2):
        levels.append(meshes.loop_subdivide(levels[-1], 1))
    name = "mean_curvature"
    chosen = options(radius=0.04 * meshes.diagonal(levels[-1]), radius_unit="absolute")
    finest = bench.reference(levels[-1], [name], chosen).values[name]
    # Old vertices move while a mesh is subdivided, so each level gets the places that its vertices have in the end.
    rows, points = [], []
    for arrays in levels:
        arrays = meshes.moved(arrays, levels[-1].positions[: len(arrays.positions)])
        found, truth = bench.run(arrays, [name], chosen), bench.reference(arrays, [name], chosen)
        own = errors(name, found.values[name], truth.values[name], found.radius)
        far = errors(name, found.values[name], finest[: len(arrays.positions)], found.radius)
        theirs = errors(name, truth.values[name], finest[: len(arrays.positions)], found.radius)
        rows.append([len(arrays.triangle_corners), own.mean, own.p99, far.mean, theirs.mean])
        points.append((len(arrays.triangle_corners) / 1000, own.mean, far.mean))
    head = [
        "triangles",
        "own reference, mean",
        "p99",
        "finest, mean",
        "own reference against finest",
    ]
    out.table("Error of H in percent", head, rows)

    def draw(axes):
        x, own, far = zip(*points, strict=True)
        axes.loglog(x, own, marker="o", label="against its own reference")
        axes.loglog(x, far, marker="x", label="against the finest")
        axes.set(xlabel="thousand triangles", ylabel="mean error of H, %")
        axes.legend(fontsize=7)

    out.plot("fig11", "Fig. 11 left, error: mean curvature over geometric detail, r = 4 %", draw)


# ---- Area found


def area(bench, out, quick):
    out.say(
        "The area of the neighborhood that `affine` found, as a share of the reference's, which knows no texels: an "
        "independent check of `coverage`. Both should be 100 %; the share of a single vertex wavers with the texels at"
        " the ball's rim, and exceeds 100 % where a part is connected in the one and not in the other."
    )
    name, rows = "euclidean_area", []
    for model, arrays, _ in models(out, ("spot",) if quick else ("spot", "human")):
        for fraction in (0.02,) if quick else (0.02, 0.08):
            truth = bench.reference(arrays, [name], options(radius=fraction)).values[name]
            for size in (512, 1024) if quick else (512, 1024, 2048, 4096):
                found = bench.run(arrays, [name], options(radius=fraction, buffer_size=size, relocation="affine"))
                share = 100 * found.values[name] / truth
                share = share[np.isfinite(share)]
                cells = [share.mean(), *np.percentile(share, [0, 1, 50, 99]), 100 * found.field_report["coverage_mean"]]
                rows.append([model, f"{100 * fraction:g} %", f"{size}²", *cells])
        bench.forget()
    head = ["model", "r", "buffer", "area found, mean %", "lowest", "p1", "median", "p99", "coverage %"]
    out.table("Area found", head, rows)


# ---- Fragmented charts (Fig. 13)


def fragments(bench, out, quick):
    out.say(
        "One model with charts of two sizes. Coverage is the share of the neighborhood's area that was found; a vertex"
        " misses samples where it is below 0.999. *affine* "
        "carries each sample over at most so many seams, as the paper does. The paper's first missing sample with one "
        "jump: at 10 % on its fragmented bunny, none at 16 % on the other."
    )
    model = "rocker-arm" if quick else "stanford-bunny"
    bunny = meshes.find(model)
    if bunny is None:
        out.lacks(f"{model}.obj is not in shared/meshes beside the checkout.")
        return
    kinds = [
        (f"affine, {jumps} jump{'s' * (jumps != 1)}", {"relocation": "affine", "max_jumps": jumps})
        for jumps in (1, 2, 8)
    ]
    kinds.append(("paper, 1 jump", {"relocation": "paper", "max_jumps": 1}))
    radii = (0.02, 0.1) if quick else (0.02, 0.05, 0.1, 0.16)
    rows, curves, areas = [], {}, {}
    for fraction in radii[:2]:
        areas[fraction] = bench.reference(bunny, ["euclidean_area"], options(radius=fraction)).values["euclidean_area"]
    for cells in (2,) if quick else (2, 12):
        arrays = meshes.project_charts(bunny, cells)
        for label, variant in kinds[:2] if quick else kinds:
            for fraction in radii:
                try:
                    found = bench.run(arrays, ["euclidean_area"], options(radius=fraction, samples=64, **variant))
                except (MissingError, bridge.ParadescError) as error:
                    out.lacks(f"{label}: this build says {error}.")
                    break
                coverage = found.coverage[np.isfinite(found.coverage)]
                missing = 100 * (coverage < 0.999).mean()
                charts = int(found.mesh_report["charts"])
                share = (
                    100 * np.nanmean(found.values["euclidean_area"] / areas[fraction]) if fraction in areas else np.nan
                )
                rows.append(
                    [
                        charts,
                        label,
                        f"{100 * fraction:g} %",
                        100 * coverage.mean(),
                        float(coverage.min()),
                        missing,
                        share,
                    ]
                )
                curves.setdefault((charts, label), []).append((100 * fraction, 100 - 100 * coverage.mean()))
        bench.forget()
    out.table(
        f"{model}, 64 samples",
        ["charts", "relocation", "r", "coverage %", "lowest", "vertices that miss samples, %", "area to reference, %"],
        rows,
    )

    def draw(axes):
        for (charts, label), points in curves.items():
            axes.semilogy(
                [x for x, _ in points],
                [max(y, 1e-4) for _, y in points],
                marker="o",
                markersize=3,
                label=f"{charts} charts, {label}",
            )
        axes.set(xlabel="radius, % of the diagonal", ylabel="area not found, %")
        axes.legend(fontsize=6)

    out.plot("fig13", "Fig. 13: what is missed over the radius; 0.0001 stands for nothing", draw)


# ---- Genus 20 (Fig. 9)


def genus(bench, out, quick):
    try:
        arrays = make_rim()
    except ImportError:
        out.lacks(
            "Blender's Python module bpy is not installed, which makes the model (blend_samples/make_samples.py)."
        )
        return
    if arrays is None:
        out.lacks("blend_samples/make_samples.py makes no rim.")
        return
    names = ["mean_curvature", "gaussian_curvature", "shape_index", "local_bending_energy"]
    rows = []
    for fraction in (0.01,) if quick else (0.01, 0.02, 0.04):
        found_rows, found = bench.compare(arrays, names, options(radius=fraction))
        means = [found_rows[name]["mean_percent_ae"] for name in names]
        near, coverage = (found_rows[names[0]][column] for column in ("seam_mean_percent_ae", "coverage_mean"))
        seconds = float(found.field_report["seconds_total"])
        rows.append([f"{100 * fraction:g} %", *means, near, 100 * coverage, seconds])
        if fraction == 0.01:
            values = found.values[names[0]]
            span = (values, registry_row(names[0]), found.radius)
            image = compose(arrays, [(title_of(names[0]), values)], span, upright=False)
            out.picture("fig9", "Fig. 9: a rim of genus 20, mean curvature, r = 1 %", image)
    euler = meshes.euler_characteristic(arrays.triangle_vertices)
    out.say(
        f"A wheel made by `blend_samples/make_samples.py`: {len(arrays.triangle_corners):,} triangles, Euler "
        f"characteristic {euler}, so genus {(2 - euler) // 2}; {int(found.mesh_report['charts'])} charts, "
        f"{int(found.mesh_report['seam_edges'])} seam edges. The errors are those of `affine` in texture space."
    )
    head = ["r", *[LABELS[name] for name in names], "H near seams", "coverage %", "s"]
    out.table("Mean error in percent against the reference", head, rows)


def make_rim():
    """The rim of the sample scenes, or None if the script cannot make it."""
    import bpy

    from paradesc_blender.scene import mesh_io

    spec = importlib.util.spec_from_file_location("make_samples", SAMPLES_SCRIPT)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    if not hasattr(script, "make_rim"):
        return None
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return mesh_io.read_object(script.make_rim(), False)


SECTIONS = {
    "reference": (
        reference,
        "Against the reference (Fig. 8)",
        "1.245 % on average over models; Fig. 8 by descriptor",
        50,
        10,
    ),
    "radius": (
        radius,
        "Neighborhood size (Fig. 11 right, error)",
        "high at small radii, lowest between, rising at large ones",
        70,
        3,
    ),
    "detail": (
        detail,
        "Geometric detail (Fig. 11 left, error)",
        "high at 25 K and 50 K triangles, steady from 100 K to 1000 K",
        35,
        5,
    ),
    "area": (area, "Area found against coverage", "not measured", 60, 3),
    "fragments": (
        fragments,
        "Fragmented charts (Fig. 13)",
        "first missing sample at r = 10 % of the diagonal; none at 16 % with larger charts",
        90,
        15,
    ),
    "genus": (genus, "A model of genus 20 (Fig. 9)", "58 ms on a GTX 670; pictures only", 8, 4),
}
