"""What --preset means: a preset of the panel, or a file, whose settings are taken for what no option gives."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

from ..core import job
from ..core.color_maps import Look
from ..files import old_presets, preset_file
from ..files.preset_file import Content
from .common import UsageError

# What the command line says by the suffix of an image's file.
WITHOUT_OPTION = ("image_format",)


def is_file(name: str) -> bool:
    """Whether --preset names a file and no preset: by its suffix, or by a folder in front of a file that is there."""
    path = Path(name)
    return path.suffix.lower() in old_presets.SUFFIXES or (path.name != name and path.is_file())


def check_preset(name: str | None) -> None:
    """Refuses a file that is no preset before Blender is needed; its members are checked once Blender is there."""
    if name is not None and is_file(name):
        old_presets.read_any(Path(name))


def found_preset(name: str | None) -> Content | None:
    """The preset of the panel, the file, or the preset in one of Blender's folders that is called so."""
    if name is None:
        return None
    from ..settings import preset_folders, preset_members, presets

    if name in presets.PRESETS:
        return presets.PRESETS[name].content()
    if is_file(name):
        return preset_members.sound(Path(name))
    row = preset_folders.row_named(name)
    if row is None:
        known = ", ".join(
            [*presets.PRESETS, *sorted({row.name for row in preset_folders.every_row() if not row.fault})]
        )
        raise UsageError(f'There is no preset "{name}"; choose one of {known}, or give a file (NAME.json).')
    return preset_members.sound(row.path)


def with_preset(content: Content | None, base: job.Settings | None) -> job.Settings | None:
    """The settings with those of a preset; the device, the space and the limit of memory stay."""
    if content is None:
        return base
    from ..settings import preset_members, properties

    base = base or job.Settings()
    texels = (content.image or {}).get("texels", base.options.texels)
    if content.settings is None:
        return replace(base, options=replace(base.options, texels=texels))
    values = preset_file.completed(content.settings, preset_members.rules()["settings"])
    machine = {"backend": base.backend, "device_index": base.device_index, "space": base.space}
    made = properties.job_settings(SimpleNamespace(**values, **machine, texels=texels))
    return replace(made, memory_limit=base.memory_limit)


def look_of_preset(content: Content | None, otherwise: Look | None) -> Look | None:
    """The look that a preset asks for, if it says anything of colors."""
    if content is None or content.colors is None:
        return otherwise
    from ..settings import looks, preset_members

    return looks.look_of(SimpleNamespace(**preset_file.completed(content.colors, preset_members.rules()["colors"])))


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
