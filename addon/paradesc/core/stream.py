"""Computes one mesh whose positions change from frame to frame: keeps device, adjacency and charts, streams positions.

If anything else that depends on the positions changes (which vertices coincide, which triangles have no area, a
private layout, the mesh's own normals and tangents), the native mesh is made anew. So every frame has the bits of a
bake of its own, whatever frames came before. Never imports bpy.
"""

from dataclasses import replace

import numpy as np

from .. import bridge
from ..bridge import MeshArrays, abi, origin
from ..bridge.library import new_struct
from ..bridge.session import as_dict
from . import job
from .corners import Corners

# The bound of native/src/mesh/halfedge.cpp: twice the area against the square of the longest edge.
NO_AREA = 1e-12
# Below this, 32-bit floats are too inexact to decide, so doubles are used.
SMALL_AREA = 1e-3
# So many triangles are looked at together that their numbers stay in the processor's cache.
BLOCK = 16384
# The bounds of native/src/mesh/atlas.cpp: charts are laid out afresh if they cover a smaller share of texels, or if the
# radius spans fewer texels.
SPARSE_SHARE, SPARSE_TEXELS = 0.15, 4.0
# All members of a mesh except its positions.
TOPOLOGY = ("corner_vertices", "triangle_corners", "corner_uvs", "triangle_smooth", "sharp_edges")


class Stream(bridge.Closing):
    """A native mesh for the positions of one object, frame after frame; shared: uses the device that others share."""

    def __init__(self, arrays: MeshArrays, settings: job.Settings, shared: bool = False) -> None:
        job.check_descriptors(settings.descriptors)
        self.settings = settings
        self.arrays = arrays
        self.made = 0  # how often the native mesh was made: once, as long as only positions change
        self._mesh: bridge.Mesh | None = None
        self._contact: Contact | None = None
        self._lease = job.open_context(arrays, settings, shared)
        self._context = self._lease.context

    @property
    def backend(self) -> str:
        """The backend that computes with the settings."""
        if self._mesh is not None:
            return self._mesh.backend(self.settings.options)
        return job.backend_for(self.settings)

    def matches(self, arrays: MeshArrays) -> bool:
        """Returns whether only positions differ (and normals and tangents, which follow them)."""
        return same_topology(arrays, self.arrays) and same_images(arrays.maps, self.arrays.maps)

    def replace(self, arrays: MeshArrays) -> None:
        """Takes another mesh on the same device."""
        job.check_uvs(arrays, self._context.backend)
        self.forget()
        self.arrays = arrays

    def compute(
        self,
        positions: np.ndarray,
        progress: bridge.ProgressFunction | None = None,
        corner_normals: np.ndarray | None = None,
        corner_tangents: np.ndarray | None = None,
    ) -> job.Results:
        """Computes at (vertex_count, 3) positions; the results have the bits of job.run on a mesh that has them.

        The mesh's own normals (corner_count, 3) are needed with them where the settings ask for those or a normal map
        is set; the tangents (corner_count, 4) with a normal map. At positions that lie closer together than a fixed
        radius, no value is defined.
        """
        arrays = self.moved(positions, corner_normals, corner_tangents)
        mesh = self.mesh_at(arrays, progress)
        try:
            options, more = self.settings.options, self.settings.more_radii
            if options.radius_unit == "absolute" and max((options.radius, *more)) > mesh.report()["diagonal"]:
                return undefined(mesh, self.settings, self._context.device)
            results = job.run_on(mesh, arrays, self.settings, progress)
        except BaseException as error:
            self.forget()  # a layout may have been made whose report is lost
            self._lease.failed(error)
            raise
        if not goes_on(results) or self._contact.is_of_rounding(results.mesh_report):
            self.forget()
        return results

    def moved(
        self, positions: np.ndarray, corner_normals: np.ndarray | None, corner_tangents: np.ndarray | None
    ) -> MeshArrays:
        """The mesh at these positions; raises if they are of another mesh, or if normals are missing."""
        positions = np.asarray(positions)
        if positions.shape != self.arrays.positions.shape:
            wanted = len(self.arrays.positions)
            raise bridge.unusable(f"Positions have the shape {positions.shape}, but the mesh has {wanted} vertices.")
        positions = origin.near_origin(positions)
        maps = self.arrays.maps
        if self.settings.options.normals == "mesh" and corner_normals is None:
            raise bridge.unusable("The mesh's own normals are asked for; give those that belong to the positions.")
        if maps is not None and maps.normals is not None:
            if corner_normals is None or corner_tangents is None:
                raise bridge.unusable("With a normal map, give the normals and tangents that belong to the positions.")
            maps = replace(maps, corner_tangents=corner_tangents)
        return replace(self.arrays, positions=positions, corner_normals=corner_normals, maps=maps)

    def mesh_at(self, arrays: MeshArrays, progress: bridge.ProgressFunction | None = None) -> bridge.Mesh:
        """The native mesh at these positions: the existing one with new positions if possible, else a new one."""
        if self._mesh is not None and arrays.corner_normals is None and self._contact.holds(arrays.positions):
            self._mesh.set_positions(arrays.positions)
            return self._mesh
        self.forget()
        contact = Contact(arrays)  # before the mesh: Ctrl-C may come between them
        self._mesh, self._contact = self._context.mesh(arrays, progress), contact
        self.made += 1
        return self._mesh

    def forget(self) -> None:
        """Drops the native mesh, so that the next frame makes a new one."""
        if self._mesh is not None:
            self._mesh.close()
            self._mesh = None

    def close(self) -> None:
        """Frees the mesh and returns the device."""
        self.forget()
        self._lease.close()

    def leave(self) -> None:
        """Drops the mesh and the device without taking a lock, as the garbage collector may call this at any time."""
        self.forget()
        self._lease.leave()


