"""Options that commands share, and the settings of the computation that they become."""

import argparse
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from .. import bridge
from ..core import balance, job, source_kinds
from .common import PROGRESS, UsageError
from .file_reading import READERS
from .preset_options import found_preset, with_preset

if TYPE_CHECKING:
    import bpy


def add_mesh_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options for one object of a file, and for how to compute."""
    add_input(parser)
    parser.add_argument(
        "--object", metavar="NAME", help="the mesh object (default: a .blend's active one, else the largest)"
    )
    add_computation_options(parser)


def add_source(parser: argparse.ArgumentParser, default: str, *more: str) -> None:
    """Adds --source, the mesh of an object that is measured; opened_settings() supplies it if it is not given."""
    parser.add_argument(
        "--source", choices=(*source_kinds.NAMES, *more),
        help="the object's own mesh, as deforming modifiers and shape keys move it, or after all modifiers"
        f"{'; auto: as viewports show it' if more else ''} (default: {default})",
    )  # fmt: skip
    parser.set_defaults(usual_source=default)


def add_input(parser: argparse.ArgumentParser) -> None:
    """Adds the input file."""
    known = (
        ".blend, .obj, .ply, .stl, .off, .glb, .gltf, .vtp, .vtk, .gii, a surface of FreeSurfer (lh.white), .fbx or "
        ".usd; in Blender: the open file"
    )
    parser.add_argument("input", nargs="?", metavar="INPUT", type=Path, help=known)
    parser.add_argument(
        "--reader", choices=READERS, default="auto",
        help="what reads the input: Blender where it is installed (default), or always Paradesc itself (.obj, .ply, "
        ".stl, .glb, .gltf; others it reads anyway), with the vertices and axes of the file",
    )  # fmt: skip


def add_computation_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options of the computation. One that is not given is None, and settings_of() supplies it."""
    add = parser.add_argument
    add("--scene-settings", action="store_true",
        help="take what is not given here from the panel's settings in the .blend")  # fmt: skip
    add("--preset", metavar="FILE",
        help="take them from a preset: a JSON file, or a name (cavity, edge_wear, ... or your own)")  # fmt: skip
    add("--descriptors", type=or_nothing, metavar="A,B,C", help="see paradesc list (default: mean_curvature)")
    add("--radius", type=radii, metavar="R[,R...]",
        help="support radius (default: 0.02), or auto; of several, names end in _r and the radius")  # fmt: skip
    add("--radius-unit", choices=bridge.RADIUS_UNITS,
        help="diagonal: a fraction of the bounding box's (default); absolute: the mesh's own units")  # fmt: skip
    add("--samples", type=int, metavar="N", help="samples around a vertex (default: 256)")
    add("--buffer", type=int, dest="buffer_size", metavar="N", help="side of the buffers (default: 1024)")
    add("--normals", choices=bridge.NORMALS, help="vertex normals (default: fitted)")
    add("--creases", choices=bridge.CREASES,
        help="hard edges: marked and found by their angle (default), marked ones alone, or none")  # fmt: skip
    add("--relocation", choices=bridge.RELOCATIONS,
        help="over seams: by connected cells (default), each sample by affine maps, or as the paper does")  # fmt: skip
    add("--max-jumps", type=int, metavar="N", help="affine, paper: seams to cross (default: 8)")
    add("--pattern", choices=bridge.PATTERNS, help="affine, paper: places of the samples")
    add("--ellipse", choices=bridge.ELLIPSES,
        help="affine, paper: extent by the distortion at the center, or the largest on the way")  # fmt: skip
    add("--estimator", choices=bridge.ESTIMATORS,
        help="curvatures by the fitted shape operator (default), that extrapolated to radius 0, or the paper's integrals")  # fmt: skip
    add("--variance-reduction", choices=bridge.VARIANCE_REDUCTIONS,
        help="integrals with the shape operator as control variate (default), or plain sums")  # fmt: skip
    add("--geodesic", choices=bridge.GEODESICS,
        help="along the surface by a local formula (default), or by chords (affine, paper)")  # fmt: skip
    add("--distance", choices=bridge.DISTANCES, help="what the radius bounds")
    add("--adaptive", type=float, nargs="?", const=bridge.ADAPTIVE_THRESHOLD,
        metavar="THRESHOLD", help="half of the samples where normals fit to this angle, in radians")  # fmt: skip
    add("--evaluate", choices=bridge.EVALUATIONS, help="at vertices, or texels looked up")
    add("--texels", type=int, metavar="N", help="side of the map of texels (default: 512)")
    add("--precision", choices=bridge.PRECISIONS, help="of the buffers (default: full)")
    add("--map-descriptor", metavar="A",
        help="what the operators (harris, laplacian, ...) work on (default: sphere_volume_normalized)")  # fmt: skip
    add("--map-sigma", type=float, metavar="S",
        help="of harris' and difference_of_gaussians' windows, times the radius (default: 1)")  # fmt: skip
    add("--harris-k", type=float, metavar="K", help="k of harris (default: 0.04)")
    add("--backend", choices=bridge.BACKENDS, help="what computes (default: auto)")
    add("--device", type=int, metavar="N", help="which device of the backend (default: the first)")
    add("--memory-limit", type=gigabytes, metavar="GB",
        help="refuse what would take more memory than this (default: half of what is free)")  # fmt: skip
    add("--seed", type=int, metavar="N", help="of the sampling pattern (default: 0)")
    add("--space", choices=("object", "world"),
        help="measure the mesh itself (default), or as it stands in the world, with the object's scale")  # fmt: skip
    add("--shape-key", choices=("basis", "active"), help="which shape to measure (default: basis)")
    add("--progress", choices=PROGRESS, default="auto",
        help="on the standard error stream: where it is a terminal (default), a line every 5 %%, or none")  # fmt: skip


