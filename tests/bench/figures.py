"""Turns what was measured into the required ratios beside their targets; without a part, into None and a reason."""

from collections.abc import Callable
from dataclasses import dataclass

Measured = dict[str, dict]


@dataclass
class Figure:
    """One key of the JSON file."""

    target: float
    at_least: bool  # the target is a lower bound, not an upper one
    parts: tuple[str, ...]  # what it is made of, to give the reason if a part is missing
    value: Callable[[Measured], float]
    meaning: str

    def met(self, value: float) -> bool:
        """Whether the target is reached."""
        return value >= self.target if self.at_least else value <= self.target


ALLOWED_ERROR = 0.5  # percent of the range, mean, against the reference
WAYS = ("fewest", "max_normals", "at_texels")


def speedup(detail: dict, way: str) -> float:
    """The baseline's time over ours, on one mesh."""
    return detail["baseline"]["seconds"] / detail[way]["seconds"]


def best_speedup(detail: dict) -> float:
    """The speedup of the fastest way that keeps the error."""
    good = [way for way in WAYS if way in detail and detail[way]["error"] <= ALLOWED_ERROR]
    return max(speedup(detail, way) for way in good or ["fewest"])


def share(gather: dict) -> float:
    """The part of the bare gather's rate at which an evaluation runs; the faster way to fetch counts."""
    bare = min(way["seconds"] for way in gather["bare"].values())
    return bare / gather["evaluate"]["seconds_evaluate"]


def preprocessing(detail: dict) -> float:
    """Seconds per million triangles for everything that later frames need not do again."""
    frame = detail["at_256"]["seconds"]
    once = detail["once"]
    return (once["mesh"] + max(0.0, once["first_frame"] - frame)) / (1e-6 * detail["triangles"])


def over_peer(name: str) -> Callable[[Measured], float]:
    """A peer's time over the time of our whole frame on the same mesh."""
    return lambda m: m["peers"][name]["seconds"] / m["bunny"]["at_256"]["seconds"]


def memory(found: dict) -> float:
    """Peak memory without the device's buffers, over the input's."""
    return (found["peak_bytes"] - found["buffer_bytes"]) / found["input_bytes"]


FIGURES: dict[str, Figure] = {
    "speedup_100k": Figure(
        3,
        True,
        ("detail_100k",),
        lambda m: best_speedup(m["detail_100k"]),
        "over the baseline at 100 K triangles, r = 4 %",
    ),
    "speedup_1m": Figure(
        50, True, ("detail_1m",), lambda m: best_speedup(m["detail_1m"]), "over the baseline at 1 M triangles, r = 4 %"
    ),
    "speedup_2m": Figure(
        100, True, ("detail_2m",), lambda m: best_speedup(m["detail_2m"]), "over the baseline at 2 M triangles, r = 4 %"
    ),
    "radius_growth": Figure(
        1.5,
        False,
        ("radius",),
        lambda m: m["radius"]["large"]["seconds"] / m["radius"]["small"]["seconds"],
        "time when the radius grows 8 times, 600 K triangles",
    ),
    "bunny_frame_ms": Figure(
        80,
        False,
        ("bunny",),
        lambda m: 1e3 * m["bunny"]["at_256"]["seconds"],
        "stanford-bunny, r = 2 %, 256 samples, the whole frame (a tenth of libigl's was 80 ms)",
    ),
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
    "eight_over_one": Figure(
        1.3,
        False,
        ("together",),
        lambda m: m["together"]["eight"]["seconds"] / m["together"]["one"]["seconds"],
        "eight descriptors at once against one",
    ),
    "three_radii_over_one": Figure(
        1.5,
        False,
        ("together",),
        lambda m: m["together"]["three_radii"]["seconds"] / m["together"]["one"]["seconds"],
        "three radii at once against one",
    ),
    "preprocess_s_per_million": Figure(
        1,
        False,
        ("detail_1m",),
        lambda m: preprocessing(m["detail_1m"]),
        "seconds of preprocessing per million triangles",
    ),
    "peak_memory_over_input": Figure(
        3, False, ("memory",), lambda m: memory(m["memory"]), "peak memory without buffers over the input's"
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
BESIDE: dict[str, Callable[[Measured], float]] = {
    "speedup_100k_256_samples": lambda m: speedup(m["detail_100k"], "at_256"),
    "speedup_1m_256_samples": lambda m: speedup(m["detail_1m"], "at_256"),
    "speedup_2m_256_samples": lambda m: speedup(m["detail_2m"], "at_256"),
    "speedup_100k_at_vertices": lambda m: speedup(m["detail_100k"], "fewest"),
    "speedup_1m_at_vertices": lambda m: speedup(m["detail_1m"], "fewest"),
    "speedup_2m_at_vertices": lambda m: speedup(m["detail_2m"], "fewest"),
    "speedup_100k_max_normals": lambda m: speedup(m["detail_100k"], "max_normals"),
    "speedup_1m_max_normals": lambda m: speedup(m["detail_1m"], "max_normals"),
    "speedup_2m_max_normals": lambda m: speedup(m["detail_2m"], "max_normals"),
    "bunny_fewest_frame_ms": lambda m: 1e3 * m["bunny"]["fewest"]["seconds"],
    "discrete_over_bunny_fewest": lambda m: (
        m["peers"]["pymeshlab_discrete"]["seconds"] / m["bunny"]["fewest"]["seconds"]
    ),
    "over_pymeshlab_pca_same_radius": over_peer("pymeshlab_pca_same_radius"),
    "over_libigl2": over_peer("libigl2"),
    "over_trimesh": over_peer("trimesh"),
    "over_pymeshlab_quadric": over_peer("pymeshlab_quadric"),
    "baseline_faster_than_trimesh": lambda m: m["peers"]["trimesh"]["seconds"] / m["bunny"]["baseline"]["seconds"],
    "baseline_faster_than_pymeshlab_quadric": lambda m: (
        m["peers"]["pymeshlab_quadric"]["seconds"] / m["bunny"]["baseline"]["seconds"]
    ),
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
