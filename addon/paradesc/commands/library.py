"""paradesc library: computes every asset of a folder, on this machine or on many, and lists them as lines of JSON."""

import argparse
import os
import re
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NoReturn

from .. import bridge
from ..bridge import InputError
from ..core import job
from ..files import mesh_files, results
from ..files.paths import is_file, is_folder
from ..files.results import folder_fault, make_folder, write_whole
from . import assets, options, spreading
from .assets import Done, Work
from .common import Parser, Progress, UsageError, print_notes, refuse

LISTING = "library.jsonl"
PART = re.compile(r"(\d{1,7})/(\d{1,7})")


HELP = "compute every asset of a folder, on one machine or many"


def add_options(parser: Parser) -> None:
    """The command's options."""
    add = parser.add_argument
    add("input", metavar="FOLDER", type=Path, help=f"with files of {', '.join(mesh_files.SUFFIXES)}, at any depth")
    add("--output", "-o", metavar="OUT", type=Path, required=True,
        help=f"folder of the results and of {LISTING}, a line for each asset")  # fmt: skip
    add("--workers", type=int, metavar="N", help="processes on this machine (default: one for each core)")
    add("--threads", type=int, metavar="N", help="cores that compute one asset (default: 1, with one worker all)")
    add("--dask", metavar="ADDRESS",
        help="compute on the workers of this Dask scheduler: tcp://host:8786, or a .json scheduler file")  # fmt: skip
    add("--part", type=part, metavar="K/N", help="compute one of N equal parts, which other machines may share")
    add("--asset", action="append", default=[], metavar="NAME",
        help="compute this file alone, named from FOLDER on; give it again for more")  # fmt: skip
    add("--allow-failures", action="store_true",
        help="do not end with code 5 for assets that no machine can compute; their rows say why")  # fmt: skip
    add("--force", action="store_true", help="compute assets again that have results")
    options.add_computation_options(parser)


def files_beside(arguments: argparse.Namespace) -> list[Path]:
    """The files that the command writes and that no option names."""
    return [arguments.output / LISTING]


