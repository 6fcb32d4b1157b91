"""Sections on what trades time for error: samples (Table 1, Fig. 7), buffers (Table 2), both and texels (Fig. 12)."""

import numpy as np
from bench import MissingError, has, options
from sections_models import compose, models

from paradesc import bridge
from paradesc.core.job import registry_row

NAME = "mean_curvature"
AVERAGED = ("spot", "bob", "human", "rocker-arm")
PAPER_TABLE_1 = {64: (1.172, 1.331), 100: (1.035, 1.110), 256: (1.005, 1.007), 400: (0.789, 0.824)}
PAPER_TABLE_2 = {(512, "full"): 1.662, (512, "half"): 1.725, (1024, "full"): 1.307, (1024, "half"): 1.384}
ADAPTIVE = 0.05  # the threshold, the command line's
INTEGRAL = {"estimator": "integral", "variance_reduction": "none"}


def average(bench, meshes, names, **chosen):
    """The mean error of H over the meshes, in texture space."""
    chosen = options(relocation="affine", **chosen)
    return float(np.mean([bench.compare(arrays, names, chosen)[0][NAME]["mean_percent_ae"] for arrays in meshes]))


def attempt(bench, out, meshes, **chosen):
    """Runs average(), or gives a dash and adds a sentence."""
    try:
        return average(bench, meshes, [NAME], **chosen)
    except MissingError as missing:
        out.lacks(f"this build has no option {missing}.")
    except bridge.ParadescError as error:
        out.lacks(f"refused: {error.sentence}")
    return np.nan


def samples(bench, out, quick):
    chosen = list(models(out, AVERAGED[:1] if quick else AVERAGED))
    if not chosen:
        return
    arrays = [row[1] for row in chosen]
    out.say(
        f"Mean curvature averaged over {', '.join(row[0] for row in chosen)}, r = 2 %, in texture space by "
        f"`affine`, against the reference. *As in the paper*: the sphere-volume integral without control variate. "
        "Adaptive: half of the samples first, the rest where they vary."
    )
    rows, points = [], {}
    for count in (16, 64, 256) if quick else (16, 32, 64, 100, 256, 400):
        full = attempt(bench, out, arrays, samples=count)
        adaptive = attempt(bench, out, arrays, samples=count, adaptive=ADAPTIVE)
        plain = attempt(bench, out, arrays, samples=count, **INTEGRAL)
        plain_adaptive = attempt(bench, out, arrays, samples=count, adaptive=ADAPTIVE, **INTEGRAL)
        paper = PAPER_TABLE_1.get(count, (np.nan, np.nan))
        rows.append([count, *paper, full, adaptive, plain, plain_adaptive])
        for label, value in (
            ("paper", paper[0]),
            ("here", full),
            ("here, adaptive", adaptive),
            ("here, as in the paper", plain),
        ):
            points.setdefault(label, []).append((count, value))
    plain_heads = ["as in the paper, full", "as in the paper, adaptive"]
    head = ["samples", "paper, full", "paper, adaptive", "full", "adaptive", *plain_heads]
    out.table("Table 1: mean error of H in percent", head, rows)

    def draw(axes):
        for label, line in points.items():
            if np.isfinite([y for _, y in line]).any():
                axes.loglog(*zip(*line, strict=True), marker="o", markersize=3, label=label)
        axes.set(xlabel="samples", ylabel="mean error of H, %")
        axes.legend(fontsize=7)

    out.plot("table1", "Table 1: error over the number of samples", draw)
    if not quick:
        pictures(bench, out, arrays[0])


def pictures(bench, out, arrays):
    """Draws Fig. 7: the reference, then full and adaptive sampling."""
    truth = bench.reference(arrays, [NAME], options(radius=0.02))
    shown = [("REFERENCE", truth.values[NAME])]
    for count in (64, 256):
        shown.append(
            (f"FULL {count}", bench.run(arrays, [NAME], options(samples=count, relocation="affine")).values[NAME])
        )
    if has("adaptive"):
        for count in (64, 128, 256):
            found = bench.run(arrays, [NAME], options(samples=count, adaptive=ADAPTIVE))
            shown.append((f"ADAPTIVE {count // 2}/{count}", found.values[NAME]))
    else:
        out.lacks("this build has no option adaptive, so Fig. 7 has no adaptive pictures.")
    from sections_models import halved

    span = (truth.values[NAME], registry_row(NAME), truth.radius)
    out.picture(
        "fig7",
        "Fig. 7: mean curvature of the reference, and by full and adaptive sampling",
        halved(compose(arrays, shown, span)),
    )


def buffers(bench, out, quick):
    chosen = list(models(out, AVERAGED[:1] if quick else AVERAGED))
    if not chosen:
        return
    arrays = [row[1] for row in chosen]
    out.say(
        f"Mean curvature averaged over {', '.join(row[0] for row in chosen)}, r = 2 %, 256 samples, in texture "
        f"space by `affine`, against the reference."
    )
    rows = []
    for size in (512, 1024) if quick else (256, 512, 1024, 2048):
        for precision in ("full", "half"):
            wanted = {"precision": precision} if precision != "full" or has("precision") else {}
            ours = attempt(bench, out, arrays, buffer_size=size, **wanted)
            plain = attempt(bench, out, arrays, buffer_size=size, **wanted, **INTEGRAL)
            rows.append([f"{size}²", precision, PAPER_TABLE_2.get((size, precision), np.nan), ours, plain])
    head = ["buffer", "precision", "paper", "here", "here, as in the paper"]
    out.table("Table 2: mean error of H in percent", head, rows)


def tradeoff(bench, out, quick):
    chosen = list(models(out, AVERAGED[:1] if quick else AVERAGED[:3]))
    if not chosen:
        return
    arrays = [row[1] for row in chosen]
    out.say(
        f"Mean curvature averaged over {', '.join(row[0] for row in chosen)}, r = 2 %, in texture space by `affine`. "
        f"The paper evaluates texels and looks vertices up; evaluation at the vertices themselves is exact "
        "there and is the default."
    )
    places = [("vertices", {})] + [
        (f"{size}² texels", {"evaluate": "texel", "texels": size}) for size in (256, 512, 1024)
    ]
    rows, curves = [], {}
    for size in (512, 1024) if quick else (512, 1024, 2048):
        for label, variant in places[:2] if quick else places:
            means = []
            for count in (16, 64, 256):
                mean = attempt(bench, out, arrays, buffer_size=size, samples=count, **variant)
                means.append(mean)
                if np.isnan(mean):
                    break
            if not np.isnan(means[-1]):
                rows.append([f"{size}²", label, *means])
                curves[f"{size}² / {label}"] = means
    out.table("Mean error of H in percent", ["buffer", "evaluated at", "16 samples", "64", "256"], rows)

    def draw(axes):
        for label, means in curves.items():
            axes.loglog((16, 64, 256), means, marker="o", markersize=3, label=label)
        axes.set(xlabel="samples", ylabel="mean error of H, %")
        axes.legend(fontsize=6)

    out.plot("fig12", "Fig. 12, error: samples, buffer and texels evaluated", draw)


SECTIONS = {
    "samples": (samples, "Samples, full and adaptive (Table 1, Fig. 7)", "Table 1, in the columns below", 35, 2),
    "buffers": (buffers, "Buffers and precision (Table 2)", "Table 2, in the column below", 30, 2),
    "tradeoff": (
        tradeoff,
        "Samples, buffers, texels (Fig. 12, error)",
        "0.8 to 1.7 % between the extremes of Tables 1 and 2; plots only",
        40,
        2,
    ),
}
