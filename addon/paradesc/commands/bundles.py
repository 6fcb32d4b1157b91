"""Copies the package's job descriptions to where a farm's engine finds them, with the values of a command."""

import json
import shlex
import shutil
from collections.abc import Collection
from pathlib import Path

from ..bridge import ParadescError, abi
from ..files.results import write_text, write_whole

FARMS = Path(__file__).resolve().parent.parent / "farms"
# Options that are parameters of the templates, or that the templates set.
OWN = ("--frames", "--cache", "--output", "-o", "--backend", "--descriptors", "--radius", "--progress")


def without_options(words: list[str], names: Collection[str]) -> tuple[list[str], dict[str, str]]:
    """The words without these options and their values, and the values by option."""
    rest: list[str] = []
    given: dict[str, str] = {}
    left = iter(words)
    for word in left:
        name, equals, value = word.partition("=")
        if name in names:
            given[name] = value if equals else next(left, "")
        else:
            rest.append(word)
    return rest, given


def values_of(words: list[str], own: dict[str, object], program: list[str]) -> dict[str, object]:
    """The values of a template's parameters that a command's words after its input mean, besides those of its own."""
    rest, given = without_options(words, OWN)
    named = {name.title(): given.get(f"--{name}", "") for name in ("descriptors", "radius")}
    backend = given.get("--backend", "cpu")
    more = {"Options": shlex.join(rest), "Paradesc": program[0]} if len(program) == 1 else {"Options": shlex.join(rest)}
    return {**own, **named, "Backend": backend, **more}


def files_of(folder: Path) -> list[Path]:
    """The files of a job bundle."""
    return [folder / "template.yaml", folder / "parameter_values.yaml"]


def write_bundle(folder: Path, kind: str, values: dict[str, object]) -> list[Path]:
    """Writes a job bundle of Open Job Description: its template, and the values of the template's parameters."""
    lines = ["parameterValues:"]
    for name, value in values.items():
        lines += [f"  - name: {name}", f"    value: {json.dumps(value, ensure_ascii=False)}"]  # JSON is YAML as well
    written = copied([FARMS / "openjd" / kind / "template.yaml"], folder)
    _, path = files_of(folder)
    write_whole(path, "\n".join([*lines, ""]), write_text)
    return [*written, path]


def copied(paths: list[Path], folder: Path) -> list[Path]:
    """Copies files of the package into a folder, which is made."""
    try:
        folder.mkdir(exist_ok=True)
        return [Path(shutil.copyfile(path, folder / path.name)) for path in paths]
    except OSError as error:
        sentence = f'"{folder}" cannot be written: {error.strerror or error}.'
        raise ParadescError(abi.STATUS_UNKNOWN, sentence) from error
