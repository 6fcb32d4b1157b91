"""Sections on surfaces with closed forms: error, settings, radius of the integral K, coarse meshes."""

import baseline
import meshes
import numpy as np
import surfaces
from bench import MissingError, angle, directions, errors, options, registry

from paradesc import bridge
from paradesc.core.job import registry_row

LABELS = {
    "mean_curvature": "H",
    "gaussian_curvature": "K",
    "principal_curvature_max": "k1",
    "principal_curvature_min": "k2",
    "shape_index": "shape index",
    "curvedness": "curvedness",
    "local_bending_energy": "LBE",
    "sphere_volume": "V",
    "sphere_volume_normalized": "V / ball",
    "euclidean_area": "EA",
    "geodesic_area": "GA",
}
CURVATURES = [
    name
    for name in LABELS
    if name not in ("sphere_volume", "sphere_volume_normalized", "euclidean_area", "geodesic_area")
]
# Areas and volumes are measured against those of a plane, because their own range is a small part of them.
PLANE = {
    "sphere_volume_normalized": lambda r: 0.5,
    "euclidean_area": lambda r: np.pi * r**2,
    "geodesic_area": lambda r: np.pi * r**2,
}


def inside(surface, radius):
    """(n,) bool: away from open sides, where fitted normals are one-sided and reach half a radius further."""
    return surface.boundary_distance > 1.5 * radius


def pair(ours, reference):
    return f"{ours:.3f} ({reference:.3f})"


def closed(bench, out, quick):
    out.say(
        "Mean error in percent and, in parentheses, of the reference, against the limit r → 0. Both errors "
        "contain the bias of a finite support and the errors of the mesh's facets and fitted normals; only Paradesc's "
        "contains the error of its sums. Open surfaces: vertices 1.5 r away from the boundary."
    )
    names = [name for name in registry() if name in LABELS]
    curvatures = [name for name in names if name in CURVATURES]
    chosen = ("torus", "cylinder") if quick else tuple(surfaces.SURFACES)
    rows, sizes, turned = [], [], []
    sums = {name: [] for name in curvatures}
    for surface_name in chosen:
        for irregular in (False, True):
            surface = surfaces.SURFACES[surface_name](irregular=irregular)
            for radius in (0.02,) if quick else (0.01, 0.02):
                closed_row(bench, surface, irregular, radius, curvatures, sums, rows)
                if irregular and radius == 0.02:
                    size_row(bench, surface, names, sizes)
                    turned += direction_rows(bench, surface, radius)
            bench.forget()
    summary = [[LABELS[name], *np.mean(sums[name], axis=0), np.max(sums[name], axis=0)[0]] for name in curvatures]
    out.table(
        f"Over all {len(rows)} cases below",
        ["descriptor", "mean of cases", "reference", "worst case"],
        summary,
    )
    head = ["surface", "triangles", "r", *[LABELS[name] for name in curvatures]]
    out.table("Every case: Paradesc (reference)", head, rows)
    out.table(
        "Areas and volume, irregular meshes, r = 2 %: mean |error| in percent of the plane's value, "
        "Paradesc (reference). Against the smooth surface, so the depth of the facets below it counts for both",
        ["surface", *[LABELS[name] for name in names if name in PLANE]],
        sizes,
    )
    if directions():
        out.table("Principal directions: mean angle, weighted by |k1 − k2|", ["surface", "max", "min"], turned)
    else:
        out.lacks("principal_direction_max and principal_direction_min are not in this build.")


def case(bench, surface, radius, names, **chosen):
    """Our results and the reference's, and the radius in units of the positions."""
    chosen = options(radius=radius, **chosen)
    found, truth = bench.run(surface.arrays, names, chosen), bench.reference(surface.arrays, names, chosen)
    return found, truth, found.radius


def closed_row(bench, surface, irregular, radius, curvatures, sums, rows):
    names = registry()
    found, truth, r = case(bench, surface, radius, names)
    cells = []
    for name in curvatures:
        exact, subset = surface.exact(name, r), inside(surface, r)
        both = [errors(name, part.values[name], exact, r, subset).mean for part in (found, truth)]
        sums[name].append(both)
        cells.append(pair(*both))
    kind = "irregular" if irregular else "regular"
    rows.append(
        [
            surface.name,
            f"{kind}, {len(surface.arrays.triangle_corners):,}",
            f"{100 * radius:g} %",
            *cells,
        ]
    )


