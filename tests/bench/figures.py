"""Turns what was measured into the required ratios beside their targets; without a part, into None and a reason."""

from collections.abc import Callable
from dataclasses import dataclass, replace

Measured = dict[str, dict]
Value = Callable[[Measured], float]


@dataclass
class Figure:
    """One key of the JSON file."""

    target: float
    at_least: bool  # the target is a lower bound, not an upper one
    parts: tuple[str, ...]  # what it is made of, to give the reason if a part is missing
    value: Value
    meaning: str

    def met(self, value: float) -> bool:
        """Whether the target is reached."""
        return value >= self.target if self.at_least else value <= self.target


ALLOWED_ERROR = 0.5  # percent of the range, mean, against the reference
FINE_ERROR = 0.1  # the same, of the engine on the CPU where its speed is compared with the baseline's
CPU = "cpu"  # what this engine measured lies under this name within a part; what the device measured is the part itself
SIZES = ("100k", "1m", "2m")  # of the detail that is measured


def speedup(detail: dict, way: str) -> float:
    """The baseline's time over ours, on one mesh."""
    return detail["baseline"]["seconds"] / detail[way]["seconds"]


def share(gather: dict) -> float:
    """The part of the bare gather's rate at which an evaluation runs; the faster way to fetch counts."""
    bare = min(way["seconds"] for way in gather["bare"].values())
    return bare / gather["evaluate"]["seconds_evaluate"]


def preprocessing(m: Measured) -> float:
    """Seconds per million triangles for everything that later frames need not do again."""
    detail = m["detail_1m"]
    once = detail["once"]
    return (once["mesh"] + max(0.0, once["first_frame"] - detail["at_256"]["seconds"])) / (1e-6 * detail["triangles"])


def over_peer(name: str, way: str = "at_256") -> Value:
    """A peer's time over the time of our whole frame on the same mesh."""
    return lambda m: m["peers"][name]["seconds"] / m["bunny"][way]["seconds"]


def over_baseline(part: str, way: str) -> Value:
    """The baseline's time over ours, by the way in which we compute."""
    return lambda m: speedup(m[part], way)


def over_one(several: str) -> Value:
    """Several descriptors or radii at once against one."""
    return lambda m: m["together"][several]["seconds"] / m["together"]["one"]["seconds"]


def radius_growth(m: Measured) -> float:
    """Time at the large radius over that at the small one."""
    return m["radius"]["large"]["seconds"] / m["radius"]["small"]["seconds"]


def memory(m: Measured) -> float:
    """Peak memory without the device's buffers, over the input's."""
    found = m["memory"]
    return (found["peak_bytes"] - found["buffer_bytes"]) / found["input_bytes"]


def first_over_later(m: Measured) -> float:
    """The first bake of a fresh process over a later one."""
    return m["first_bake"]["first"] / m["first_bake"]["later"]


def bunny_milliseconds(m: Measured) -> float:
    """The whole frame with the default samples."""
    return 1e3 * m["bunny"]["at_256"]["seconds"]


def texels_milliseconds(m: Measured) -> float:
    """The evaluation at the texels of a map."""
    return 1e3 * m["texels"]["seconds_evaluate"]


def read_backs(m: Measured) -> float:
    """How often a frame reads back what the device computed, on either mesh."""
    return max(m[part]["read_backs"] for part in ("host_bunny", "host_1m"))


def error_over_peers(m: Measured) -> float:
    """Our error on the torus over the smallest of all peers."""
    theirs = [row["error_closed"] for row in m["peers"].values() if row.get("error_closed")]
    return m["errors_closed"]["at_256"] / min(theirs)


def on_cpu(value: Value) -> Value:
    """The same figure of the engine on the CPU: what it measured takes the place of what the device measured."""

    def of_cpu(m: Measured) -> float:
        shared = {name: part for name, part in m.items() if name == "peers"}
        return value(shared | {name: part | part[CPU] for name, part in m.items() if CPU in part})

    return of_cpu


