"""Turns what was measured into the required ratios beside their targets; without a part, into None and a reason."""

from collections.abc import Callable
from dataclasses import dataclass

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
        """Returns whether the target is reached."""
        return value >= self.target if self.at_least else value <= self.target


ALLOWED_ERROR = 0.5  # percent of the range, mean, against the reference
FINE_ERROR = 0.1  # the same, where our speed is compared with the baseline's
SIZES = ("100k", "1m", "2m")  # of the detail that is measured


def speedup(detail: dict, way: str) -> float:
    """The baseline's time over ours, on one mesh."""
    return detail["baseline"]["seconds"] / detail[way]["seconds"]


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
    """Peak memory over the input's."""
    return m["memory"]["peak_bytes"] / m["memory"]["input_bytes"]


def first_over_later(m: Measured) -> float:
    """The first bake of a fresh process over a later one."""
    return m["first_bake"]["first"] / m["first_bake"]["later"]


def bunny_milliseconds(m: Measured) -> float:
    """The whole frame with the default samples."""
    return 1e3 * m["bunny"]["at_256"]["seconds"]


def error_over_peers(m: Measured) -> float:
    """Our error on the torus over the smallest of all peers."""
    theirs = [row["error_closed"] for row in m["peers"].values() if row.get("error_closed")]
    return m["errors_closed"]["at_256"] / min(theirs)


FIGURES: dict[str, Figure] = {
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
    "python_overhead_ms": Figure(
        5,
        False,
        ("python",),
        lambda m: 1e3 * m["python"]["overhead_seconds"],
        "of a whole bake: Blender's mesh to arrays, bridge, values to an attribute",
    ),
}

# Figures that stand beside them and have no targets.
BESIDE: dict[str, Value] = {
    "speedup_100k": over_baseline("detail_100k", "fine"),
    **{f"speedup_{size}_at_half_a_percent": over_baseline(f"detail_{size}", "fewest") for size in SIZES},
    **{f"speedup_{size}_256_samples": over_baseline(f"detail_{size}", "at_256") for size in SIZES},
    **{f"speedup_{size}_max_normals": over_baseline(f"detail_{size}", "max_normals") for size in SIZES},
    "frame_1m_256_samples_ms": lambda m: 1e3 * m["detail_1m"]["at_256"]["seconds"],
    "bunny_fewest_frame_ms": lambda m: 1e3 * m["bunny"]["fewest"]["seconds"],
    "over_pymeshlab_pca_same_radius": over_peer("pymeshlab_pca_same_radius"),
    "over_libigl2": over_peer("libigl2"),
    "over_trimesh": over_peer("trimesh"),
    "over_pymeshlab_quadric": over_peer("pymeshlab_quadric"),
    "over_pymeshlab_apss8": over_peer("pymeshlab_apss8"),
    "baseline_faster_than_trimesh": over_peer("trimesh", "baseline"),
    "baseline_faster_than_pymeshlab_quadric": over_peer("pymeshlab_quadric", "baseline"),
    "baseline_neighbors_per_second_and_core": lambda m: m["detail_1m"]["baseline"]["neighbors_per_second_and_core"],
}


def figures(measured: Measured, reasons: dict[str, str]) -> tuple[dict[str, float | None], dict[str, str]]:
    """Every key's value or None, and why it is None; reasons says for each part why it is missing."""
    values: dict[str, float | None] = {}
    why: dict[str, str] = {}
    for name, figure in FIGURES.items():
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