def size_row(bench, surface, names, rows):
    found, truth, r = case(bench, surface, 0.02, registry())
    cells = []
    for name in (name for name in names if name in PLANE):
        exact, subset = surface.exact(name, r), inside(surface, r)
        share = [100 * np.abs(part.values[name] - exact)[subset].mean() / PLANE[name](r) for part in (found, truth)]
        cells.append(pair(*share))
    rows.append([surface.name, *cells])


def direction_rows(bench, surface, radius):
    if not surface.directions or not directions():
        return []
    names = [*directions(), "principal_curvature_max", "principal_curvature_min"]
    found, truth, r = case(bench, surface, radius, names)
    spread = np.abs(surface.exact("principal_curvature_max", r) - surface.exact("principal_curvature_min", r))
    cells = []
    for name in ("principal_direction_max", "principal_direction_min"):
        both = [angle(part.values[name], surface.exact(name, r), spread, inside(surface, r)) for part in (found, truth)]
        cells.append(f"{both[0]:.3f}° ({both[1]:.3f}°)")
    return [[surface.name, *cells]]


# ---- Settings

PLAIN = {"estimator": "integral", "variance_reduction": "none"}
VARIANTS = [
    {},
    *[{"samples": samples} for samples in (16, 32, 64, 128, 1024)],
    *[{"relocation": "affine", "buffer_size": size} for size in (512, 2048)],
    {"relocation": "affine", "precision": "half"},
    {"normals": "max"},
    {"distance": "geodesic"},
    {"relocation": "affine"},
    {"relocation": "affine", "adaptive": 0.02},
    {"relocation": "paper"},
    {"relocation": "affine", "pattern": "stratified"},
    {"relocation": "affine", "ellipse": "directional"},
    {"relocation": "affine", "variance_reduction": "none"},
    *[{"estimator": "integral", "samples": samples} for samples in (16, 32, 64, 256)],
    *[{**PLAIN, "samples": samples} for samples in (16, 32, 64, 256)],
    {"relocation": "affine", "estimator": "integral", "geodesic": "chords"},
]
QUICK_VARIANTS = [{}, {"samples": 64}, {"relocation": "affine"}, {"estimator": "integral"}]


def settings(bench, out, quick):
    out.say(
        "Irregular torus and ellipsoid of many charts, mean error in percent against the closed form. The first row of"
        " each block is the default; the others change what they name."
    )
    variants = QUICK_VARIANTS if quick else VARIANTS
    names = ["mean_curvature", "gaussian_curvature", "local_bending_energy", "shape_index", "sphere_volume_normalized"]
    for make in (surfaces.torus,) if quick else (surfaces.torus, surfaces.ellipsoid):
        surface = make(vertices=20000, charts=3)
        rows = []
        for radius in (0.01, 0.02):
            for variant in variants:
                cells = setting_cells(bench, out, surface, radius, names, variant)
                if cells:
                    rows.append([f"{100 * radius:g} %", *cells])
        out.table(
            f"{surface.name.capitalize()}, {len(surface.arrays.triangle_corners):,} triangles",
            ["r", "settings", *[LABELS[name] for name in names[:4]], "V / ball, % of 0.5"],
            rows,
        )
        bench.forget()


def setting_cells(bench, out, surface, radius, names, variant):
    """A row's cells; None if this build lacks a setting, and then it adds a sentence."""
    try:
        found = bench.run(surface.arrays, names, options(radius=radius, **variant))
    except MissingError as missing:
        out.lacks(f"this build has no option {missing}.")
        return None
    except bridge.ParadescError as error:
        out.lacks(f"{variant} is refused: {error.sentence}")
        return None
    r = found.radius
    means = [errors(name, found.values[name], surface.exact(name, r), r).mean for name in names[:4]]
    volume = 100 * np.abs(found.values[names[4]] - surface.exact(names[4], r)).mean() / 0.5
    text = ", ".join(f"{name} {value}" for name, value in variant.items()) or "default"
    return [text, *means, volume]


# ---- Integral K