def part(text: str) -> tuple[int, int]:
    """Parses K/N, with K from 1 to N."""
    found = PART.fullmatch(text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise argparse.ArgumentTypeError(
            f'"{text}" is not a part; give two numbers such as 3/16, the first at most the second'
        )
    return int(found[1]), int(found[2])


@dataclass
class Tally:
    """Counts over the finished assets, and the line of JSON of each as text, which takes less memory than its row."""

    lines: dict[str, str] = field(default_factory=dict)
    failures: list[dict] = field(default_factory=list)
    warned: int = 0
    made: int = 0
    compute_seconds: float = 0.0

    def add(self, done: Done) -> None:
        """Counts one more asset."""
        row = done.row
        self.lines[row["file"]] = assets.line_of(row)
        self.warned += bool(row.get("warnings"))
        self.made += done.made
        if row["status"] == "failed":
            self.failures.append({name: row[name] for name in ("file", "exit_code", "error")})
        elif done.made:
            self.compute_seconds += sum(row["seconds"].values())


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Computes the missing assets; returns the report on all assets that were asked for."""
    check(arguments)
    settings = options.opened_settings(arguments)
    backend = job.backend_for(settings)  # one for all machines, so that all results have the same bits
    settings = replace(settings, backend=backend)
    names = asked(arguments)
    make_folder(arguments.output)
    workers = 1 if spreading.in_blender() else arguments.workers or min(spreading.cores(), max(1, len(names)))
    work = work_of(arguments, settings, workers)
    started = time.monotonic()
    tally = Tally()
    with Progress(arguments.progress) as progress:
        for done in spread(arguments, work, names, workers, progress):
            tally.add(done)
            progress(done.row["file"], len(tally.lines) / len(names))
    tally.failures.sort(key=lambda row: row["file"])
    listing = arguments.output / LISTING
    listed = not (arguments.part or arguments.asset)
    if listed:
        write_whole(listing, "".join(tally.lines[name] for name in sorted(tally.lines)), results.write_text)
    return report(arguments, work, tally, listing if listed else None, time.monotonic() - started)


def check(arguments: argparse.Namespace) -> None:
    """Refuses options that contradict each other, before any file is opened."""
    if arguments.scene_settings or arguments.shape_key:
        raise UsageError(
            "The files of a library have no scene and no shape keys; leave --scene-settings and --shape-key out."
        )
    options.check(arguments)
    refuse(folder_fault(arguments.output))
    for name in ("workers", "threads"):
        if (given := getattr(arguments, name)) is not None and given < 1:
            raise UsageError(f"--{name} is {given}; it must be at least 1.")
    if spreading.in_blender() and (arguments.workers or 1) > 1:
        raise UsageError("Blender starts no processes of Python; leave --workers out, and one takes all cores.")
    if arguments.dask and arguments.workers:
        raise UsageError("Dask has workers of its own; leave --workers or --dask out.")
    if arguments.part and arguments.asset:
        raise UsageError("Give --part or --asset, not both.")


def asked(arguments: argparse.Namespace) -> list[str]:
    """The assets to compute, the largest files first, so that none of them starts last."""
    folder = arguments.input
    if arguments.asset:
        names = dict.fromkeys(Path(name).as_posix() for name in arguments.asset)
        for name in names:
            if not is_file(folder / name):
                raise InputError(f'There is no file "{name}" in "{folder}".')
        return list(names)
    sizes = dict(found(folder))
    return sorted(assets.of_part(sizes, arguments.part), key=lambda name: (-sizes[name], name))


def found(folder: Path) -> Iterator[tuple[str, int]]:
    """The name of every asset below a folder, from there on and with slashes, and its size in bytes."""
    if not is_folder(folder):
        raise InputError(f'There is no folder "{folder}".')
    for root, folders, names in os.walk(folder, onerror=refuse_folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            path = Path(root, name)
            if path.suffix.lower() in mesh_files.SUFFIXES and not name.startswith("."):
                size = 0  # if it cannot be told
                with suppress(OSError):
                    size = path.stat().st_size
                yield path.relative_to(folder).as_posix(), size


def refuse_folder(error: OSError) -> NoReturn:
    """Refuses a library with a folder that cannot be read, whose assets would be missing."""
    raise InputError(f'The folder "{error.filename}" cannot be read: {error.strerror}.') from error


def work_of(arguments: argparse.Namespace, settings: job.Settings, workers: int) -> Work:
    """The settings that all assets share. Folders are absolute, as other machines have other working directories."""
    alone = workers == 1 and not arguments.dask
    threads = arguments.threads or (0 if alone else 1)
    folder, output = arguments.input.absolute(), arguments.output.absolute()
    if workers > 1 and not (settings.memory_limit or arguments.dask):  # they share what one would take for itself
        settings = replace(settings, memory_limit=bridge.allowed_memory(0) // workers)
    return Work(folder, output, settings, assets.key_of(settings), arguments.force, threads)


def spread(
    arguments: argparse.Namespace, work: Work, names: list[str], workers: int, progress: Progress
) -> Iterator[Done]:
    """Computes the assets here, in other processes, or on Dask's workers; yields each when it is done."""
    check = progress.check
    if arguments.dask:
        with spreading.connected(arguments.dask) as client:
            yield from spreading.on_dask(work, names, client, check)
    elif workers > 1 and len(names) > 1:
        yield from spreading.on_processes(work, names, workers, check)
    else:
        for index, name in enumerate(names):
            check()
            yield assets.measure(work, name, job.part_of(progress, index, len(names)))


def report(
    arguments: argparse.Namespace, work: Work, tally: Tally, listing: Path | None, seconds: float
) -> dict[str, object]:
    """Prints a summary in a few lines; returns the report."""
    count, failures = len(tally.lines), tally.failures
    kept = count - tally.made
    print(f"{counted(count)}: {tally.made:,} computed, {kept:,} kept, {len(failures):,} of them failed")
    print(f"{seconds:.2f} s; over all assets, reading, computing and writing took {tally.compute_seconds:.2f} s")
    notes = options.notes_of_preset(arguments)
    notes += [f"Warnings are in the rows of {counted(tally.warned)}."] if tally.warned else []
    print_notes(notes)
    if listing is not None:
        print(f"wrote {listing}")
    return {
        "settings": work.settings.as_dict(),
        "settings_key": work.key,
        "assets": count,
        "made": tally.made,
        "kept": kept,
        "failed": failures,
        "listing": None if listing is None else str(listing),
        "notes": notes,
        "warnings": [],
        "seconds": {"run": seconds, "assets": tally.compute_seconds},
        "failed_checks": failed_checks(arguments, failures, count),
    }


def failed_checks(arguments: argparse.Namespace, failures: list[dict], count: int) -> list[str]:
    """One sentence if assets failed; with --allow-failures only about assets that another machine might compute."""
    if arguments.allow_failures:
        failures = [row for row in failures if row["exit_code"] not in assets.LASTING]
    if not failures:
        return []
    first = failures[0]
    verb = "could not be computed"
    return [f'{len(failures):,} of {counted(count)} {verb}, "{first["file"]}" first: {first["error"]}']


def counted(count: int) -> str:
    """A number of assets in words."""
    return "1 asset" if count == 1 else f"{count:,} assets"