FIGURES: dict[str, Figure] = {
    "speedup_100k": Figure(
        3,
        True,
        ("detail_100k",),
        over_baseline("detail_100k", "fewest"),
        "over the baseline at 100 K triangles, r = 4 %",
    ),
    "speedup_1m": Figure(
        50,
        True,
        ("detail_1m",),
        over_baseline("detail_1m", "fewest"),
        "over the baseline at 1 M triangles, r = 4 %",
    ),
    "speedup_2m": Figure(
        100,
        True,
        ("detail_2m",),
        over_baseline("detail_2m", "fewest"),
        "over the baseline at 2 M triangles, r = 4 %",
    ),
    "radius_growth": Figure(
        1.5, False, ("radius",), radius_growth, "time when the radius grows 8 times, 600 K triangles"
    ),
    "bunny_frame_ms": Figure(
        80,
        False,
        ("bunny",),
        bunny_milliseconds,
        "stanford-bunny, r = 2 %, 256 samples, the whole frame (a tenth of libigl's was 80 ms)",
    ),
    "host_ms_bunny": Figure(
        3,
        False,
        ("host_bunny",),
        lambda m: m["host_bunny"]["host_ms"],
        "processor time of that frame outside OpenGL's calls, all threads",
    ),
    "host_ms_1m": Figure(
        15, False, ("host_1m",), lambda m: m["host_1m"]["host_ms"], "the same at 1 M triangles, r = 4 %"
    ),
    "read_backs": Figure(1, False, ("host_bunny", "host_1m"), read_backs, "of one of these frames"),
    "over_libigl5": Figure(10, True, ("bunny", "libigl5"), over_peer("libigl5"), "libigl, 5 rings, over that frame"),
    "over_dirty": Figure(20, True, ("bunny", "dirty"), over_peer("dirty"), "Dirty Vertex Colors over that frame"),
    "over_pymeshlab_pca": Figure(
        75, True, ("bunny", "pymeshlab_pca"), over_peer("pymeshlab_pca"), "PyMeshLab's PCA over that frame"
    ),
    "gather_share_one_chart": Figure(
        0.6, True, ("gather_one_chart",), lambda m: share(m["gather_one_chart"]), "of the bare gather rate, one chart"
    ),
    "gather_share_many_charts": Figure(
        0.35, True, ("gather_many_charts",), lambda m: share(m["gather_many_charts"]), "the same, many charts"
    ),
    "eight_over_one": Figure(1.3, False, ("together",), over_one("eight"), "eight descriptors at once against one"),
    "three_radii_over_one": Figure(
        1.5, False, ("together",), over_one("three_radii"), "three radii at once against one"
    ),
    "preprocess_s_per_million": Figure(
        1, False, ("detail_1m",), preprocessing, "seconds of preprocessing per million triangles"
    ),
    "peak_memory_over_input": Figure(3, False, ("memory",), memory, "peak memory without buffers over the input's"),
    "python_overhead_ms": Figure(
        5,
        False,
        ("python",),
        lambda m: 1e3 * m["python"]["overhead_seconds"],
        "of a whole bake: Blender's mesh to arrays, bridge, values to an attribute",
    ),
}

# The engine on the CPU, all at vertices.
CPU_FIGURES: dict[str, Figure] = {
    "bunny_frame_ms": Figure(50, False, ("bunny",), bunny_milliseconds, "stanford-bunny, r = 2 %, 256 samples"),
    "bunny_error": Figure(0.1, False, ("bunny",), lambda m: m["bunny"]["at_256"]["error"], "that frame's error in %"),
    "over_libigl5": Figure(12, True, ("bunny", "libigl5"), over_peer("libigl5"), "libigl, 5 rings, over that frame"),
    "over_dirty": Figure(20, True, ("bunny", "dirty"), over_peer("dirty"), "Dirty Vertex Colors over that frame"),
    "over_pymeshlab_pca": Figure(
        75, True, ("bunny", "pymeshlab_pca"), over_peer("pymeshlab_pca"), "PyMeshLab's PCA over that frame"
    ),
    "over_cgal": Figure(
        13, True, ("bunny", "cgal"), over_peer("cgal", "one_core"), "CGAL at that radius over that frame, one core each"
    ),
    "discrete_over_bunny_fewest": Figure(
        1,
        True,
        ("bunny", "pymeshlab_discrete"),
        over_peer("pymeshlab_discrete", "fewest"),
        "PyMeshLab's discrete method over the frame with the fewest samples",
    ),
    "error_over_peers": Figure(
        1, False, ("errors on the torus",), error_over_peers, "error on the torus over the best peer's"
    ),
    "speedup_1m": Figure(
        25, True, ("detail_1m",), over_baseline("detail_1m", "fine"), "baseline, 1 M triangles, r = 4 %, error ≤ 0.1 %"
    ),
    "speedup_2m": Figure(60, True, ("detail_2m",), over_baseline("detail_2m", "fine"), "the same at 2 M triangles"),
    "speedup_models": Figure(
        2, True, ("models",), lambda m: m["models"]["as they are"], "mean of the sweep over models, error ≤ 0.1 %"
    ),
    "speedup_models_subdivided": Figure(
        25, True, ("models",), lambda m: m["models"]["subdivided"], "the same, subdivided"
    ),
    "radius_growth": Figure(1.5, False, ("radius",), radius_growth, "time when the radius grows 8 times"),
    "three_radii_over_one": Figure(2, False, ("together",), over_one("three_radii"), "three radii at once against one"),
    "eight_over_one": Figure(1.3, False, ("together",), over_one("eight"), "eight descriptors at once against one"),
    "sixteen_over_one": Figure(2, False, ("together",), over_one("sixteen"), "all without operators on a map"),
    "twenty_over_one": Figure(5, False, ("together",), over_one("twenty"), "all"),
    "peak_memory_over_input": Figure(5, False, ("memory",), memory, "peak memory over the input's, 1 M triangles"),
    "preprocess_s_per_million": Figure(
        0.7, False, ("detail_1m",), preprocessing, "seconds of preprocessing per million triangles"
    ),
    "first_over_later": Figure(
        1.3, False, ("first_bake",), first_over_later, "the first bake in a fresh process over a later one"
    ),
}
FIGURES |= {f"{CPU}_{name}": replace(row, value=on_cpu(row.value)) for name, row in CPU_FIGURES.items()}

