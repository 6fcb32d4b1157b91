"""Options that commands share, and the settings of the computation that they become."""

import argparse
from pathlib import Path

from .. import bridge, job


def add_mesh_options(parser: argparse.ArgumentParser) -> None:
    """What bake and compare have in common."""
    defaults = bridge.Options()
    add = parser.add_argument
    add("input", nargs="?", metavar="INPUT", type=Path, help=".blend, .obj, .ply or .glb; in Blender: the open file")
    add("--descriptors", default="mean_curvature", metavar="A,B,C", help="see paradesc list (default: mean_curvature)")
    add("--object", metavar="NAME", help="the mesh object (default: a .blend's active one, else the largest)")
    add("--radius", type=radii, default=(defaults.radius,), metavar="R[,R...]",
        help="support radius (default: 0.02); of several, names end in _r and the radius")  # fmt: skip
    add("--radius-unit", choices=bridge.RADIUS_UNITS, default=defaults.radius_unit,
        help="diagonal: a fraction of the bounding box's (default); absolute: the mesh's own units")  # fmt: skip
    add("--samples", type=int, default=defaults.samples, metavar="N", help="samples around a vertex (default: 256)")
    add("--buffer", type=int, default=defaults.buffer_size, metavar="N", help="side of the buffers (default: 1024)")
    add("--normals", choices=bridge.NORMALS, default=defaults.normals, help="vertex normals (default: fitted)")
    add("--relocation", choices=bridge.RELOCATIONS, default=defaults.relocation,
        help="over seams: by connected cells (default), each sample by affine maps, or as the paper does")  # fmt: skip
    add(
        "--max-jumps",
        type=int,
        default=defaults.max_jumps,
        metavar="N",
        help="affine, paper: seams to cross (default: 8)",
    )
    add("--pattern", choices=bridge.PATTERNS, default=defaults.pattern, help="affine, paper: places of the samples")
    add("--ellipse", choices=bridge.ELLIPSES, default=defaults.ellipse,
        help="affine, paper: extent by the distortion at the center, or the largest on the way")  # fmt: skip
    add("--estimator", choices=bridge.ESTIMATORS, default=defaults.estimator,
        help="curvatures by the least-squares shape operator (default), or by the paper's integrals")  # fmt: skip
    add("--variance-reduction", choices=bridge.VARIANCE_REDUCTIONS, default=defaults.variance_reduction,
        help="integrals with the shape operator as control variate (default), or plain sums")  # fmt: skip
    add("--geodesic", choices=bridge.GEODESICS, default=defaults.geodesic,
        help="along the surface by a local formula (default), or by chords (affine, paper)")  # fmt: skip
    add("--distance", choices=bridge.DISTANCES, default=defaults.distance, help="what the radius bounds")
    add("--adaptive", type=float, nargs="?", const=bridge.ADAPTIVE_THRESHOLD, default=defaults.adaptive,
        metavar="THRESHOLD", help="half of the samples where normals fit to this angle, in radians")  # fmt: skip
    add("--evaluate", choices=bridge.EVALUATIONS, default=defaults.evaluate, help="at vertices, or texels looked up")
    add("--texels", type=int, default=defaults.texels, metavar="N", help="side of the map of texels (default: 512)")
    add("--precision", choices=bridge.PRECISIONS, default=defaults.precision, help="of the buffers (default: full)")
    add("--map-descriptor", default=defaults.map_descriptor, metavar="A",
        help="what the operators (harris, laplacian, ...) work on (default: %(default)s)")  # fmt: skip
    add("--map-sigma", type=float, default=defaults.map_sigma, metavar="S",
        help="of harris' and difference_of_gaussians' windows, times the radius (default: 1)")  # fmt: skip
    add("--harris-k", type=float, default=defaults.harris_k, metavar="K", help="k of harris (default: 0.04)")
    add("--backend", choices=bridge.BACKENDS, default="auto", help="what computes (default: auto)")
    add("--device", type=int, default=-1, metavar="N", help="which device of the backend (default: the first)")
    add("--seed", type=int, default=defaults.seed, metavar="N", help="of the sampling pattern (default: 0)")
    add("--verbose", action="store_true", help="show what Blender itself prints")


def radii(text: str) -> tuple[float, ...]:
    """Numbers between commas."""
    return tuple(float(word) for word in text.split(","))


def add_map_options(parser: argparse.ArgumentParser) -> None:
    """Images that change what is measured; the reference has no texels for them, so compare does without."""
    add = parser.add_argument
    add("--displacement", metavar="IMAGE", type=Path, help="displace the surface by (value - midlevel) scale")
    add("--midlevel", type=float, default=0.5, metavar="X", help="of the displacement (default: 0.5)")
    add("--displacement-scale", type=float, default=1.0, metavar="X", help="in the mesh's units (default: 1)")
    add("--normal-map", metavar="IMAGE", type=Path, help="take the normals from a tangent space normal map")
    add("--material-maps", action="store_true", help="take displacement and normal map from the object's material")


def settings_of(arguments: argparse.Namespace) -> job.Settings:
    """The computation's settings; unknown descriptors are refused before any file is opened."""
    names = tuple(name.strip() for name in arguments.descriptors.split(",") if name.strip())
    job.check_descriptors(names)
    options = bridge.Options(
        radius=arguments.radius[0],
        samples=arguments.samples,
        buffer_size=arguments.buffer,
        max_jumps=arguments.max_jumps,
        seed=arguments.seed,
        texels=arguments.texels,
        adaptive=arguments.adaptive,
        map_descriptor=arguments.map_descriptor,
        map_sigma=arguments.map_sigma,
        harris_k=arguments.harris_k,
        **{name: getattr(arguments, name) for name in bridge.CHOICES},
    )
    return job.Settings(names, options, arguments.backend, arguments.device, arguments.radius[1:])
