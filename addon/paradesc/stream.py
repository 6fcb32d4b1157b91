"""One mesh whose positions change from frame to frame: device, adjacency and charts are kept, positions are streamed.

Whatever else depends on the positions (which vertices coincide, which triangles have no area, a private layout, normals
and tangents of the mesh's own) makes the native mesh anew, so that every frame has the bits of a bake of its own,
whichever frames came before. Never imports bpy.
"""

from dataclasses import replace
from types import TracebackType

import numpy as np

from . import bridge, job
from .bridge import MeshArrays, ParadescError, abi

# As native/src/mesh/halfedge.cpp has it: twice the area against the square of the longest edge.
NO_AREA = 1e-12
# Below this, floats of 32 bits cannot tell, and doubles are asked.
SMALL_AREA = 1e-3
# As native/src/prepare.cpp has them: buffers are laid out afresh below this share of texels and these texels a radius.
SPARSE_SHARE, SPARSE_TEXELS = 0.15, 4.0
# Everything but positions that a mesh is made of.
TOPOLOGY = ("corner_vertices", "triangle_corners", "corner_uvs", "triangle_smooth", "sharp_edges")


class Stream:
    """A native context and mesh for the positions of one object, frame after frame."""

    def __init__(self, arrays: MeshArrays, settings: job.Settings) -> None:
        job.check_descriptors(settings.descriptors)
        self.settings = settings
        self.arrays = arrays
        self.made = 0  # how often the native mesh was made: once, where nothing but positions changes
        self._mesh: bridge.Mesh | None = None
        self._contact: Contact | None = None
        self._context = job.open_context(arrays, settings)

    @property
    def backend(self) -> str:
        """The backend in use."""
        return self._context.backend

    def matches(self, arrays: MeshArrays) -> bool:
        """True where nothing but positions (and normals and tangents, which follow them) differs."""
        return (
            len(arrays.positions) == len(self.arrays.positions)
            and all(same(getattr(arrays, name), getattr(self.arrays, name)) for name in TOPOLOGY)
            and same_images(arrays.maps, self.arrays.maps)
        )

    def replace(self, arrays: MeshArrays) -> None:
        """Another mesh on the same device."""
        job.check_uvs(arrays, self.backend)
        self.forget()
        self.arrays = arrays

    def compute(
        self,
        positions: np.ndarray,
        progress: job.ProgressFunction | None = None,
        corner_normals: np.ndarray | None = None,
        corner_tangents: np.ndarray | None = None,
    ) -> job.Results:
        """The results at (vertex_count, 3) positions, to the bit those of job.run on a mesh that has them.

        The mesh's own normals (corner_count, 3) are needed with them where the settings ask for those or a normal map
        is set; the tangents (corner_count, 4) with a normal map.
        """
        arrays = self.moved(positions, corner_normals, corner_tangents)
        mesh = self.mesh_at(arrays, progress)
        try:
            results = job.run_on(self._context, mesh, arrays, self.settings, progress)
        except BaseException:
            self.forget()  # a layout may have been made whose report is lost
            raise
        if not goes_on(results):
            self.forget()
        return results

    def moved(
        self, positions: np.ndarray, corner_normals: np.ndarray | None, corner_tangents: np.ndarray | None
    ) -> MeshArrays:
        """The mesh at these positions; refuses positions of another mesh, and normals that stayed behind."""
        positions = np.ascontiguousarray(positions, np.float32)
        if positions.shape != self.arrays.positions.shape:
            wanted = len(self.arrays.positions)
            raise refused(f"Positions have the shape {positions.shape}, but the mesh has {wanted} vertices.")
        maps = self.arrays.maps
        if self.settings.options.normals == "mesh" and corner_normals is None:
            raise refused("The mesh's own normals are asked for; give those that belong to the positions.")
        if maps is not None and maps.normals is not None:
            if corner_normals is None or corner_tangents is None:
                raise refused("With a normal map, give the normals and tangents that belong to the positions.")
            maps = replace(maps, corner_tangents=corner_tangents)
        return replace(self.arrays, positions=positions, corner_normals=corner_normals, maps=maps)

    def mesh_at(self, arrays: MeshArrays, progress: job.ProgressFunction | None = None) -> bridge.Mesh:
        """The native mesh with these positions: the one there is, or a new one."""
        if self._mesh is not None and arrays.corner_normals is None and self._contact.holds(arrays.positions):
            self._mesh.set_positions(arrays.positions)
            return self._mesh
        self.forget()
        self._mesh = self._context.mesh(arrays, progress)
        self._contact = Contact(arrays)
        self.made += 1
        return self._mesh

    def forget(self) -> None:
        """Has the native mesh made anew for the next frame."""
        if self._mesh is not None:
            self._mesh.close()
            self._mesh = None

    def close(self) -> None:
        """Frees the mesh and the device."""
        self.forget()
        self._context.close()

    def __enter__(self) -> "Stream":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