# What is asked for of a graphics card, an H200.
CARD_FIGURES: dict[str, Figure] = {
    "bunny_frame_ms": Figure(
        2, False, ("bunny",), bunny_milliseconds, "stanford-bunny, r = 2 %, 256 samples, the frame"
    ),
    "texels_512_ms": Figure(
        1, False, ("texels",), texels_milliseconds, "512² texels, 256 samples, the evaluation and reading its maps back"
    ),
    "frame_1m_ms": Figure(
        10,
        False,
        ("detail_1m",),
        lambda m: 1e3 * m["detail_1m"]["fewest"]["seconds"],
        f"1 M triangles, r = 4 %, error ≤ {ALLOWED_ERROR:g} %, the frame",
    ),
    "speedup_1m": Figure(
        1000, True, ("detail_1m",), over_baseline("detail_1m", "fewest"), "the baseline over that frame, times"
    ),
}

# Figures that stand beside them and have no targets.
BESIDE: dict[str, Value] = {
    **{f"speedup_{size}_256_samples": over_baseline(f"detail_{size}", "at_256") for size in SIZES},
    **{f"speedup_{size}_at_texels": over_baseline(f"detail_{size}", "at_texels") for size in SIZES},
    **{f"speedup_{size}_max_normals": over_baseline(f"detail_{size}", "max_normals") for size in SIZES},
    "texels_512_ms": texels_milliseconds,
    "frame_1m_256_samples_ms": lambda m: 1e3 * m["detail_1m"]["at_256"]["seconds"],
    "bunny_fewest_frame_ms": lambda m: 1e3 * m["bunny"]["fewest"]["seconds"],
    "discrete_over_bunny_fewest": over_peer("pymeshlab_discrete", "fewest"),
    "over_pymeshlab_pca_same_radius": over_peer("pymeshlab_pca_same_radius"),
    "over_libigl2": over_peer("libigl2"),
    "over_trimesh": over_peer("trimesh"),
    "over_pymeshlab_quadric": over_peer("pymeshlab_quadric"),
    "over_cgal": over_peer("cgal"),
    "over_pymeshlab_apss8": over_peer("pymeshlab_apss8"),
    "sixteen_over_one": over_one("sixteen"),
    "twenty_over_one": over_one("twenty"),
    "first_over_later": first_over_later,
    "baseline_faster_than_trimesh": over_peer("trimesh", "baseline"),
    "baseline_faster_than_pymeshlab_quadric": over_peer("pymeshlab_quadric", "baseline"),
    "baseline_neighbors_per_second_and_core": lambda m: m["detail_1m"]["baseline"]["neighbors_per_second_and_core"],
    "cpu_speedup_100k": on_cpu(over_baseline("detail_100k", "fine")),
    "cpu_over_pymeshlab_apss8": on_cpu(over_peer("pymeshlab_apss8")),
    "cpu_over_trimesh": on_cpu(over_peer("trimesh")),
    **{f"cpu_speedup_{size}_at_half_a_percent": on_cpu(over_baseline(f"detail_{size}", "fewest")) for size in SIZES},
}


def figures(
    measured: Measured, reasons: dict[str, str], rows: dict[str, Figure] = FIGURES
) -> tuple[dict[str, float | None], dict[str, str]]:
    """Every key's value or None, and why it is None; reasons says for each part why it is missing."""
    values: dict[str, float | None] = {}
    why: dict[str, str] = {}
    for name, figure in rows.items():
        try:
            values[name] = rounded(figure.value(measured))
        except KeyError:
            values[name] = None
            why[name] = " ".join(reasons[part] for part in figure.parts if part in reasons) or "Not measured."
    return values, why


def beside(measured: Measured) -> dict[str, float]:
    """The figures of BESIDE that can be computed."""
    found = {}
    for name, value in BESIDE.items():
        try:
            found[name] = rounded(value(measured))
        except KeyError:
            continue
    return found


def rounded(value: float) -> float:
    """Rounds to four significant digits."""
    return float(f"{value:.4g}")
