"""Lists what is computed of every mesh: radii × precisions × places, then every other option once."""

from dataclasses import dataclass, field
from typing import Any

RADII = (0.01, 0.02, 0.04)
PRECISIONS = ("full", "half")
PLACES = ("vertex", "texel")
# The grid takes the defaults of pdesc_options except texels, and names what the default relocation is in texture space; other
# options and --quick take what is faster.
WHOLE = {"relocation": "affine", "texels": 256}
SMALL = {"relocation": "affine", "texels": 128, "buffer_size": 512, "samples": 64}
QUICK = {"relocation": "affine", "texels": 64, "buffer_size": 256, "samples": 64}

# One row for each computation beside the grid, at the middle radius: what differs from the defaults.
OPTIONS: tuple[dict[str, Any], ...] = (
    {"relocation": "paper"},
    {"relocation": "paper", "precision": "half"},
    {"relocation": "paper", "evaluate": "texel"},
    {"relocation": "paper", "pattern": "stratified", "max_jumps": 1},
    {"pattern": "stratified"},
    {"pattern": "stratified", "ellipse": "directional"},
    {"ellipse": "directional"},
    {"max_jumps": 1},
    {"estimator": "integral"},
    {"estimator": "extrapolated"},
    {"estimator": "extrapolated", "evaluate": "texel", "precision": "half"},
    {"variance_reduction": "none"},
    {"variance_reduction": "none", "estimator": "integral"},
    {"distance": "geodesic"},
    {"distance": "geodesic", "geodesic": "chords", "evaluate": "texel"},
    {"distance": "geodesic", "precision": "half", "variance_reduction": "none"},
    {"adaptive": 0.05},
    {"adaptive": 0.05, "evaluate": "texel"},
    {"adaptive": 0.01, "variance_reduction": "none", "precision": "half"},
    {"normals": "max"},
    {"normals": "mesh"},
    {"radius_unit": "mean-edge", "radius": 3.0},
    {"seed": 3, "samples": 48},
    {"samples": 1000, "radius": 0.01},
    {"buffer_size": 333},
    {"map_descriptor": "mean_curvature"},
    {"map_descriptor": "euclidean_area", "map_sigma": 0.5, "harris_k": 0.1},
)
# These are slow: they run on small meshes only, and --quick leaves them out.
SLOW: tuple[dict[str, Any], ...] = (
    {"geodesic": "chords"},
    {"geodesic": "chords", "relocation": "paper", "distance": "geodesic"},
)
# These run without a device; the reference has fewer options.
REFERENCE: tuple[dict[str, Any], ...] = (
    {},
    {"estimator": "integral"},
    {"estimator": "extrapolated"},
    {"distance": "geodesic"},
    {"normals": "max"},
)


@dataclass(frozen=True)
class Case:
    """One computation: its name in tables, the options that it sets, and how the mesh is changed before."""

    name: str
    options: dict[str, Any] = field(default_factory=dict)
    change: str = ""  # a function of inputs.CHANGES
    backend: str = "software"
    alone: str = ""  # one descriptor instead of all
    buffers: bool = False  # the baked buffers and the layout, too


def named(options: dict[str, Any]) -> str:
    """The options in words: "relocation affine, precision half"."""
    return ", ".join(f"{name} {value}" for name, value in options.items()) or "defaults"


def grid(base: dict[str, Any]) -> list[Case]:
    """Every radius, both precisions, both places of evaluation."""
    cases = []
    for precision in PRECISIONS:
        for radius in RADII:
            for evaluate in PLACES:
                given = {"radius": radius, "precision": precision, "evaluate": evaluate}
                cases.append(Case(named(given), base | given, buffers=radius == RADII[0] and evaluate == PLACES[0]))
    return cases


def others(base: dict[str, Any], changes: tuple[str, ...], slow: bool) -> list[Case]:
    """Every other option once, then every change of the mesh, and the mesh as it was."""
    cases = [Case(named(given), base | given) for given in OPTIONS]
    cases += [Case(named(given), base | given) for given in SLOW if slow]
    cases += [Case(change, base, change=change, buffers=True) for change in changes]
    cases += [Case(f"{change}, half", base | {"precision": "half"}, change=change) for change in changes[:1]]
    return [*cases, Case("as it was", base, buffers=True)]


def on_reference(base: dict[str, Any]) -> list[Case]:
    """The cases without a device, at the smallest radius."""
    cases = []
    for given in REFERENCE:
        cases.append(Case(f"reference, {named(given)}", base | {"radius": RADII[0]} | given, backend="reference"))
    return cases


def singly(base: dict[str, Any], descriptors: list[str]) -> list[Case]:
    """Each descriptor alone, because the other cases compute all from one sampling."""
    return [Case(f"{name} alone", base, alone=name) for name in descriptors]
