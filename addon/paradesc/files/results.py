"""Writes what a bake left behind as files: .npz, .ply and a JSON report. Never imports bpy."""

import json
import math
import os
import secrets
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import bridge
from ..bridge import ParadescError, abi
from ..core import color_maps, corners, legend, spaces
from ..core.distributions import statistics
from ..core.job import Results

# File names may contain bytes that are not valid text; this error handler lets JSON write them.
ESCAPED = "backslashreplace"
# So much of a name is used for the temporary file, which must not be too long if the name itself fits.
LONGEST_STEM = 60


@dataclass
class Baked:
    """One object's results, with the facts about the object that files need."""

    object_name: str
    results: Results
    arrays: bridge.MeshArrays
    matrix_world: np.ndarray  # (4, 4) float64
    notes: list[str] = field(default_factory=list)  # what was done to the input
    reading: object = None  # reading.Read: where the results belong in the scene
    limits: list[str] = field(default_factory=list)  # what limits the values, beside the results' own warnings

    @property
    def at_faces(self) -> bool:
        """Returns whether the results are values of triangles instead of vertices."""
        return self.results.settings.domain == "faces"

    @property
    def warnings(self) -> list[str]:
        """All sentences about what limits the values."""
        return [*self.results.warnings, *self.limits]

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """The results and extras as (n,) columns."""
        return columns_of({**self.results.values, **self.results.extras})

    def unit(self, name: str) -> str:
        """The unit of a descriptor's values as text."""
        return legend.unit_of(name, self.results.settings.options.map_descriptor)