class Contact:
    """The facts that adjacency takes from positions: which vertices coincide, and which triangles have no area."""

    def __init__(self, arrays: MeshArrays) -> None:
        triangles = arrays.triangle_vertices.T.astype(np.intp)
        starts = range(0, triangles.shape[1], BLOCK)
        self.blocks = [np.ascontiguousarray(triangles[:, start : start + BLOCK]) for start in starts]
        columns = origin.columns_of(arrays.positions)
        _, first, group, count = np.unique(
            origin.place_keys(columns), return_index=True, return_inverse=True, return_counts=True
        )
        self.vertex_count, self.group_count = len(arrays.positions), len(first)
        shared = count[group] > 1
        self.later = np.flatnonzero(shared)  # vertices at the place of another one
        self.earlier = first[group[shared]]
        self.flat = self.without_area(columns)

    def holds(self, positions: np.ndarray) -> bool:
        """Tells whether the same vertices coincide at (vertex_count, 3) positions, and no other triangle is flat."""
        columns = origin.columns_of(positions)
        together = np.array_equal(columns[:, self.later], columns[:, self.earlier])
        apart = distinct(origin.place_keys(columns)) == self.group_count
        return together and apart and np.array_equal(self.flat, self.without_area(columns))

    def is_of_rounding(self, mesh_report: dict[str, float | int]) -> bool:
        """Returns whether welded vertices do not coincide exactly; at other positions, others might be welded."""
        return mesh_report["welded_vertices"] > self.vertex_count - self.group_count

    def without_area(self, columns: np.ndarray) -> np.ndarray:
        """(k,) int64 triangles that have no area at (3, vertex_count) positions."""
        found = [np.empty(0, np.int64)]
        for index, triangles in enumerate(self.blocks):
            square, longest = area_and_edge(columns, triangles)
            small = np.flatnonzero(~(square > (SMALL_AREA * longest) ** 2))
            if small.size:
                square, longest = area_and_edge(columns.astype(np.float64), triangles[:, small])
                found.append(index * BLOCK + small[np.sqrt(square) <= NO_AREA * longest])
        return np.concatenate(found)


