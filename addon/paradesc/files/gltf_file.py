"""Reads a .glb or .gltf 2.0 into one mesh for each node that has one, with the vertices of the file's own tables.

Primitives of a mesh, which have a material each, are joined; those that share a table of positions share its vertices.
Materials, skins, shapes of morphs and animations are left out: the mesh is measured as it is stored.
"""

import base64
import json
import re
import struct
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..core.polygons import PolygonMesh, triangles_of_fan, triangles_of_strips, vertices_at
from .paths import is_file

# These change no position and no face, so that a file that requires them can be read without them.
HARMLESS = (
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_", "KHR_xmp",
    "KHR_animation_", "KHR_node_", "KHR_audio", "KHR_interactivity", "KHR_mesh_quantization", "KHR_accessor_",
    "EXT_structural_metadata", "EXT_mesh_features", "EXT_instance_features", "CESIUM_primitive_outline", "MSFT_lod",
    "VRM", "OMI_", "ADOBE_materials_", "AGI_",
)  # fmt: skip
KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
STRIP, FAN, TRIANGLES = 5, 6, 4
MOST_PLACES = 1 << 20


class UnknownError(ValueError):
    """The file may be valid, but uses a feature that this reader does not know."""


@dataclass
class Document:
    """The header of a file, and its buffers as they are asked for."""

    header: dict
    path: Path
    binary: bytes = b""
    buffers: dict[int, bytes] = field(default_factory=dict)

    def buffer(self, index: int) -> bytes:
        """The bytes of a buffer: from the .glb itself, from its data URI, or from a file beside it."""
        if index not in self.buffers:
            row = self.header["buffers"][index]
            found = self.binary if "uri" not in row else addressed(self.path, row["uri"])
            if len(found) < row["byteLength"]:
                raise ValueError(f"buffer {index} has {len(found):,} of {row['byteLength']:,} bytes; it was cut off")
            self.buffers[index] = found
        return self.buffers[index]

    def view(self, index: int, kind: np.dtype, count: int, width: int, offset: int) -> np.ndarray:
        """(count, width) numbers of a view of a buffer, from a byte of it on."""
        row = self.header["bufferViews"][index]
        if "EXT_meshopt_compression" in row.get("extensions", {}):
            raise UnknownError("its buffers are compressed (EXT_meshopt_compression); export it without compression")
        begin, size = row.get("byteOffset", 0), kind.itemsize * width
        stride = row.get("byteStride", size)
        content = memoryview(self.buffer(row["buffer"]))[begin : begin + row["byteLength"]]
        if count == 0:
            return np.empty((0, width), kind)
        if offset < 0 or count < 0 or stride < size or offset + stride * (count - 1) + size > len(content):
            raise ValueError(f"an accessor reaches beyond its buffer view {index}")
        return np.ndarray((count, width), kind, content, offset, (stride, kind.itemsize))

    def accessor(self, index: int) -> np.ndarray:
        """(n, width) numbers, integers as they are or, if they are normalized, as the float32 that they stand for."""
        row = self.header["accessors"][index]
        kind, width, count = np.dtype(KINDS[row["componentType"]]), WIDTHS[row["type"]], int(row["count"])
        if "bufferView" in row:
            values = self.view(row["bufferView"], kind, count, width, row.get("byteOffset", 0))
        elif not 0 <= count <= 1 << 28:
            raise ValueError(f"accessor {index} has {count:,} rows")
        else:
            values = np.zeros((count, width), kind)
        if "sparse" in row:
            values = self.replaced(values.copy(), row["sparse"])
        if not row.get("normalized", False) or kind.kind == "f":
            return values
        return np.maximum(values / np.float32(np.iinfo(kind).max), np.float32(-1)).astype(np.float32)

    def replaced(self, values: np.ndarray, sparse: dict) -> np.ndarray:
        """The rows, in which a sparse accessor replaces some."""
        at, new, count = sparse["indices"], sparse["values"], int(sparse["count"])
        kind = np.dtype(KINDS[at["componentType"]])
        places = self.view(at["bufferView"], kind, count, 1, at.get("byteOffset", 0))[:, 0]
        if count and places.max() >= len(values):
            raise ValueError("a sparse accessor replaces rows that are not there")
        values[places] = self.view(new["bufferView"], values.dtype, count, values.shape[1], new.get("byteOffset", 0))
        return values


