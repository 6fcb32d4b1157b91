"""The option --preset: finds the preset, which is built in, the user's or a file, and fills in options not given."""

import argparse
from pathlib import Path

from ..files import paths, preset_file, preset_rules
from ..files.preset_file import Content
from ..files.preset_rules import PRESETS
from .common import UsageError, has_blender
from .sources import scene_source

# The members that have no effect, because the suffix of an image's file decides.
WITHOUT_OPTION = ("image_format",)


def is_file(name: str) -> bool:
    """Whether --preset names a file: by its suffix, or because it is the path of an existing file in another folder."""
    path = Path(name)
    return path.suffix.lower() == preset_file.SUFFIX or (path.name != name and paths.is_file(path))


def check_preset(name: str | None) -> None:
    """Refuses an invalid preset file before anything else is read."""
    if name is not None and is_file(name):
        preset_rules.sound(Path(name))


def found_preset(name: str | None) -> Content | None:
    """The preset that --preset names: a built-in one, a file, or with Blender one of its preset folders."""
    if name is None:
        return None
    if name in PRESETS:
        return PRESETS[name].content()
    if is_file(name):
        return preset_rules.sound(Path(name))
    if not has_blender():
        raise UsageError(
            f'There is no preset "{name}"; choose one of {", ".join(PRESETS)}, or give a file (NAME.json).'
        )
    return preset_in_folders(name)


def preset_in_folders(name: str) -> Content:
    """The preset of this name in one of Blender's folders."""
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
