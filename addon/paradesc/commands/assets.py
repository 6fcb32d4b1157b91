"""Computes one asset of a library and describes it as a row, in the same way on every machine. Never imports bpy.

The results of FOLDER/props/crate.obj are OUT/results/props/crate.obj.npz, and its row is beside it as .json. Both files
are written completely or not at all, the row last, so every existing row has its results. Therefore a task may be
killed, repeated, and run twice at the same time. An asset that fails has a row alone.
"""

import hashlib
import json
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .. import __version__
from ..bridge import InputError, ParadescError, ProgressFunction, abi
from ..core import job
from ..core.distributions import distribution
from ..core.polygons import PolygonMesh
from ..files import mesh_files, results
from ..files.gltf_file import buffer_path
from ..files.paths import is_file
from ..files.reading import ReadRequest, read_mesh
from ..files.results import Baked, make_folder, write_whole
from .common import EXIT_FAILED, EXIT_INPUT, EXIT_USAGE, exit_code

RESULTS = "results"
# The exit codes of failures that the same file and settings always cause; such an asset is not tried again.
LASTING = (EXIT_USAGE, EXIT_INPUT)


@dataclass(frozen=True)
class Work:
    """The settings of a run, which are the same for every asset."""

    folder: Path
    output: Path
    settings: job.Settings
    key: str
    force: bool = False
    threads: int = 0  # for one asset, 0: all cores. Results do not depend on it
    version: str = __version__


@dataclass
class Done:
    """An asset's row, and whether it was computed in this run."""

    row: dict
    made: bool


def key_of(settings: job.Settings) -> str:
    """A name for settings. Results with the same key and content are the same."""
    flat = {name: value for name, value in settings.as_dict().items() if name != "device_index"}
    return hashlib.sha256(json.dumps([__version__, flat], sort_keys=True).encode()).hexdigest()[:32]


def paths_of(output: Path, name: str) -> tuple[Path, Path]:
    """The paths of an asset's arrays and of its row."""
    return output / RESULTS / f"{name}.npz", output / RESULTS / f"{name}.json"


def measure(work: Work, name: str, progress: ProgressFunction | None = None) -> Done:
    """The row of an asset. It is computed unless its results exist already. A failure also gives a row."""
    row = {"file": name, "status": "ok", "exit_code": 0, "error": None, "content_hash": None, "settings_key": work.key}
    try:
        if work.version != __version__:
            sentence = f"This machine has Paradesc {__version__}, but {work.version} was asked for; install that here."
            raise ParadescError(abi.STATUS_UNSUPPORTED, sentence)
        row["content_hash"] = content_hash(work.folder / name)
        found = None if work.force else kept_row(work, row)
        if found is not None:
            return Done(found, False)
        row.update(computed(work, name, progress))
    except ParadescError as error:
        if error.status == abi.STATUS_CANCELLED:
            raise
        row = failed(row, error.sentence, exit_code(error))
    except Exception as error:  # noqa: BLE001 (one asset must not end the run; its row says what happened)
        row = failed(row, f"Unexpected {type(error).__name__}: {error}", EXIT_FAILED)
    write_row(work, row)
    return Done(row, True)


def failed(row: dict, sentence: str, code: int) -> dict:
    """The row of an asset that could not be computed."""
    return {**row, "status": "failed", "exit_code": code, "error": " ".join(sentence.split())}


def write_row(work: Work, row: dict) -> None:
    """Writes a row beside the results, or in place of former ones if the asset failed."""
    arrays, path = paths_of(work.output, row["file"])
    make_folder(path.parent)
    write_whole(path, line_of(row), results.write_text)
    if row["status"] == "failed":
        arrays.unlink(missing_ok=True)


def line_of(row: dict) -> str:
    """A row as one line of JSON, in which null replaces numbers that are not finite."""
    return json.dumps(results.finite_only(row), ensure_ascii=False) + "\n"


# ---- What is there


def content_hash(path: Path) -> str:
    """SHA-256 of a file and of the buffers that a .gltf keeps beside it."""
    try:
        content = path.read_bytes()
        found = hashlib.sha256(content)
        for buffer in buffers_beside(path, content):
            found.update(buffer.read_bytes())
        return found.hexdigest()
    except OSError as error:
        raise InputError(f'"{path}" cannot be read: {error.strerror or error}.') from error


