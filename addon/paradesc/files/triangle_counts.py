"""Estimates the number of triangles in a mesh file by its first bytes and its size, without reading all of it.

A list of tasks for a million files must not take as long as the tasks.
"""

import json
import re
import struct
from pathlib import Path

from .stl_file import HEADER, TRIANGLE

FIRST_BYTES = 1 << 16
# Bytes that a triangle takes in files of text, with its share of vertices, normals and texture coordinates.
TEXT_BYTES = {".obj": 45, ".stl": 260, ".ply": 45, ".off": 45, ".vtk": 25, ".vtp": 15, ".gii": 20}
BINARY_BYTES = 18  # the same of FreeSurfer's
GLTF_BYTES = 24  # of a triangle, where the file does not tell


def triangles(path: Path) -> int:
    """The number of triangles, exact where a header has it; a file that cannot be read has none."""
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            first = file.read(FIRST_BYTES)
        return max(0, counted(path.suffix.lower(), first, size))
    except (OSError, ValueError, TypeError, KeyError, IndexError, AttributeError, struct.error, RecursionError):
        return 0


def counted(suffix: str, first: bytes, size: int) -> int:
    """The number of triangles of a file of this suffix, first bytes and size."""
    if suffix == ".ply":
        found = re.search(rb"element face (\d+)", first)
        return int(found[1]) if found else 0
    if suffix == ".stl" and (size - HEADER) % TRIANGLE.itemsize == 0 and not first.startswith(b"solid"):
        return (size - HEADER) // TRIANGLE.itemsize
    if suffix == ".off":
        found = re.search(rb"\d+\s+(\d+)", re.sub(rb"#[^\r\n]*", b"", first[:1000]))
        return int(found[1])
    if suffix in (".glb", ".gltf"):
        return counted_gltf(first, size)
    found = re.search(rb"^POLYGONS (\d+)|NumberOfPolys=\"(\d+)\"", first, re.MULTILINE)
    if found:  # a point more is named where VTK tells where each begins
        return int(found[1] or found[2])
    return size // TEXT_BYTES.get(suffix, BINARY_BYTES)


def counted_gltf(first: bytes, size: int) -> int:
    """The number of triangles of a glTF file, by the counts of its indices."""
    text = first
    if first[:4] == b"glTF":
        (length,) = struct.unpack_from("<I", first, 12)
        text = first[20 : 20 + length]
    try:
        content = json.loads(text)
    except ValueError:  # the part that was read ends within the JSON
        return size // GLTF_BYTES
    primitives = [part for mesh in content.get("meshes", []) for part in mesh["primitives"]]
    counts = [
        content["accessors"][part["indices"] if "indices" in part else part["attributes"]["POSITION"]]["count"]
        for part in primitives
    ]
    return sum(counts) // 3