def read(path: Path) -> list[PolygonMesh]:
    """The mesh of each node with triangles; raises ValueError if the file is damaged."""
    try:
        document = opened(path)
        header = document.header
        check(header)
        meshes = header.get("meshes", [])
        nodes, places = header.get("nodes", []), shown_places(header)
        found = [(node, nodes[node]["mesh"], place) for node, place in places if "mesh" in nodes[node]]
        if not any("mesh" in node for node in nodes):  # a library of meshes
            found = [(index, index, np.eye(4)) for index in range(len(meshes))]
            nodes = [{} for _ in meshes]
        shared = shared_tables(meshes)
        parts = {mesh: part_of(document, mesh, shared) for mesh in dict.fromkeys(mesh for _, mesh, _ in found)}
        return [
            replace(parts[mesh], name=str(nodes[node].get("name") or meshes[mesh].get("name") or f"node {node}"),
                    matrix_world=place)
            for node, mesh, place in found
        ]  # fmt: skip
    except (KeyError, IndexError, TypeError, AttributeError, OverflowError, struct.error, RecursionError) as error:
        raise ValueError(f"its header is damaged ({type(error).__name__}: {error})") from error


def opened(path: Path) -> Document:
    """The header and, of a .glb, the bytes that follow it."""
    content, binary = path.read_bytes(), b""
    if content[:4] == b"glTF":
        version, _, length, kind = struct.unpack_from("<II I4s", content, 4) if len(content) >= 20 else (2, 0, 0, b"")
        check_version(str(version))
        if kind != b"JSON" or 20 + length > len(content):
            raise ValueError("it does not begin as one, or was cut off")
        rest, content = content[20 + length :], content[20 : 20 + length]
        if len(rest) >= 8:
            size, kind = struct.unpack_from("<I4s", rest)
            binary = rest[8 : 8 + size] if kind == b"BIN\0" else b""
    elif path.suffix.lower() == ".glb":
        raise ValueError("it does not begin as one")
    try:
        header = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"its header is not JSON: {error}") from error
    if not isinstance(header, dict):
        raise ValueError("its header is not a JSON object")
    return Document(header, path, binary)


def check(header: dict) -> None:
    """Refuses files that would be misread without anybody noticing."""
    check_version(str(header.get("asset", {}).get("version", "2.0")))
    unknown = [name for name in map(str, header.get("extensionsRequired", [])) if not name.startswith(HARMLESS)]
    if unknown:
        compressed = all("compression" in name for name in unknown)
        remedy = "without compression" if compressed else "without them, or let Blender read it (--reader blender)"
        raise UnknownError(f"it needs the extensions {', '.join(unknown)}; export it {remedy}")


def check_version(version: str) -> None:
    """Refuses glTF 1."""
    if version.partition(".")[0] != "2":
        raise UnknownError(f"it is glTF {version[:20]}, and this reader knows 2.0; convert it")


def unescaped(address: str) -> bytes:
    """The bytes of a URI whose escapes, such as %20, are decoded."""
    return re.sub(rb"%([0-9A-Fa-f]{2})", lambda found: bytes.fromhex(found[1].decode()), address.encode())


def buffer_path(path: Path, uri: str) -> Path:
    """The path of a file beside the .gltf that a URI names, with escapes or without."""
    beside = path.parent / unescaped(uri).decode("utf-8", "replace")
    return beside if is_file(beside) else path.parent / uri


def addressed(path: Path, uri: str) -> bytes:
    """The bytes of a data URI, or of a file beside the .gltf."""
    if uri.startswith("data:"):
        about, _, text = uri.partition(",")
        try:
            return base64.b64decode(text) if about.endswith(";base64") else unescaped(text)
        except ValueError as error:
            raise ValueError(f"a buffer in it is damaged: {error}") from error
    try:
        return buffer_path(path, uri).read_bytes()
    except (OSError, ValueError) as error:
        raise ValueError(f'its buffer "{uri[:80]}" is not beside it; keep both in one folder') from error


def shown_places(header: dict) -> list[tuple[int, np.ndarray]]:
    """Number and (4, 4) float64 place of each node of the file's scene, or of all nodes if it has no scenes."""
    nodes, scenes = header.get("nodes", []), header.get("scenes", [])
    below = {child for node in nodes for child in node.get("children", [])}
    roots = [number for number in range(len(nodes)) if number not in below]
    if scenes:
        roots = scenes[header.get("scene", 0)].get("nodes", [])
    places: list[tuple[int, np.ndarray]] = []
    waiting = [(root, np.eye(4), 1) for root in roots]
    while waiting:
        number, above, depth = waiting.pop()
        if depth > len(nodes) or len(places) > MOST_PLACES:
            raise ValueError(f"node {number} is below itself, or there are too many places of nodes")
        places.append((number, above @ own_place(nodes[number])))
        waiting += [(child, places[-1][1], depth + 1) for child in reversed(nodes[number].get("children", []))]
    return sorted(places, key=lambda row: row[0])