class Contact:
    """Which vertices coincide and which triangles have no area: what adjacency takes from positions."""

    def __init__(self, arrays: MeshArrays) -> None:
        self.triangles = np.ascontiguousarray(arrays.triangle_vertices.T)
        _, first, group, count = np.unique(
            place_keys(arrays.positions), return_index=True, return_inverse=True, return_counts=True
        )
        self.group_count = len(first)
        shared = count[group] > 1
        self.later = np.flatnonzero(shared)  # vertices at the place of another one
        self.earlier = first[group[shared]]
        self.flat = self.without_area(arrays.positions)

    def holds(self, positions: np.ndarray) -> bool:
        """True where the same vertices coincide at these (vertex_count, 3) positions and no other triangle is flat."""
        together = np.array_equal(positions[self.later], positions[self.earlier])
        apart = distinct(place_keys(positions)) == self.group_count
        return together and apart and np.array_equal(self.flat, self.without_area(positions))

    def without_area(self, positions: np.ndarray) -> np.ndarray:
        """(k,) int64 triangles without area."""
        area, longest = area_and_edge(positions, self.triangles)
        small = np.flatnonzero(~(area > SMALL_AREA * longest))
        area, longest = area_and_edge(positions.astype(np.float64), self.triangles[:, small])
        return small[area <= NO_AREA * longest]


def area_and_edge(positions: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) twice the area and the square of the longest edge of (3, k) triangles, in the precision of the positions."""
    first = [positions[:, axis].take(triangles[0]) for axis in range(3)]
    ab = [positions[:, axis].take(triangles[1]) - first[axis] for axis in range(3)]
    ac = [positions[:, axis].take(triangles[2]) - first[axis] for axis in range(3)]
    normal = [ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3] for k in range(3)]
    squares = [sum(edge[k] * edge[k] for k in range(3)) for edge in (ab, ac, [ac[k] - ab[k] for k in range(3)])]
    longest = np.maximum(np.maximum(squares[0], squares[1]), squares[2])
    return np.sqrt(sum(part * part for part in normal)), longest


def place_keys(positions: np.ndarray) -> np.ndarray:
    """(n,) uint64 equal where positions are; elsewhere equal by chance, once in 2^64."""
    bits = (positions + np.float32(0)).view(np.uint32).astype(np.uint64)  # adding zero makes -0 and 0 one
    keys = np.zeros(len(bits), np.uint64)
    for axis in range(3):
        keys = (keys ^ bits[:, axis]) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    return keys


def distinct(keys: np.ndarray) -> int:
    """How many different keys there are."""
    ordered = np.sort(keys)
    return 1 + int(np.count_nonzero(ordered[1:] != ordered[:-1])) if len(ordered) else 0


def goes_on(results: job.Results) -> bool:
    """True where a mesh made at other positions would be the same: nothing was taken apart, nor laid out afresh.

    Where several fans of faces meet in a vertex, the widest answers for it; a private layout follows areas.
    """
    if results.mesh_report["nonmanifold_vertices"]:
        return False
    texels = SPARSE_SHARE * results.settings.options.buffer_size**2
    return results.backend == "reference" or all(
        not report["private_layout"]
        and report["covered_texels"] >= texels
        and report["radius_in_texels"] >= SPARSE_TEXELS
        for report in results.field_reports.values()
    )


def same(first: np.ndarray | None, second: np.ndarray | None) -> bool:
    """Equal arrays, or none twice."""
    return first is second or (first is not None and second is not None and np.array_equal(first, second))


def same_images(first: bridge.SurfaceMaps | None, second: bridge.SurfaceMaps | None) -> bool:
    """The same displacement and normal map, or none twice."""
    if first is None or second is None:
        return first is second
    return (
        same(first.heights, second.heights)
        and same(first.normals, second.normals)
        and (first.midlevel, first.scale) == (second.midlevel, second.scale)
    )


def refused(sentence: str) -> ParadescError:
    """The error for what a stream cannot take."""
    return ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
