"""Reads mesh files without Blender: .obj and .ply by our own readers, .stl, .off, .glb and .gltf by trimesh.

A file's own vertices are kept in their order, whether a face uses them or not; only the loose triangles of .stl, which
have no vertices in common, are welded.
"""

import importlib
import io
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import numpy as np

from ..bridge import InputError, MeshArrays, ParadescError, abi
from ..core.polygons import PolygonMesh
from ..core.stream import columns_of, place_keys
from . import obj_file, ply_file

SUFFIXES = (".obj", ".ply", ".stl", ".off", ".glb", ".gltf")
# These change nothing that is measured, so that a glTF file that requires them can be read without them.
HARMLESS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp")
COPIES = {"TEXCOORD_0": "_PARADESC_UV", "NORMAL": "_PARADESC_NORMAL"}


@dataclass(eq=False)
class FileMesh:
    """A mesh of a file, as triangles."""

    name: str
    arrays: MeshArrays
    matrix_world: np.ndarray  # (4, 4) float64
    corner_normals: np.ndarray | None = None  # (corner_count, 3) float32, the file's own; not in the arrays
    face_count: int = 0  # with polygons
    notes: list[str] = field(default_factory=list)  # what was done to it


def read(path: Path) -> list[FileMesh]:
    """The meshes of a file that have faces, each with a name of its own; raises InputError with one sentence."""
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f'"{path}" is none of {", ".join(SUFFIXES)}.')
    if not path.is_file():
        raise InputError(f'There is no file "{path}".')
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused by the library, by vertex
            found = [mesh for mesh in reader(path) if len(mesh.arrays.triangle_corners)]
    except ParadescError:
        raise
    except Exception as error:
        said = " ".join(str(error).split()).rstrip(".")[:300] or type(error).__name__
        raise InputError(f'"{path}" cannot be read: {said}.') from error
    if not found:
        raise InputError(f'"{path}" has no faces; there is no surface to measure.')
    return with_own_names(found)


def with_own_names(meshes: list[FileMesh]) -> list[FileMesh]:
    """Adds a number to names that are taken."""
    taken: set[str] = set()
    for mesh in meshes:
        stem, number = mesh.name, 0
        while mesh.name in taken:
            number += 1
            mesh.name = f"{stem}.{number:03}"
        taken.add(mesh.name)
    return meshes


def of_polygons(name: str, mesh: PolygonMesh) -> FileMesh:
    """A file's polygons as triangles, where the file has them."""
    return FileMesh(name, mesh.arrays(), np.eye(4), mesh.corner_normals, len(mesh.sizes))


def of_triangles(name: str, vertices: np.ndarray, faces: np.ndarray, matrix: np.ndarray | None = None) -> FileMesh:
    """Vertices (n, 3) and triangles (m, 3) as a mesh."""
    faces = np.asarray(faces, np.int64).reshape(-1, 3)
    if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise ValueError(f"a face has a vertex beyond the {len(vertices)} that there are")
    corners = np.arange(3 * len(faces), dtype=np.int32).reshape(-1, 3)
    arrays = MeshArrays(np.asarray(vertices, np.float32), faces.reshape(-1).astype(np.int32), corners)
    return FileMesh(name, arrays, np.eye(4) if matrix is None else matrix, face_count=len(faces))


def read_obj(path: Path) -> list[FileMesh]:
    """The objects of a Wavefront file."""
    return [of_polygons(name or path.stem, mesh) for name, mesh in obj_file.read(path)]


def read_ply(path: Path) -> list[FileMesh]:
    """The mesh of a .ply."""
    mesh = ply_file.read(path)
    return [] if mesh is None else [of_polygons(path.stem, mesh)]


# ---- By trimesh


def trimesh_module() -> ModuleType:
    """The library that reads the other formats, or one sentence about how to get it."""
    try:
        return importlib.import_module("trimesh")
    except ImportError as error:
        sentence = "Files of this kind are read by trimesh, which is not installed here; pip install paradesc[io]."
        raise ParadescError(abi.STATUS_UNSUPPORTED, sentence) from error


def geometries(path: Path, content: io.BytesIO | None = None) -> object:
    """The scene that trimesh makes of a file, or of its content, with vertices and faces as they are there."""
    trimesh = trimesh_module()
    kind = path.suffix[1:].lower()
    if content is None:
        return trimesh.load_scene(str(path), file_type=kind, process=False)
    beside = trimesh.resolvers.FilePathResolver(str(path))
    return trimesh.load_scene(content, file_type=kind, resolver=beside, process=False)


def read_off(path: Path) -> list[FileMesh]:
    """The mesh of a .off."""
    found = [mesh for mesh in geometries(path).geometry.values() if hasattr(mesh, "faces")]
    return [of_triangles(path.stem, mesh.vertices, mesh.faces) for mesh in found]


def read_stl(path: Path) -> list[FileMesh]:
    """The surface of all triangles of a .stl, welded where they have a position in common."""
    found = [mesh for mesh in geometries(path).geometry.values() if hasattr(mesh, "faces")]
    if not found:
        return []
    corners = np.concatenate([mesh.vertices[mesh.faces].reshape(-1, 3) for mesh in found]).astype(np.float32)
    first, welded = places_of(corners)
    mesh = of_triangles(path.stem, corners[first], welded)
    mesh.notes.append(
        f"An STL file holds loose triangles: the {len(corners):,} corners of {len(corners) // 3:,} were welded into "
        f"{len(first):,} vertices, where they are equal."
    )
    return [mesh]