def own_place(node: dict) -> np.ndarray:
    """(4, 4) float64 transform of a node relative to its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), np.float64).reshape(4)
    place = np.eye(4)
    place[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    place[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), np.float64).reshape(3)
    place[:3, 3] = np.array(node.get("translation", (0, 0, 0)), np.float64).reshape(3)
    return place


def shared_tables(meshes: list[dict]) -> set[int]:
    """The accessors of positions that several meshes share."""
    owners: dict[int, set[int]] = {}
    for number, mesh in enumerate(meshes):
        for primitive in mesh["primitives"]:
            owners.setdefault(primitive.get("attributes", {}).get("POSITION", -1), set()).add(number)
    return {table for table, found in owners.items() if len(found) > 1}


def part_of(document: Document, number: int, shared: set[int]) -> PolygonMesh:
    """The triangles of a mesh; it has texture coordinates and normals if all primitives have.

    If meshes share a table of positions, each mesh keeps the vertices that it uses.
    """
    tables: dict[int, tuple[int, np.ndarray]] = {}  # where each begins among the vertices
    triangles, uvs, normals = [np.empty((0, 3), np.int64)], [], []
    for primitive in document.header["meshes"][number]["primitives"]:
        if primitive.get("mode", TRIANGLES) not in (TRIANGLES, STRIP, FAN):
            continue
        if "POSITION" not in primitive["attributes"]:
            raise ValueError(f"a primitive of mesh {number} has no positions")
        compressed = [name for name in primitive.get("extensions", {}) if "compression" in name]
        table = primitive["attributes"]["POSITION"]
        if compressed and "bufferView" not in document.header["accessors"][table]:
            raise UnknownError(f"it is compressed ({compressed[0]}); export it without compression")
        if table not in tables:
            begin = sum(len(points) for _, points in tables.values())
            found = document.accessor(table)
            if found.shape[1] != 3:
                raise ValueError("positions have not three coordinates")
            tables[table] = begin, found.astype(np.float32)
        begin, points = tables[table]
        local = faces(document, primitive, len(points))
        triangles.append(local + begin)
        uvs.append(at_corners(document, primitive, "TEXCOORD_0", 2, local))
        normals.append(at_corners(document, primitive, "NORMAL", 3, local))
    points = np.concatenate([np.empty((0, 3), np.float32), *(points for _, points in tables.values())])
    whole = np.concatenate(triangles)
    if shared & tables.keys():
        kept, whole = np.unique(whole, return_inverse=True)
        points, whole = points[kept], whole.reshape(-1, 3)
    uvs_whole = of_all(uvs)
    if uvs_whole is not None:
        uvs_whole = uvs_whole * np.float32([1, -1]) + np.float32([0, 1])  # whose origin is the upper left corner
    corners, sizes = whole.reshape(-1).astype(np.int32), np.full(len(whole), 3, np.int64)
    return PolygonMesh(points, corners, sizes, uvs_whole, of_all(normals))


def faces(document: Document, primitive: dict, vertex_count: int) -> np.ndarray:
    """(m, 3) int64 vertices of the triangles of a primitive, of a strip or of a fan."""
    if "indices" in primitive:
        table = document.accessor(primitive["indices"])
        restart = np.iinfo(table.dtype).max if table.dtype.kind == "u" else None  # forbidden, and written all the same
        vertices = table[:, 0].astype(np.int64)
    else:
        restart, vertices = None, np.arange(vertex_count)
    mode = primitive.get("mode", TRIANGLES)
    if mode == STRIP:
        found = triangles_of_strips(vertices, restart)
    elif mode == FAN:
        found = triangles_of_fan(vertices)
    else:
        found = vertices[: len(vertices) // 3 * 3].reshape(-1, 3)
    return vertices_at(found, vertex_count)


def at_corners(document: Document, primitive: dict, name: str, width: int, faces: np.ndarray) -> np.ndarray | None:
    """(corner_count, width) float32 of an attribute; None if the primitive lacks it, or has it for other vertices."""
    index = primitive["attributes"].get(name)
    if index is None:
        return None
    values = document.accessor(index)
    if values.shape[1] != width or (faces.size and faces.max() >= len(values)):
        return None
    return values[faces.reshape(-1)].astype(np.float32)


def of_all(arrays: list[np.ndarray | None]) -> np.ndarray | None:
    """The arrays concatenated; None if any of them, or all, are missing."""
    return None if not arrays or any(array is None for array in arrays) else np.concatenate(arrays)
