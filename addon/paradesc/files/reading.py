"""Holds what is to be read of one mesh, and what was read; reads the meshes of files. Never imports bpy."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..bridge import InputError, MeshArrays, SurfaceMaps
from ..core import job, source_kinds, spaces, tangents, transfer, uv_faults
from ..core.polygons import PolygonMesh
from . import map_images
from .map_images import MapChoice


@dataclass
class ReadRequest:
    """The options for reading one mesh, apart from those of the computation. Plain values, which survive an undo."""

    shape_key: str = "basis"  # or "active"
    maps: MapChoice = field(default_factory=MapChoice)
    source: str = source_kinds.ORIGINAL  # or another of NAMES, or AUTOMATIC
    buffers: bool = False  # whether the baked buffers will be written
    images: bool = False  # whether images over the mesh's own UV map will be written
    placing: bool = True  # whether results will be written to the object's vertices
    remedy: str = "measure in World"  # the remedy that a sentence suggests if the scale is ignored


@dataclass
class Read:
    """One mesh that was read: of an object in Blender, where its results belong to a scene, or of a file."""

    arrays: MeshArrays  # in object space, as files hold it
    source: str = source_kinds.ORIGINAL
    vertices: np.ndarray | None = None  # (original_count,) int64 of the arrays' vertices, if these are not the same
    own: bool = True  # every original vertex is among the arrays'
    earlier: dict[str, np.ndarray] = field(default_factory=dict)  # values of earlier bakes that are carried
    measured: MeshArrays | None = None  # the arrays in the space that is measured
    source_notes: list[str] = field(default_factory=list)  # those notes that are about the source
    notes: list[str] = field(default_factory=list)  # sentences about what was measured
    warnings: list[str] = field(default_factory=list)  # about differences between the measured and the visible surface
    map_notes: list[str] = field(default_factory=list)  # about the images

    @property
    def sentences(self) -> list[str]:
        """All notes and warnings."""
        return [*self.notes, *self.warnings, *self.map_notes]


def on_original(results: job.Results, at: np.ndarray | None) -> job.Results:
    """The results at the object's own vertices: (original_count,) int64, or None if they are there already."""
    if at is None:
        return results
    corners = results.corners
    if corners is not None:
        painted = corners.painted[at]
        place = {int(vertex): index for index, vertex in reversed(list(enumerate(at)))}
        kept = [vertex for vertex in corners.vertices.tolist() if vertex in place]
        own = np.array([place[vertex] for vertex in kept], corners.vertices.dtype)
        corners = replace(corners, vertices=own, painted=painted)
    return replace(
        results,
        values={name: values[at] for name, values in results.values.items()},
        coverage=results.coverage[at],
        areas_of=None if results.areas_of is None else lambda: results.areas_of()[at],
        mask=results.mask[at],
        near_seam=None if results.near_seam is None else results.near_seam[at],
        unwrapped=None,  # a layout of the evaluated mesh, which cannot be stored
        corners=corners,
    )


def part_of(target: Any, read: Read) -> transfer.Part:
    """An object, or a mesh of a file, as transfer takes it: as it was read, with its place in the world."""
    return transfer.Part(target.name, read.arrays, read.measured, world_matrix(target))


def world_matrix(target: Any) -> np.ndarray:
    """(4, 4) float64 matrix from object space to world space."""
    return np.array(target.matrix_world, np.float64)


def read_mesh(mesh: PolygonMesh, settings: job.Settings, request: ReadRequest) -> Read:
    """Reads a mesh of a file as it is measured: with a usable UV map or none, in the space that is asked for."""
    arrays = replace(mesh.arrays)
    reason = arrays.uv_fault = uv_faults.fault(arrays.corner_uvs, arrays.triangle_corners)
    if reason:
        if request.images or request.buffers or job.needs_uvs(settings):
            raise InputError(
                f'The mesh "{mesh.name}" {reason}, and without Blender it cannot be unwrapped; give it one, or '
                "pip install bpy, or compute at vertices (--backend cpu, no image)."
            )
        arrays.corner_uvs = None
    map_notes = add_maps(mesh, arrays, request.maps)
    if settings.options.normals == "mesh":
        if mesh.corner_normals is None:
            raise InputError(f'The file has no normals for "{mesh.name}"; choose fitted ones.')
        arrays.corner_normals = spaces.unit(mesh.corner_normals)
    measured, warnings = spaces.measured(arrays, mesh.matrix_world, mesh.name, settings.space, request.remedy)
    if reason and mesh.arrays.corner_uvs is not None:
        warnings.append(f'The mesh "{mesh.name}" {reason}, which was left out.')
    return Read(arrays, measured=measured, notes=list(mesh.notes), warnings=warnings, map_notes=map_notes)


def add_maps(mesh: PolygonMesh, arrays: MeshArrays, choice: MapChoice) -> list[str]:
    """Adds the maps, and the mesh data that they need, to the arrays; returns a note about each map."""
    if not choice.any:
        return []
    if arrays.uv_fault:
        raise InputError(f'The mesh "{mesh.name}" {arrays.uv_fault} for displacement and normal maps; unwrap it.')
    if choice.normal_map is not None and mesh.corner_normals is None:
        sentence = f'The file has no normals for "{mesh.name}", in whose tangent space a normal map lies'
        raise InputError(f"{sentence}; export them with it.")
    maps = arrays.maps = SurfaceMaps()
    notes = map_images.of_files(choice, maps, map_images.read_image)
    if maps.normals is not None:
        arrays.corner_normals = spaces.unit(mesh.corner_normals)
        maps.corner_tangents = tangents.corner_tangents(arrays)
    return notes
