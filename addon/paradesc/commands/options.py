"""Options that commands share, and the settings of the computation that they and presets become."""

import argparse
import math
from dataclasses import replace
from pathlib import Path

from .. import bridge
from ..core import balance, job, source_kinds
from ..files import preset_file, preset_rules
from ..files.paths import is_file
from ..files.preset_file import Content
from ..files.preset_rules import PRESETS
from .common import PROGRESS, UsageError, has_blender
from .sources import READERS, scene_source

# The members that have no effect, because the suffix of an image's file decides.
WITHOUT_OPTION = ("image_format",)


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
        help="mesh to measure: the object's own, as deforming modifiers and shape keys move it, or after all "
        f"modifiers{'; auto: as viewports show it' if more else ''} (default: {default})",
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
        help="program that reads the input: Blender if it is installed (default), or always Paradesc itself (.obj, "
        ".ply, .stl, .glb, .gltf; it reads others anyway), with the vertices and axes of the file",
    )  # fmt: skip


def add_computation_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options of the computation. One that is not given is None, and settings_of() supplies it."""
    add = parser.add_argument
    add("--scene-settings", action="store_true",
        help="take options that are not given from the panel's settings in the .blend")  # fmt: skip
    add("--preset", metavar="FILE",
        help=(
            "take options that are not given from a preset: a JSON file, or a name (cavity, edge_wear, ... or your "
            "own)"
        ))  # fmt: skip
    # Job descriptions pass options that nobody filled in.
    add("--descriptors", type=lambda text: text or None, metavar="A,B,C", help=(
        "descriptors to compute; see paradesc list (default: mean_curvature)"
    ))
    add("--radius", type=radii, metavar="R[,R...]",
        help="radius of the neighborhood (default: 0.02), or auto; of several, names end in _r and radius")  # fmt: skip
    for row in bridge.TABLE:
        kind = {"choices": [name for name, *_ in row.choices]} if row.choices else {"type": type(row.default)}
        flag = row.flag or row.name.replace("_", "-")
        add(f"--{flag}", dest=row.name, help=row.help, **kind, **row.words)
    add("--backend", choices=bridge.BACKENDS, help="device that computes (default: auto)")
    add("--device", type=int, metavar="N", help="number of the device of the backend (default: the first)")
    add("--memory-limit", type=gigabytes, metavar="GB",
        help="refuse computations that need more memory than this (default: half of the free memory)")  # fmt: skip
    add("--space", choices=("object", "world"),
        help="measure the mesh itself (default), or as it stands in the world, with the object's scale")  # fmt: skip
    add("--shape-key", choices=("basis", "active"), help="shape to measure (default: basis)")
    add("--progress", choices=PROGRESS, default="auto",
        help="progress on the standard error: if it is a terminal (default), a line every 5 %%, or none")  # fmt: skip


def radii(text: str) -> tuple[float, ...] | None:
    """Parses numbers between commas; an empty text is not given, and "auto" no number."""
    if not text:
        return None
    if text == balance.AUTO:
        return (text,)
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        sentence = f'"{text}" is not a radius; give a number, several with commas, or auto'
        raise argparse.ArgumentTypeError(sentence) from None


def gigabytes(text: str) -> int:
    """Parses a positive number of gigabytes into bytes."""
    try:
        size = 1e9 * float(text)
    except ValueError:
        size = math.nan
    if not 0 < size < 2**63:
        raise argparse.ArgumentTypeError(f'"{text}" is not an amount of memory; give a number of gigabytes above 0')
    return math.ceil(size)


def add_map_options(parser: argparse.ArgumentParser) -> None:
    """Adds images that change the measured surface. compare has none, as the reference has no texels for them."""
    add = parser.add_argument
    add("--displacement", metavar="IMAGE", type=Path, help="displace the surface by (value - midlevel) scale")
    add("--midlevel", type=float, default=0.5, metavar="X", help="midlevel of the displacement (default: 0.5)")
    add("--displacement-scale", type=float, default=1.0, metavar="X", help=(
        "scale of the displacement, in the mesh's units (default: 1)"
    ))
    add("--normal-map", metavar="IMAGE", type=Path, help="take the normals from a tangent space normal map")
    add("--material-maps", action="store_true", help="take displacement and normal map from the object's material")


def settings_of(arguments: argparse.Namespace, base: job.Settings | None = None) -> job.Settings:
    """The settings of the computation; base supplies options not given. Unknown descriptors raise an error."""
    base = base or job.Settings()
    names = base.descriptors
    if arguments.descriptors is not None:
        names = tuple(name.strip() for name in arguments.descriptors.split(",") if name.strip())
    job.check_descriptors(names)
    values = {row.name: getattr(arguments, row.name) for row in bridge.TABLE}
    given = {name: value for name, value in values.items() if value is not None}
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

    The rest of a preset is in preset_content of the arguments. --scene-settings also supplies the source, the shape
    key, the cage distance, and whether material maps and the change against rest are measured, unless an option does.
    """
    usual = getattr(arguments, "usual_source", "original")
    arguments.source, shape_key = getattr(arguments, "source", None), arguments.shape_key
    base = scene_source(arguments).settings(usual) if arguments.scene_settings else None
    arguments.source = arguments.source or usual
    if shape_key == "active" and arguments.source not in (source_kinds.ORIGINAL, source_kinds.AUTOMATIC):
        sentence = f"The source {arguments.source} has the shape that shape keys give it; leave --shape-key out"
        raise UsageError(f"{sentence}, or measure the source original.")
    arguments.preset_content = found_preset(arguments.preset)
    return settings_of(arguments, preset_rules.settings_of(arguments.preset_content, base))


# ---- Presets: a built-in one, the user's or a file fills in options that are not given


def is_preset_file(name: str) -> bool:
    """Whether --preset names a file: by its suffix, or because it is the path of an existing file in another folder."""
    path = Path(name)
    return path.suffix.lower() == preset_file.SUFFIX or (path.name != name and is_file(path))


def check_preset(name: str | None) -> None:
    """Refuses an invalid preset file before anything else is read."""
    if name is not None and is_preset_file(name):
        preset_rules.sound(Path(name))


def found_preset(name: str | None) -> Content | None:
    """The preset that --preset names: a built-in one, a file, or with Blender one of its preset folders."""
    if name is None:
        return None
    if name in PRESETS:
        return PRESETS[name].content()
    if is_preset_file(name):
        return preset_rules.sound(Path(name))
    if not has_blender():
        raise UsageError(
            f'There is no preset "{name}"; choose one of {", ".join(PRESETS)}, or give a file (NAME.json).'
        )
    scene = scene_source(argparse.Namespace())
    row = scene.preset(name)
    if row is None:
        others = {row.name for row in scene.presets() if not row.fault}
        known = ", ".join([*PRESETS, *sorted(others)])
        raise UsageError(f'There is no preset "{name}"; choose one of {known}, or give a file (NAME.json).')
    return preset_rules.sound(row.path)


def notes_of_preset(content: Content | None, has_colors: bool) -> list[str]:
    """One sentence about members of a preset that have no effect in this command."""
    if content is None:
        return []
    unused = [name for name in content.image or {} if name in WITHOUT_OPTION]
    unused += [] if has_colors else list(content.colors or {})
    if not unused:
        return []
    verb = "have" if len(unused) > 1 else "has"
    return [f'The preset "{content.name}" names {", ".join(unused)}, which {verb} no effect here.']