def buffers_beside(path: Path, content: bytes) -> list[Path]:
    """The files that a .gltf names as its buffers; none for other formats or a damaged file."""
    if path.suffix.lower() != ".gltf":
        return []
    try:
        names = [str(buffer.get("uri", "")) for buffer in json.loads(content).get("buffers", [])]
    except (ValueError, TypeError, AttributeError, RecursionError):
        return []
    places = [buffer_path(path, name) for name in names if name and not name.startswith("data:")]
    return [place for place in places if is_file(place)]


def kept_row(work: Work, asked: dict) -> dict | None:
    """The row of an earlier run, if it has this content and these settings and its results exist."""
    arrays, path = paths_of(work.output, asked["file"])
    try:
        row = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        row = None
    if not isinstance(row, dict):  # there is none, or a damaged one
        return None
    if any(row.get(name) != asked[name] for name in ("file", "content_hash", "settings_key")):
        return None
    if row.get("status") == "failed":
        return row if row.get("exit_code") in LASTING else None
    try:
        size = arrays.stat().st_size
    except OSError:
        return None
    return row if size == row.get("results_bytes") else None


# ---- Computing


def computed(work: Work, name: str, progress: ProgressFunction | None) -> dict[str, object]:
    """Computes an asset and writes its arrays; returns the facts for its row."""
    started = time.monotonic()
    meshes = mesh_files.read(work.folder / name)
    read = time.monotonic()
    settings = replace(work.settings, threads=work.threads)
    parts = [job.part_of(progress, index, len(meshes)) for index in range(len(meshes))]
    baked = [bake(mesh, settings, part) for mesh, part in zip(meshes, parts, strict=True)]
    done = time.monotonic()
    path, row = paths_of(work.output, name)
    make_folder(path.parent)
    row.unlink(missing_ok=True)  # which is of former arrays; a run that is killed must not leave it beside these
    write_whole(path, baked, results.write_npz)
    content = path.read_bytes()
    first = baked[0].results
    return {
        "objects": [described_object(one) for one in baked],
        "warnings": list(dict.fromkeys(sentence for one in baked for sentence in one.warnings)),
        "notes": list(dict.fromkeys(sentence for one in baked for sentence in one.notes)),
        "backend": first.backend,
        "device": first.device,
        "version": __version__,
        "results": path.relative_to(work.output).as_posix(),
        "results_bytes": len(content),
        "results_hash": hashlib.sha256(content).hexdigest(),
        "seconds": {"read": read - started, "compute": done - read, "write": time.monotonic() - done},
    }


def bake(mesh: PolygonMesh, settings: job.Settings, progress: ProgressFunction | None) -> Baked:
    """Computes one mesh of a file as paradesc bake does without Blender."""
    read = read_mesh(mesh, settings, ReadRequest(remedy="give --space world"))
    found = job.run(read.measured, settings, progress)
    notes = [*read.sentences, *found.unused_notes()]
    return Baked(mesh.name, found, read.arrays, mesh.matrix_world, notes, limits=found.facet_notes())


def described_object(baked: Baked) -> dict[str, object]:
    """The facts about one object for a row: those of a bake's report that differ between assets, and distributions."""
    found = baked.results
    known = found.coverage[~np.isnan(found.coverage)]  # NaN at vertices without a face
    report = results.report(baked)
    for name, row in report["descriptors"].items():
        if found.values[name].ndim == 1:
            row.update(distribution(found.values[name]))
    names = ("vertex_count", "triangle_count", "charts", "boundary_edges")
    return {
        "object": baked.object_name,
        "mesh_report": {name: found.mesh_report[name] for name in names if name in found.mesh_report},
        "coverage": {"mean": float(known.mean()) if known.size else None, "minimum": float(known.min(initial=1.0))},
        "radius": found.radius,
        "corners": len(report["corners"]),
        "descriptors": report["descriptors"],
    }


def of_part(names: Iterable[str], part: tuple[int, int] | None) -> list[str]:
    """The names that belong to part (k, n), of about equal parts; None stands for all. Other names do not matter."""
    if part is None:
        return list(names)
    number, count = part
    return [name for name in names if int(hashlib.sha256(name.encode()).hexdigest()[:12], 16) % count == number - 1]