def integral_k(bench, out, quick):
    out.say(
        "Gaussian curvature from the area of geodesic disks divides a tiny difference by r⁴, so it has a smallest "
        "usable radius: where the error falls below 5 %. The shape operator has none in this range."
    )
    lines = {
        "shape operator": {},
        "integral": {"estimator": "integral"},
        "integral, 1024 samples": {"estimator": "integral", "samples": 1024},
        "integral, chords": {"estimator": "integral", "geodesic": "chords", "relocation": "affine"},
    }
    radii = (0.01, 0.02, 0.04, 0.08) if quick else (0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06, 0.08, 0.12)
    curves, rows = {}, []
    for make in (surfaces.torus,) if quick else (surfaces.sphere, surfaces.torus, surfaces.ellipsoid):
        surface = make(charts=3)
        for label, variant in lines.items():
            means = sweep_k(bench, out, surface, radii, variant)
            if not means:
                continue
            curves[f"{surface.name}, {label}"] = means
            usable = [radius for radius, mean in zip(radii, means, strict=True) if mean < 5]
            rows.append([surface.name, label, *means, f"{100 * min(usable):g} %" if usable else "none"])
        bench.forget()
    head = ["surface", "K by", *[f"r = {100 * radius:g} %" for radius in radii], "usable from"]
    out.table("Mean error of K against the closed form, percent", head, rows)

    def draw(axes):
        for label, means in curves.items():
            axes.loglog([100 * radius for radius in radii], means, marker="o", markersize=3, label=label)
        axes.axhline(5, color="0.7", linewidth=0.8)
        axes.set(xlabel="radius, % of the diagonal", ylabel="mean error of K, %")
        axes.legend(fontsize=6)

    out.plot("radius", "Error of the Gaussian curvature over the radius", draw)


def extrapolation(bench, out, quick):
    out.say(
        "The integral H is off by a term in r², which Richardson's step from r and r/2 takes away; facets leave "
        "another in (edge/r)², which the step enlarges. So it pays for radii above a dozen mean edges."
    )
    radii = (0.04, 0.08) if quick else (0.02, 0.04, 0.08, 0.12, 0.16)
    rows = []
    for make in (surfaces.torus,) if quick else (surfaces.torus, surfaces.ellipsoid):
        surface = make(charts=3)
        edges = None
        for estimator in ("integral", "extrapolated"):
            means = []
            for radius in radii:
                found = bench.run(surface.arrays, ["mean_curvature"], options(radius=radius, estimator=estimator))
                values, exact = found.values["mean_curvature"], surface.exact("mean_curvature", found.radius)
                means.append(errors("mean_curvature", values, exact, found.radius).mean)
                edges = found.mesh_report["mean_edge"] / surface.diagonal
            rows.append([surface.name, estimator, *means, f"{100 * edges:.2f} %"])
        bench.forget()
    head = ["surface", "H by", *[f"r = {100 * radius:g} %" for radius in radii], "mean edge"]
    out.table("Mean error of H against the closed form, percent, 256 samples", head, rows)


def sweep_k(bench, out, surface, radii, variant):
    name, means = "gaussian_curvature", []
    for radius in radii:
        try:
            found = bench.run(surface.arrays, [name], options(radius=radius, **variant))
        except MissingError as missing:
            out.lacks(f"this build has no option {missing}; the curve that needs it is left out.")
            return None
        except bridge.ParadescError as error:
            out.lacks(f"{variant} is refused: {error.sentence}")
            return None
        means.append(errors(name, found.values[name], surface.exact(name, found.radius), found.radius).mean)
    return means


# ---- Coarse against fine (Fig. 2)


