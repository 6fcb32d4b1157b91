"""Holds what one computation gave: arrays by name, with their units and what limits them. Never imports bpy."""

from collections.abc import Iterator, Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..core import legend
from ..core.job import Results
from ..files.results import statistics
from .other_meshes import write_to

AnyMesh = TypeVar("AnyMesh")


class Result(Mapping[str, NDArray[np.float32]]):
    """The values at the vertices (or the faces) that were given, in their order, by the names of descriptors.

    Each is (n,) or, of a direction, (n, 3) float32; NaN where it does not exist. With several radii the names end with
    them: "mean_curvature_r0.01". str(result) shows the least, middle and largest of each.
    """

    coverage: NDArray[np.float32]  # (n,) float32 share of the neighborhood that was found; 1 where all was
    mask: NDArray[
        np.uint8
    ]  # (n,) uint8: 1 no face (of faces: no area), 2 cut by a boundary, 4 coverage below 0.9, 8 no place in the UV map
    domain: str  # "vertices", or "faces" where all arrays are of those
    units: dict[str, str]  # by name: "1/length", "length^3" or "" for none; length is that of the positions
    radii: dict[str, float]  # by name, in units of the positions
    radius: float  # the first of them
    corners: NDArray[np.int32]  # (k,) int32 vertices that are corners, the strongest first; of the descriptor harris
    warnings: list[str]  # sentences about what limits the values
    notes: list[str]  # sentences about what had no effect, or was done otherwise
    backend: str  # that computed
    device: str  # its name, for people
    report: dict[str, object]  # counts, times and settings by the names of the command line's --json

    def __init__(self, results: Results) -> None:
        """Takes the results of a job."""
        self._values = results.values
        self.coverage, self.mask, self.domain = results.coverage, results.mask, results.settings.domain
        map_name = results.settings.options.map_descriptor
        self.units = {name: legend.unit_of(name, map_name) for name in self}
        self.radii = {name: results.radius_of(name) for name in self}
        self.radius = results.radius
        found = results.corners
        self.corners = np.zeros(0, np.int32) if found is None else found.vertices.astype(np.int32)
        self.warnings = [*results.warnings, *results.facet_notes()]
        self.notes = [*results.notes, *results.unused_notes()]
        self.backend, self.device = results.backend, results.device
        self.report = self._report(results)

    def __getitem__(self, name: str) -> NDArray[np.float32]:
        if name not in self._values:
            raise KeyError(f"{name!r} was not computed; there is {', '.join(self._values)}")
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        count = len(self.coverage)
        lines = [f"{count:,} {self.domain}, radius {self.radius:.4g}, {self.backend} ({self.device})"]
        lines += [self._line(name) for name in self]
        lines += [f"warning: {sentence}" for sentence in self.warnings]
        return "\n".join(lines)

    def to(self, mesh: AnyMesh) -> AnyMesh:
        """Gives all values, and the coverage, to a mesh of trimesh, PyVista or Open3D with these vertices or faces.

        trimesh keeps them in vertex_attributes, PyVista in point_data, an Open3D tensor mesh in vertex, there (n, 1)
        and (n, 3); those of faces in face_attributes, cell_data and triangle. Returns the mesh. InputError: it has
        another number of vertices or faces, or no place for values.
        """
        write_to(mesh, {**self._values, "coverage": self.coverage}, self.domain)
        return mesh

    def _line(self, name: str) -> str:
        values = self[name]
        unit = f" {self.units[name]}" if self.units[name] else ""
        undefined = self.report["descriptors"][name]["undefined"]
        missing = f", {undefined:,} undefined" if undefined else ""
        finite = values[np.isfinite(values)] if values.ndim == 1 else values[:0, 0]
        if values.ndim == 2:
            return f"{name}: directions{missing}"
        if not finite.size:
            return f"{name}: all undefined"
        least, middle, largest = finite.min(), np.median(finite), finite.max()
        return f"{name}: {least:.4g} to {largest:.4g}, median {middle:.4g}{unit}{missing}"

    def _report(self, results: Results) -> dict[str, object]:
        shown = {}
        for name, values in self.items():
            shown[name] = {**statistics(values), "radius": self.radii[name], "unit": self.units[name]}
        return {
            "backend": self.backend,
            "device": self.device,
            "fallback": "",  # for readers of earlier versions
            "settings": results.settings.as_dict(),
            "mesh_report": results.mesh_report,
            "field_report": results.field_report,
            "field_reports": {suffix: report for suffix, report in results.field_reports.items() if suffix},
            "descriptors": shown,
            "notes": self.notes,
            "warnings": self.warnings,
        }
