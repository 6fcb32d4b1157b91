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
from .common import PROGRESS, Parser, UsageError, has_blender
from .sources import READERS, scene_source

# The options, beside radii and those of the table, that are members of job.Settings.
SETTINGS = ("descriptors", "backend", "device_index", "corner_threshold", "space", "domain", "memory_limit")


def add_input(parser: Parser) -> None:
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


def add_objects(parser: Parser, source: str = "", *more_sources: str) -> None:
    """Adds the input, the choice of its objects, and --source, which opened_settings() supplies if it is not given."""
    add_input(parser)
    add = parser.add_argument
    add("--object", action="append", default=[], metavar="NAME",
        help="a mesh object; give it again for more (default: a .blend's active one, else the largest)")  # fmt: skip
    add("--all", action="store_true", help="every mesh object that renders")
    if source:
        as_shown = "; auto: as viewports show it" if more_sources else ""
        add("--source", choices=(*source_kinds.NAMES, *more_sources),
            help="mesh to measure: the object's own, as deforming modifiers and shape keys move it, or after all "
            f"modifiers{as_shown} (default: {source})")  # fmt: skip
        parser.set_defaults(usual_source=source)


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
    add("--descriptors", type=names, metavar="A,B,C", help=(
        "descriptors to compute; see paradesc list (default: mean_curvature)"
    ))
    add("--radius", type=radii, dest="radii", metavar="R[,R...]",
        help="radius of the neighborhood (default: 0.02), or auto; of several, names end in _r and radius")  # fmt: skip
    for row in bridge.TABLE:
        kind = {"choices": [name for name, *_ in row.choices]} if row.choices else {"type": type(row.default)}
        flag = row.flag or row.name.replace("_", "-")
        add(f"--{flag}", dest=row.name, help=row.help, **kind, **row.words)
    add("--backend", choices=bridge.BACKENDS, help="device that computes (default: auto)")
    add("--device", type=int, dest="device_index", metavar="N",
        help="number of the device of the backend (default: the first)")  # fmt: skip
    add("--memory-limit", type=gigabytes, metavar="GB",
        help="refuse computations that need more memory than this (default: half of the free memory)")  # fmt: skip
    add("--space", choices=("object", "world"),
        help="measure the mesh itself (default), or as it stands in the world, with the object's scale")  # fmt: skip
    add("--shape-key", choices=("basis", "active"), help="shape to measure (default: basis)")
    add("--progress", choices=PROGRESS, default="auto",
        help="progress on the standard error: if it is a terminal (default), a line every 5 %%, or none")  # fmt: skip


def names(text: str) -> tuple[str, ...] | None:
    """Parses names between commas; an empty text, as job descriptions pass it, is not given."""
    return tuple(name.strip() for name in text.split(",") if name.strip()) if text else None


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


def add_map_options(parser: Parser) -> None:
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
    given = {name: value for name, value in vars(arguments).items() if value is not None}
    settings = {name: given[name] for name in SETTINGS if name in given}
    options = {row.name: given[row.name] for row in bridge.TABLE if row.name in given}
    if arguments.radii == (balance.AUTO,):
        settings.update(radius_fit=balance.AUTO, more_radii=())
    elif arguments.radii:
        options["radius"], *more = arguments.radii
        settings.update(radius_fit="typed", more_radii=tuple(more))
    found = replace(base, **settings, options=replace(base.options, **options))
    job.check_descriptors(found.descriptors)
    if found.radius_fit == "typed":
        job.check_radii((found.options.radius, *found.more_radii))
    return found


def check(arguments: argparse.Namespace) -> job.Settings:
    """Refuses invalid settings, preset files and choices of objects before any input is read."""
    settings = settings_of(arguments)
    if arguments.preset is not None and is_preset_file(arguments.preset):
        preset_rules.sound(Path(arguments.preset))
    if arguments.all and arguments.object:
        raise UsageError("Give --object or --all, not both.")
    return settings


def opened_settings(arguments: argparse.Namespace) -> job.Settings:
    """The settings once the file is open: what is not given comes from --preset, else the scene, else the defaults.

    The rest of a preset is in preset_content of the arguments. --scene-settings also supplies the source, the shape
    key, the cage distance, and whether material maps and the change against rest are measured, unless an option does.
    """
    usual, shape_key = arguments.usual_source, arguments.shape_key
    base = scene_source(arguments).settings(usual) if arguments.scene_settings else None
    arguments.source = arguments.source or usual
    if shape_key == "active" and arguments.source not in (source_kinds.ORIGINAL, source_kinds.AUTOMATIC):
        sentence = f"The source {arguments.source} has the shape that shape keys give it; leave --shape-key out"
        raise UsageError(f"{sentence}, or measure the source original.")
    arguments.preset_content = found_preset(arguments)
    return settings_of(arguments, preset_rules.settings_of(arguments.preset_content, base))


# ---- Presets: a built-in one, the user's or a file fills in options that are not given


def is_preset_file(name: str) -> bool:
    """Returns whether --preset names a file: by its suffix, or as the path of an existing file in another folder."""
    path = Path(name)
    return path.suffix.lower() == preset_file.SUFFIX or (path.name != name and is_file(path))


def found_preset(arguments: argparse.Namespace) -> Content | None:
    """The preset that --preset names: a built-in one, a file, or with Blender one of its preset folders."""
    name, others = arguments.preset, set()
    if name is None:
        return None
    if name in PRESETS:
        return PRESETS[name]
    if is_preset_file(name):
        return preset_rules.sound(Path(name))
    if has_blender():
        rows = scene_source(arguments).presets()
        alike = [row for row in rows if name.casefold() in (row.name.casefold(), row.path.stem.casefold())]
        if alike:
            return preset_rules.sound(min(alike, key=lambda row: bool(row.fault)).path)
        others = {row.name for row in rows if not row.fault}
    known = ", ".join([*PRESETS, *sorted(others)])
    raise UsageError(f'There is no preset "{name}"; choose one of {known}, or give a file (NAME.json).')


def notes_of_preset(arguments: argparse.Namespace, has_colors: bool = False) -> list[str]:
    """One sentence about members of the preset that have no effect in this command."""
    content = arguments.preset_content
    if content is None:
        return []
    unused = [name for name in content.image or {} if name == "image_format"]  # the suffix of an image's file decides
    unused += [] if has_colors else list(content.colors or {})
    verb = "have" if len(unused) > 1 else "has"
    return [f'The preset "{content.name}" names {", ".join(unused)}, which {verb} no effect here.'] if unused else []