def coarse(bench, out, quick):
    out.say(
        "A coarse mesh whose vertices lie on the fine surface, and a small radius. The object-space baseline sums over"
        " the vertices within r, weighted by their areas, as the paper's does; Paradesc interpolates between them. "
        "Both against the fine surface: the closed form of a torus, and for a model the reference on its fine mesh."
    )
    rows, curves = [], {}
    for vertices in (1500,) if quick else (800, 1500, 3000):
        surface = surfaces.torus(vertices=vertices, charts=3)
        label = f"torus, {len(surface.arrays.triangle_corners):,} triangles"
        for radius in (0.02, 0.03, 0.04, 0.06):
            r = radius * surface.diagonal
            coarse_row(bench, label, surface.arrays, radius, surface.exact("mean_curvature", r), rows, curves)
        bench.forget()
    spot = meshes.find("spot")
    if spot is None:
        out.lacks("spot.obj is not in shared/meshes beside the checkout.")
    else:
        fine = meshes.loop_subdivide(spot, 1 if quick else 2)
        few = meshes.moved(spot, fine.positions[: len(spot.positions)])
        for radius in (0.03,) if quick else (0.02, 0.03, 0.04, 0.06):
            chosen = options(radius=radius * meshes.diagonal(few), radius_unit="absolute")
            truth = bench.reference(fine, ["mean_curvature"], chosen).values["mean_curvature"][: len(few.positions)]
            label = f"spot, {len(few.triangle_corners):,} against {len(fine.triangle_corners):,} triangles"
            coarse_row(bench, label, few, radius, truth, rows, curves)
        pictures_of_coarse(bench, out, few, fine)
    head = ["mesh", "r", "vertices in the ball", "baseline", "baseline, p99", "Paradesc", "p99", "baseline / Paradesc"]
    out.table("Error of H in percent, mean and 99th percentile", head, rows)

    def draw(axes):
        for label, points in curves.items():
            x, base, ours = zip(*points, strict=True)
            (line,) = axes.semilogy(x, ours, marker="o", markersize=3, label=f"{label}, Paradesc")
            axes.semilogy(x, base, marker="x", linestyle="--", color=line.get_color(), label="the same, baseline")
        axes.set(xlabel="radius, % of the diagonal", ylabel="mean error of H, %")
        axes.legend(fontsize=6)

    out.plot("radius", "Coarse meshes: the baseline (dashed) and Paradesc", draw)


def coarse_row(bench, label, arrays, radius, truth, rows, curves):
    name = "mean_curvature"
    found = bench.run(arrays, [name], options(radius=radius))
    values, count = baseline.mean_curvature(arrays, found.radius)
    theirs, ours = (errors(name, part, truth, found.radius) for part in (values, found.values[name]))
    rows.append(
        [
            label,
            f"{100 * radius:g} %",
            float(count),
            theirs.mean,
            theirs.p99,
            ours.mean,
            ours.p99,
            theirs.mean / ours.mean,
        ]
    )
    curves.setdefault(label, []).append((100 * radius, theirs.mean, ours.mean))


def pictures_of_coarse(bench, out, few, fine):
    """Draws Fig. 2: baseline and Paradesc on both meshes, in the colors of the fine truth."""
    from sections_models import compose

    name, radius = "mean_curvature", 0.03
    r = radius * meshes.diagonal(few)
    chosen = options(radius=r, radius_unit="absolute")
    on_few, on_fine = (bench.run(arrays, [name], chosen).values[name] for arrays in (few, fine))
    shown = bench.reference(fine, [name], chosen).values[name]
    theirs, _ = baseline.mean_curvature(few, r)
    span = (shown, registry_row(name), r)
    image = compose(few, [("BASELINE COARSE", theirs), ("PARADESC COARSE", on_few)], span)
    other = compose(fine, [("PARADESC FINE", on_fine)], span)
    out.picture(
        "fig2",
        "Fig. 2, r = 3 %: the baseline and Paradesc on the coarse mesh, Paradesc on the fine mesh",
        np.concatenate([image, other], axis=1),
    )


SECTIONS = {
    "closed": (closed, "Closed forms", "not measured", 80, 10),
    "settings": (
        settings,
        "Settings against closed forms",
        "not measured; buffers 1024², 256 samples, stratified grid",
        50,
        3,
    ),
    "extrapolation": (
        extrapolation,
        "Extrapolated integral of the mean curvature",
        "equation (8), no figure",
        40,
        10,
    ),
    "integral-k": (
        integral_k,
        "Usable radius of the integral Gaussian curvature",
        "equations (11) to (14), no figure",
        50,
        3,
    ),
    "coarse": (coarse, "Coarse meshes, small radius (Fig. 2)", "Fig. 2, r = 3 %: pictures only", 70, 13),
}