def columns_of(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The (n,) columns of values (n,) or (n, 3), of which those of vectors are named name_x, name_y and name_z."""
    found = {}
    for name, array in values.items():
        parts = {name: array} if array.ndim == 1 else {f"{name}_{axis}": array[:, k] for k, axis in enumerate("xyz")}
        found.update(parts)
    return found


def write_npz(path: Path, baked: list[Baked]) -> None:
    """Writes the arrays of an object; if there are several, each name follows that of its object and a slash."""
    arrays = arrays_of(baked[0])
    if len(baked) > 1:
        arrays = {f"{one.object_name}/{name}": array for one in baked for name, array in arrays_of(one).items()}
    write_arrays(path, arrays)


def write_arrays(path: Path, arrays: dict[str, np.ndarray], packing: int = zipfile.ZIP_STORED) -> None:
    """Writes arrays as .npz, as np.savez() does, which complains of its archive a second time if the disk is full."""
    with path.open("wb") as file, zipfile.ZipFile(file, "w", packing) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)


def arrays_of(baked: Baked) -> dict[str, np.ndarray]:
    """Vertices (n, 3) in object space, matrix_world (4, 4), descriptors (n,) or (n, 3), and extras (n,).

    Values of faces are as long as the triangles (m, 3), which are then written too.
    """
    placed = {"vertices": baked.arrays.positions, "matrix_world": baked.matrix_world}
    if baked.at_faces:
        placed["triangles"] = baked.arrays.triangle_vertices
    return {**placed, **baked.results.values, **baked.results.extras}


def write_ply(path: Path, baked: Baked) -> None:
    """Writes a binary PLY in object space: vertices or faces with the first descriptor's colors, and all values."""
    first, column = next(iter(baked.results.values.items()))
    colors = np.round(255 * color_maps.colors(column, baked.results.shown(first))).astype(np.uint8)
    values = dict(zip(("red", "green", "blue"), colors.T, strict=True))
    values |= {name: array.astype("<f4") for name, array in baked.columns.items()}
    place = baked.arrays.positions.dtype.newbyteorder("<")
    points = {name: baked.arrays.positions[:, axis].astype(place) for axis, name in enumerate("xyz")}
    triangles = baked.arrays.triangle_vertices.astype("<i4")
    corners = {"count": np.full(len(triangles), 3, np.uint8), "vertices": triangles}
    vertices, faces = (table_of(points), table_of(corners | values)) if baked.at_faces else (
        table_of(points | values), table_of(corners))  # fmt: skip
    kinds = {"<f4": "float", "<f8": "double", "|u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", "comment Paradesc", f"element vertex {len(vertices)}"]
    header += [f"property {kinds[vertices.dtype[name].str]} {name}" for name in vertices.dtype.names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    header += [f"property {kinds[faces.dtype[name].str]} {name}" for name in faces.dtype.names if name not in corners]
    path.write_bytes("\n".join([*header, "end_header", ""]).encode() + vertices.tobytes() + faces.tobytes())


def table_of(columns: dict[str, np.ndarray]) -> np.ndarray:
    """(n,) rows of columns (n,) or (n, k), without gaps."""
    layout = [(name, column.dtype, column.shape[1:]) for name, column in columns.items()]
    table = np.empty(len(next(iter(columns.values()))), np.dtype(layout))
    for name, column in columns.items():
        table[name] = column
    return table


def joined(baked: list[Baked]) -> Baked:
    """Joins several objects into one in world space, with one range of colors. Directions rotate with the objects."""
    first = baked[0].results
    positions, corner_vertices, triangle_corners = [], [], []
    vertices = corners_before = 0
    for one in baked:
        matrix = one.matrix_world
        positions.append(one.arrays.positions.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])
        corner_vertices.append(one.arrays.corner_vertices + vertices)
        triangle_corners.append(one.arrays.triangle_corners + corners_before)
        vertices += len(one.arrays.positions)
        corners_before += len(one.arrays.corner_vertices)
    values = {name: np.concatenate([world_values(one, name) for one in baked]) for name in first.values}
    found = [one.results.corners for one in baked if one.results.corners is not None]
    painted = corners.Corners(np.zeros(0, np.int32), np.concatenate([one.painted for one in found])) if found else None
    arrays = bridge.MeshArrays(
        bridge.origin.stored(np.concatenate(positions)),
        np.concatenate(corner_vertices),
        np.concatenate(triangle_corners),
    )
    coverage = np.concatenate([one.results.coverage for one in baked])
    transfers, transfer = [one.results.transfer for one in baked], first.transfer
    if transfer is not None:  # for a common range of colors; there is no common image
        measured = {name: np.concatenate([one.measured[name] for one in transfers]) for name in transfer.measured}
        transfer = replace(transfer, measured=measured, images={})
    whole = replace(
        first,
        values=values,
        coverage=coverage,
        corners=painted,
        areas_of=first.areas_of and (lambda: np.concatenate([one.results.areas for one in baked])),
        transfer=transfer,
    )
    return Baked(", ".join(one.object_name for one in baked), whole, arrays, np.eye(4))


def world_values(baked: Baked, name: str) -> np.ndarray:
    """(n,) values unchanged, (n, 3) directions turned into world space."""
    values = baked.results.values[name]
    if values.ndim == 1 or baked.results.settings.space == "world":
        return values
    return spaces.turned(values, baked.matrix_world[:3, :3])


def report(baked: Baked) -> dict[str, object]:
    """The report on one object of a bake, without values and without facts that all objects share."""
    results = baked.results
    ranges = {}
    for name, values in results.values.items():
        shown = results.shown(name)
        ranges[name] = {
            **statistics(values),
            "shown_minimum": shown.minimum,
            "shown_maximum": shown.maximum,
            "color_map": shown.color_map.name,
            "radius": results.radius_of(name),
            "unit": baked.unit(name),
        }
    # The sources of transferred values, and how many texels met none of them.
    names = ("sources", "cage", "texels", "missed")
    met = {} if results.transfer is None else {"transfer": {name: getattr(results.transfer, name) for name in names}}
    return {
        "object": baked.object_name,
        "mesh_report": results.mesh_report,
        "field_report": results.field_report,
        "field_reports": {suffix: report for suffix, report in results.field_reports.items() if suffix},
        "descriptors": ranges,
        "corners": listed_corners(baked),
        **met,
        "notes": baked.notes,
        "warnings": baked.warnings,
    }


def listed_corners(baked: Baked) -> list[dict[str, object]]:
    """Vertex, position and response of each corner, the strongest first; none unless harris was asked for."""
    found = baked.results
    if found.corners is None:
        return []
    positions, response = baked.arrays.positions, found.values[found.harris]
    return [
        {"vertex": int(vertex), "position": [float(x) for x in positions[vertex]], "response": float(response[vertex])}
        for vertex in found.corners.vertices
    ]


def write_json(path: Path, content: object) -> None:
    """Writes plain Python as JSON, in which null replaces numbers that are not finite."""
    write_text(path, json_text(content))


def write_text(path: Path, text: str) -> None:
    """Writes a text that may contain file names."""
    path.write_text(text, encoding="utf-8", errors=ESCAPED)


def json_text(content: object, ascii_only: bool = False) -> str:
    """Plain Python as JSON, with null for numbers that are not finite; ascii_only: for consoles of any encoding."""
    return json.dumps(finite_only(content), indent=2, ensure_ascii=ascii_only) + "\n"


def place_fault(path: Path) -> str:
    """One sentence about why a path cannot be written, because of its name or its folder, or ""."""
    folder = path.absolute().parent
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:
        return f'"{path}" cannot be written: {getattr(error, "strerror", None) or error}.'
    return "" if folder.is_dir() else f'There is no folder "{folder}" to write "{path.name}" into.'


def file_fault(path: Path) -> str:
    """One sentence about why no file can be written there, or ""."""
    fault = place_fault(path)
    if fault:
        return fault
    if path.is_dir():
        return f'"{path}" is a folder, and cannot be written as a file; give it a name.'
    written = path if is_special(path) else path.absolute().parent
    return "" if os.access(written, os.W_OK) else f'"{path}" cannot be written.'


def is_special(path: Path) -> bool:
    """Returns whether a path is a device or a pipe, in whose place no file must be put."""
    return path.exists() and not path.is_file() and not path.is_dir()


def folder_fault(path: Path) -> str:
    """One sentence about why no folder of files can be made there, or ""."""
    fault = place_fault(path)
    if fault:
        return fault
    return f'"{path}" is a file; it has to be a folder.' if path.exists() and not path.is_dir() else ""


def make_folder(folder: Path) -> None:
    """Makes the folder and those above it, or says why it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        sentence = f'The folder "{folder}" cannot be made: {error.strerror or error}.'
        raise ParadescError(abi.STATUS_UNKNOWN, sentence) from error


def write_whole(path: Path, content: object, writer: Callable[[Path, Any], object]) -> None:
    """Writes a temporary file beside the path first, so that a failure leaves no half file and keeps an old one.

    A link stays, and the file that it names is written. A device or a pipe is written itself.
    """
    try:
        if is_special(path):
            writer(path, content)
        else:
            write_and_move(path.resolve() if path.is_symlink() else path, content, writer)
    except OSError as error:
        sentence = f'"{path}" cannot be written: {error.strerror or error}.'
        raise ParadescError(abi.STATUS_UNKNOWN, sentence) from error


def write_and_move(path: Path, content: object, writer: Callable[[Path, Any], object]) -> None:
    """Writes a temporary file and moves it to the path; a failure leaves none."""
    name = f".{path.name[:LONGEST_STEM]}.{secrets.token_hex(4)}.part"  # one for each writer
    temporary = path.absolute().parent / name
    try:
        writer(temporary, content)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def finite_only(content: object) -> object:
    """Replaces NaN and infinity, which JSON cannot hold, by None."""
    if isinstance(content, dict):
        return {name: finite_only(value) for name, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [finite_only(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content