def area_and_edge(columns: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) squares of twice the area and of the longest edge of (3, k) triangles, precise as the (3, n) positions."""
    corners = [[column.take(vertices) for vertices in triangles] for column in columns]
    ab = [second - first for first, second, _ in corners]
    ac = [third - first for first, _, third in corners]
    bc = [along - other for along, other in zip(ac, ab, strict=True)]
    normal = [ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3] for k in range(3)]
    return square_of(normal), np.maximum(np.maximum(square_of(ab), square_of(ac)), square_of(bc))


def square_of(vectors: list[np.ndarray]) -> np.ndarray:
    """(k,) squares of the lengths of vectors whose three coordinates are (k,) each."""
    return vectors[0] * vectors[0] + vectors[1] * vectors[1] + vectors[2] * vectors[2]


def distinct(keys: np.ndarray) -> int:
    """The number of different keys."""
    ordered = np.sort(keys)
    return 1 + int(np.count_nonzero(ordered[1:] != ordered[:-1])) if len(ordered) else 0


def undefined(mesh: bridge.Mesh, settings: job.Settings, device: str) -> job.Results:
    """The results on a mesh that is smaller than the largest radius, a length: no value is defined."""
    count, nothing = mesh.vertex_count, as_dict(new_struct(abi.FieldReport))
    values = {}
    for name in settings.value_names():
        width = job.registry_row(name).components
        values[name] = np.full(count if width == 1 else (count, width), np.nan, np.float32)
    radii = (settings.options.radius, *settings.more_radii)
    reports = {
        job.radius_suffix(radius) if len(radii) > 1 else "": {**nothing, "radius": radius, "undefined_vertices": count}
        for radius in radii
    }
    coverage, mask = np.full(count, np.nan, np.float32), np.full(count, abi.MASK_NO_FACE, np.uint8)
    made = mesh.report(), next(iter(reports.values())), mesh.backend(settings.options), device
    results = job.Results(settings, values, coverage, mask, *made, warnings=[], field_reports=reports)
    if results.harris is not None:
        results.corners = Corners(np.empty(0, np.int32), np.zeros(count, np.float32))
    return results


def is_too_small(results: job.Results) -> bool:
    """Returns whether the mesh is smaller than a radius, so that these are undefined() results."""
    return max(report["radius"] for report in results.field_reports.values()) > results.mesh_report["diagonal"]


def goes_on(results: job.Results) -> bool:
    """Returns whether a mesh made at other positions would be the same: nothing was taken apart or laid out afresh.

    If several fans of faces meet in a vertex, the widest represents it, and a private layout depends on areas. Both
    may change with the positions.
    """
    if results.mesh_report["nonmanifold_vertices"]:
        return False
    if any(report["private_layout"] for report in results.field_reports.values()):
        return False
    texels = SPARSE_SHARE * results.settings.options.buffer_size**2
    return not bridge.uses_texture_space(results.backend) or all(
        report["covered_texels"] >= texels and report["radius_in_texels"] >= SPARSE_TEXELS
        for report in results.field_reports.values()
    )


def same(first: np.ndarray | None, second: np.ndarray | None) -> bool:
    """Returns whether two arrays are equal, or both None."""
    return first is second or (first is not None and second is not None and np.array_equal(first, second))


def same_topology(first: MeshArrays, second: MeshArrays) -> bool:
    """Returns whether two meshes have the same faces on as many vertices."""
    return len(first.positions) == len(second.positions) and all(
        same(getattr(first, name), getattr(second, name)) for name in TOPOLOGY
    )


def same_images(first: bridge.SurfaceMaps | None, second: bridge.SurfaceMaps | None) -> bool:
    """Returns whether displacement and normal map are equal, or both None."""
    if first is None or second is None:
        return first is second
    return (
        same(first.heights, second.heights)
        and same(first.normals, second.normals)
        and (first.midlevel, first.scale) == (second.midlevel, second.scale)
    )
