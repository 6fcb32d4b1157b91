"""The choices of compute()'s arguments as types, for people, editors and type checkers."""

from typing import Literal, TypedDict

RadiusUnit = Literal["diagonal", "absolute", "mean-edge"]
Normals = Literal["fitted", "max", "mesh"]
Creases = Literal["auto", "marked", "none"]
Estimator = Literal["shape-operator", "integral", "extrapolated"]
Distance = Literal["euclidean", "geodesic"]
Domain = Literal["vertices", "faces"]
Backend = Literal["auto", "gpu", "cpu", "software", "reference"]


class MoreOptions(TypedDict, total=False):
    """The options that are needed less often; addon/manual/reference.md describes each."""

    variance_reduction: Literal["shape", "none"]
    geodesic: Literal["local", "chords"]
    map_sigma: float
    harris_k: float
    corner_threshold: float
    buffer_size: int
    relocation: Literal["connected", "affine", "paper"]
    max_jumps: int
    seed: int
    pattern: Literal["golden-angle", "stratified"]
    ellipse: Literal["center", "directional"]
    evaluate: Literal["vertex", "texel"]
    texels: int
    precision: Literal["full", "half"]
    adaptive: float