def or_nothing(text: str) -> str | None:
    """A text, or None for an empty one: job descriptions pass options that nobody filled in."""
    return text or None


def radii(text: str) -> tuple[float, ...] | None:
    """Parses numbers between commas; an empty text is not given, and "auto" no number."""
    if not text:
        return None
    if text == balance.AUTO:
        return (text,)
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}" is no radius; give a number, several with commas, or auto') from None


def gigabytes(text: str) -> int:
    """Parses a positive number of gigabytes into bytes."""
    try:
        size = 1e9 * float(text)
    except ValueError:
        size = math.nan
    if not 0 < size < 2**63:
        raise argparse.ArgumentTypeError(f'"{text}" is no amount of memory; give a number of gigabytes above 0')
    return math.ceil(size)


def add_map_options(parser: argparse.ArgumentParser) -> None:
    """Adds images that change the measured surface. compare has none, as the reference has no texels for them."""
    add = parser.add_argument
    add("--displacement", metavar="IMAGE", type=Path, help="displace the surface by (value - midlevel) scale")
    add("--midlevel", type=float, default=0.5, metavar="X", help="of the displacement (default: 0.5)")
    add("--displacement-scale", type=float, default=1.0, metavar="X", help="in the mesh's units (default: 1)")
    add("--normal-map", metavar="IMAGE", type=Path, help="take the normals from a tangent space normal map")
    add("--material-maps", action="store_true", help="take displacement and normal map from the object's material")


def settings_of(arguments: argparse.Namespace, base: job.Settings | None = None) -> job.Settings:
    """The settings of the computation; base supplies options not given. Unknown descriptors raise an error."""
    base = base or job.Settings()
    names = base.descriptors
    if arguments.descriptors is not None:
        names = tuple(name.strip() for name in arguments.descriptors.split(",") if name.strip())
    job.check_descriptors(names)
    members = [member.name for member in fields(bridge.Options) if member.name not in ("radius", "seam_error")]
    given = {name: getattr(arguments, name) for name in members if getattr(arguments, name) is not None}
    fit = "typed" if arguments.radius else base.radius_fit
    radius, *more = arguments.radius or (base.options.radius, *base.more_radii)
    if radius == balance.AUTO:
        fit, radius = balance.AUTO, base.options.radius
    return replace(
        base,
        descriptors=names,
        options=replace(base.options, radius=radius, **given),
        radius_fit=fit,
        backend=given_or(arguments, "backend", base.backend),
        device_index=given_or(arguments, "device", base.device_index),
        more_radii=tuple(more),
        corner_threshold=given_or(arguments, "corner_threshold", base.corner_threshold),
        space=given_or(arguments, "space", base.space),
        domain=given_or(arguments, "domain", base.domain),
        memory_limit=given_or(arguments, "memory_limit", base.memory_limit),
    )


def given_or(arguments: argparse.Namespace, name: str, otherwise: object) -> object:
    """An option if it was given, else the other value; not every command has every option."""
    value = getattr(arguments, name, None)
    return otherwise if value is None else value


def opened_settings(arguments: argparse.Namespace) -> job.Settings:
    """The settings once the file is open: what is not given comes from --preset, else the scene, else the defaults.

    What else a preset says is in preset_content of the arguments. --scene-settings also supplies the source, the shape
    key, the cage distance, and whether material maps and the change against rest are measured, unless an option does.
    """
    base = None
    usual = getattr(arguments, "usual_source", "original")
    source, shape_key = getattr(arguments, "source", None), arguments.shape_key
    arguments.source = source or usual
    if arguments.scene_settings:
        with scene_settings() as scene:
            from ..settings import properties
            from ..settings.animation import frame_source

            group, animation = scene.paradesc, scene.paradesc_animation
            base = properties.job_settings(group)
            arguments.source = source or (animation.source if usual == "original" else frame_source(animation))
            if not getattr(arguments, "relative_to_rest", True):
                arguments.relative_to_rest = animation.relative_to_rest
            arguments.shape_key = arguments.shape_key or group.shape_key
            has_files = any(getattr(arguments, name, None) for name in ("displacement", "normal_map"))
            arguments.cage = given_or(arguments, "cage", group.cage)
            given = getattr(arguments, "material_maps", False)
            arguments.material_maps = given or (group.material_maps and not has_files)
    if shape_key == "active" and arguments.source not in (source_kinds.ORIGINAL, source_kinds.AUTOMATIC):
        sentence = f"The source {arguments.source} has the shape that shape keys give it; leave --shape-key out"
        raise UsageError(f"{sentence}, or measure the source original.")
    arguments.preset_content = found_preset(arguments.preset)
    return settings_of(arguments, with_preset(arguments.preset_content, base))


@contextmanager
def scene_settings() -> "Iterator[bpy.types.Scene]":
    """The open scene with the panels' settings, which are in the .blend whether or not the add-on is enabled."""
    import bpy

    from ..settings import animation, leaving, looks, properties

    if hasattr(bpy.types.Scene, "paradesc"):
        yield bpy.context.scene
        return
    groups = (looks.PARADESC_PG_looks, animation.PARADESC_PG_animation)
    modules = (properties, looks, animation)
    leaving.clear_at_end(list(groups))
    for cls in groups:
        bpy.utils.register_class(cls)
    for module in modules:
        module.register()
    try:
        yield bpy.context.scene
    finally:
        for module in modules:
            module.unregister()
        for cls in groups:
            bpy.utils.unregister_class(cls)
