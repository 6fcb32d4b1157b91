"""What --preset means: a preset of ours, of the user or in a file, which supplies what no option gives."""

from pathlib import Path

from ..core import job
from ..core.color_maps import Look
from ..files import old_presets, paths, preset_rules
from ..files.preset_file import Content
from ..files.preset_rules import PRESETS
from .common import UsageError, has_blender

# What the command line says by the suffix of an image's file.
WITHOUT_OPTION = ("image_format",)


def is_file(name: str) -> bool:
    """Whether --preset names a file and no preset: by its suffix, or by a folder in front of a file that is there."""
    path = Path(name)
    return path.suffix.lower() in old_presets.SUFFIXES or (path.name != name and paths.is_file(path))


def check_preset(name: str | None) -> None:
    """Refuses a file that is no sound preset, before anything else is read."""
    if name is not None and is_file(name):
        preset_rules.sound(Path(name))


def found_preset(name: str | None) -> Content | None:
    """The preset of ours or in a file, or where Blender is the one in one of its folders, that is called so."""
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
    """The preset in one of Blender's folders that is called so."""
    from ..settings import preset_folders

    row = preset_folders.row_named(name)
    if row is None:
        others = {row.name for row in preset_folders.every_row() if not row.fault}
        known = ", ".join([*PRESETS, *sorted(others)])
        raise UsageError(f'There is no preset "{name}"; choose one of {known}, or give a file (NAME.json).')
    return preset_rules.sound(row.path)


def with_preset(content: Content | None, base: job.Settings | None) -> job.Settings | None:
    """The settings with those of a preset; the device, the space and the limit of memory stay."""
    return base if content is None else preset_rules.settings_of(content, base or job.Settings())


def look_of_preset(content: Content | None, otherwise: Look | None) -> Look | None:
    """The look that a preset asks for, if it says anything of colors."""
    return otherwise if content is None else preset_rules.look_of(content, otherwise)


def notes_of_preset(content: Content | None, has_colors: bool) -> list[str]:
    """One sentence about what a preset says that a command has no option for."""
    if content is None:
        return []
    unused = [name for name in content.image or {} if name in WITHOUT_OPTION]
    unused += [] if has_colors else list(content.colors or {})
    if not unused:
        return []
    verb = "have" if len(unused) > 1 else "has"
    return [f'Of the preset "{content.name}", {", ".join(unused)} {verb} no effect here.']
