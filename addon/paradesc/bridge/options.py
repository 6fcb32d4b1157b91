"""Defines how to compute: the names of all choices in Python, and the options as a C struct."""

import ctypes
from dataclasses import dataclass

from . import abi
from .library import ParadescError, new_struct

BACKENDS = {
    "auto": abi.BACKEND_AUTO,
    "gpu": abi.BACKEND_GPU,
    "software": abi.BACKEND_SOFTWARE,
    "reference": abi.BACKEND_REFERENCE,
    "cpu": abi.BACKEND_CPU,
}
# How each backend measures: values of one method agree from machine to machine, those of two methods do only nearly.
METHODS = {
    "gpu": "texture space",
    "software": "texture space",
    "reference": "reference",
    "cpu": "surface samples",
}
NORMALS = {"fitted": abi.NORMALS_FITTED, "max": abi.NORMALS_MAX, "mesh": abi.NORMALS_MESH}
CREASES = {"auto": abi.CREASES_AUTO, "marked": abi.CREASES_MARKED, "none": abi.CREASES_NONE}
RADIUS_UNITS = {
    "diagonal": abi.RADIUS_DIAGONAL,
    "absolute": abi.RADIUS_ABSOLUTE,
    "mean-edge": abi.RADIUS_MEAN_EDGE,
}

RELOCATIONS = {
    "connected": abi.RELOCATION_CONNECTED,
    "affine": abi.RELOCATION_AFFINE,
    "paper": abi.RELOCATION_PAPER,
}
ESTIMATORS = {
    "shape-operator": abi.ESTIMATOR_SHAPE_OPERATOR,
    "integral": abi.ESTIMATOR_INTEGRAL,
    "extrapolated": abi.ESTIMATOR_EXTRAPOLATED,
}
VARIANCE_REDUCTIONS = {"shape": abi.VARIANCE_REDUCTION_SHAPE, "none": abi.VARIANCE_REDUCTION_NONE}
GEODESICS = {"local": abi.GEODESIC_LOCAL, "chords": abi.GEODESIC_CHORDS}
DISTANCES = {"euclidean": abi.DISTANCE_EUCLIDEAN, "geodesic": abi.DISTANCE_GEODESIC}
PATTERNS = {"golden-angle": abi.PATTERN_GOLDEN_ANGLE, "stratified": abi.PATTERN_STRATIFIED}
ELLIPSES = {"center": abi.ELLIPSE_CENTER, "directional": abi.ELLIPSE_DIRECTIONAL}
EVALUATIONS = {"vertex": abi.EVALUATE_VERTEX, "texel": abi.EVALUATE_TEXEL}
PRECISIONS = {"full": abi.PRECISION_FULL, "half": abi.PRECISION_HALF}
# The choices of each option that is a name, and what a sentence calls the option.
CHOICES = {
    "radius_unit": (RADIUS_UNITS, "radius unit"),
    "normals": (NORMALS, "kind of normals"),
    "creases": (CREASES, "choice of creases"),
    "relocation": (RELOCATIONS, "relocation"),
    "estimator": (ESTIMATORS, "estimator"),
    "variance_reduction": (VARIANCE_REDUCTIONS, "variance reduction"),
    "geodesic": (GEODESICS, "geodesic distance"),
    "distance": (DISTANCES, "distance"),
    "pattern": (PATTERNS, "pattern"),
    "ellipse": (ELLIPSES, "ellipse"),
    "evaluate": (EVALUATIONS, "place of evaluation"),
    "precision": (PRECISIONS, "precision"),
}
NUMBERS = {
    "samples": "number of samples",
    "buffer_size": "buffer size",
    "max_jumps": "number of jumps",
    "texels": "number of texels",
}
# The threshold in radians that --adaptive has if it is given without a number.
ADAPTIVE_THRESHOLD = 0.05


def uses_texture_space(backend: str) -> bool:
    """Whether a backend, other than auto, bakes buffers over a UV map, and so needs one."""
    return METHODS[backend] == "texture space"


@dataclass
class Options:
    """How to compute; the defaults are those of pdesc_options_init."""

    radius: float = 0.02
    radius_unit: str = "diagonal"
    samples: int = 256
    buffer_size: int = 1024
    normals: str = "fitted"
    creases: str = "auto"
    max_jumps: int = 8
    seed: int = 0
    seam_error: bool = False
    relocation: str = "connected"
    estimator: str = "shape-operator"
    variance_reduction: str = "shape"
    geodesic: str = "local"
    distance: str = "euclidean"
    pattern: str = "golden-angle"
    ellipse: str = "center"
    evaluate: str = "vertex"
    texels: int = 512
    precision: str = "full"
    adaptive: float = 0.0
    map_descriptor: str = "sphere_volume_normalized"
    map_sigma: float = 1.0
    harris_k: float = 0.04


def needs_texture_space(options: Options, buffers: bool = False) -> bool:
    """Whether auto takes OpenGL for these options. pdesc_mesh_backend decides the same for an existing mesh."""
    return (
        buffers
        or options.seam_error
        or options.relocation != "connected"
        or options.precision == "half"
        or options.adaptive > 0
    )


def native_options(library: ctypes.CDLL, options: Options, buffers: bool = False) -> abi.ComputeOptions:
    """The options as a C struct; buffers: whether the baked buffers will be read."""
    native = new_struct(library, abi.ComputeOptions)
    native.radius = options.radius
    native.adaptive = options.adaptive
    native.map_descriptor = options.map_descriptor.encode()
    native.map_sigma = options.map_sigma
    native.harris_k = options.harris_k
    for name, (choices, what) in CHOICES.items():
        setattr(native, name, choice(choices, getattr(options, name), what))
    for name, what in NUMBERS.items():
        setattr(native, name, int32(getattr(options, name), what))
    if not 0 <= options.seed < 2**32:
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, f"The seed {options.seed} is not between 0 and {2**32 - 1}.")
    native.seed = options.seed
    native.seam_error = int(options.seam_error)
    native.buffers = int(buffers)
    return native


def choice(names: dict[str, int], name: str, what: str) -> int:
    """The number of a named choice; a ParadescError lists the names that exist."""
    if name not in names:
        sentence = f'There is no {what} "{name}"; choose one of {", ".join(names)}.'
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
    return names[name]


def int32(value: int, what: str) -> int:
    """The value itself if it fits the C type; ctypes would cut it silently."""
    if not -(2**31) <= value < 2**31:
        raise ParadescError(abi.STATUS_INVALID_ARGUMENT, f"The {what} {value} is out of range.")
    return value