def places_of(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first vertex of each place, in order, and each vertex's place, (n,), of positions (n, 3) float32."""
    _, first, group = np.unique(place_keys(columns_of(positions)), return_index=True, return_inverse=True)
    if not np.array_equal(positions[first][group], positions):  # two places have one key, or are not finite
        _, first, group = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(first), np.int64)
    rank[order] = np.arange(len(first))
    return first[order], rank[group.reshape(-1)]


# ---- glTF


def read_gltf(path: Path) -> list[FileMesh]:
    """One mesh for each node of a .glb or .gltf that has one; parts with materials of their own are joined."""
    content = path.read_bytes()
    header, rest = (json.loads(content), b"") if path.suffix.lower() == ".gltf" else opened_glb(content)
    check_gltf(header)
    names = simplify(header)
    text = json.dumps(header).encode()
    scene = geometries(path, io.BytesIO(text if path.suffix.lower() == ".gltf" else closed_glb(text, rest)))
    parts: dict[str, list[FileMesh]] = {}
    for frame in scene.graph.nodes_geometry:
        node = frame if frame in names else scene.graph.transforms.parents[frame]
        matrix, geometry = scene.graph[frame]
        mesh = scene.geometry[geometry]
        if hasattr(mesh, "faces"):
            parts.setdefault(node, []).append(with_corners(names[node], mesh, matrix))
    return [joined(parts[node]) for node in names if node in parts]


def opened_glb(content: bytes) -> tuple[dict, bytes]:
    """The header of a .glb, and the chunks that follow it."""
    magic, _, _, length, kind = struct.unpack_from("<4sIII4s", content)
    if magic != b"glTF" or kind != b"JSON" or 20 + length > len(content):
        raise ValueError("it does not begin as one")
    return json.loads(content[20 : 20 + length]), content[20 + length :]


def closed_glb(header: bytes, rest: bytes) -> bytes:
    """A .glb with this header and these chunks."""
    header += b" " * (-len(header) % 4)
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(header) + len(rest), len(header), b"JSON") + header + rest


def check_gltf(header: dict) -> None:
    """Refuses what would be read wrong without anybody noticing."""
    unknown = [name for name in header.get("extensionsRequired", []) if not name.startswith(HARMLESS)]
    if unknown:
        raise ValueError(f"it needs the extensions {', '.join(map(str, unknown))}; save it without compression")
    if any("sparse" in accessor for accessor in header.get("accessors", [])):
        raise ValueError("it has sparse accessors; save it without")


def simplify(header: dict) -> dict[str, str]:
    """Leaves out what is not measured, and gives nodes names of their own; gives their names in the file by these.

    Texture coordinates and normals become attributes of our own too, which trimesh keeps as they are; it has texture
    coordinates only where there is a material.
    """
    for name in ("materials", "textures", "images", "samplers", "cameras"):
        header.pop(name, None)
    for part in (part for mesh in header.get("meshes", []) for part in mesh["primitives"]):
        part.pop("material", None)
        attributes = part["attributes"]
        attributes.update({copy: attributes[name] for name, copy in COPIES.items() if name in attributes})
    names = {}
    for index, node in enumerate(header.get("nodes", [])):
        node.pop("camera", None)
        mesh = header["meshes"][node["mesh"]] if "mesh" in node else {}
        names[f"node {index}"] = str(node.get("name") or mesh.get("name") or f"node {index}")
        node["name"] = f"node {index}"
    return names


def with_corners(name: str, mesh: object, matrix: np.ndarray) -> FileMesh:
    """A mesh of trimesh with its texture coordinates, whose origin is the upper left corner, and normals."""
    found = of_triangles(name, mesh.vertices, mesh.faces, np.array(matrix, np.float64))
    corners = found.arrays.corner_vertices
    uvs = mesh.vertex_attributes.get(COPIES["TEXCOORD_0"])
    if uvs is not None:
        if uvs.dtype.kind != "f":
            uvs = uvs / np.float32(np.iinfo(uvs.dtype).max)
        found.arrays.corner_uvs = (uvs.astype(np.float32) * (1, -1) + (0, 1)).astype(np.float32)[corners]
    normals = mesh.vertex_attributes.get(COPIES["NORMAL"])
    if normals is not None:
        found.corner_normals = np.asarray(normals, np.float32)[corners]
    return found


def joined(parts: list[FileMesh]) -> FileMesh:
    """The parts of one node as one mesh; it has texture coordinates and normals if all parts have."""
    if len(parts) == 1:
        return parts[0]
    counts = [len(part.arrays.positions) for part in parts]
    vertices = np.concatenate([part.arrays.positions for part in parts])
    corners = [part.arrays.corner_vertices + sum(counts[:k]) for k, part in enumerate(parts)]
    whole = of_triangles(parts[0].name, vertices, np.concatenate(corners), parts[0].matrix_world)
    whole.arrays.corner_uvs = of_all([part.arrays.corner_uvs for part in parts])
    whole.corner_normals = of_all([part.corner_normals for part in parts])
    return whole


def of_all(arrays: list[np.ndarray | None]) -> np.ndarray | None:
    """All of these, one after the other, if none is missing."""
    return None if any(array is None for array in arrays) else np.concatenate(arrays)


READERS = {
    ".obj": read_obj, ".ply": read_ply, ".stl": read_stl, ".off": read_off, ".glb": read_gltf, ".gltf": read_gltf,
}  # fmt: skip
