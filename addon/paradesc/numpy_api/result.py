"""Holds what one computation gave: arrays by name, with their units and what limits them. Never imports bpy."""

import enum
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..bridge import abi

if TYPE_CHECKING:
    from ..core.job import Results

AnyMesh = TypeVar("AnyMesh")
# Sentences about faults end with the remedy in Blender. These are the remedies in Python, by words of the sentences.
IN_PYTHON = {
    "wound against each other": "trimesh.repair.fix_winding",
    "wound inwards": "faces[:, ::-1] of an array, or trimesh.repair.fix_inversion",
    "By Distance": "trimesh's merge_vertices with fewer digits",
}


def for_python(sentence: str) -> str:
    """The sentence with what mends the mesh in Python in place of the menu at its end."""
    call = next((call for words, call in IN_PYTHON.items() if words in sentence), "")
    return f"{sentence.rpartition(' (')[0]} ({call})." if call else sentence


class ParadescWarning(UserWarning):
    """A warning that says in one sentence what limits the values of a computation.

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> import warnings
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", paradesc.ParadescWarning)  # on purpose
    ...     result = paradesc.compute(vertices, faces, radius=0.05, radius_unit="absolute")
    >>> print(result.warnings[0])
    The radius is only 0.44 of the mean edge, so values show single faces; choose a larger one.
    """


class Mask(enum.IntFlag):
    """The bits of Result.mask. They say for each vertex or face what limits its values.

    Attributes
    ----------
    NO_FACE
        The vertex has no face, or the face has no area; values are NaN.
    BOUNDARY
        A boundary of the mesh cuts the neighborhood; values are those of the part that exists.
    LOW_COVERAGE
        The coverage is below 0.9: a graphics card has not found the whole neighborhood in the UV map.
    NO_UV
        The vertex has no place in the UV map, which graphics cards need; values are NaN.

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 2, 0]])
    >>> result = paradesc.compute(points, [[0, 1, 2, 3]], radius=1.2, radius_unit="absolute")
    >>> (result.mask & paradesc.Mask.BOUNDARY != 0).tolist()
    [True, True, True, True, False]
    >>> paradesc.Mask.NO_FACE in paradesc.Mask(int(result.mask[4]))
    True
    """

    NO_FACE = abi.MASK_NO_FACE
    BOUNDARY = abi.MASK_BOUNDARY
    LOW_COVERAGE = abi.MASK_LOW_COVERAGE
    NO_UV = abi.MASK_NO_TEXEL


class Result(Mapping[str, NDArray[np.float32]]):
    """A mapping from names of descriptors to their values, in the order of the vertices or faces that were given.

    Values are (n,) float32, and (n, 3) for directions; they are NaN where a descriptor does not exist. With several
    radii the names end with the radius, as in "mean_curvature_r0.01", and result["mean_curvature", 0.01] takes the
    radius as it was given. print(result) shows the minimum, maximum and median of each.

    Attributes
    ----------
    coverage : (n,) float32
        The share of the neighborhood that was found, between 0 and 1; NaN at vertices without a face, at faces
        without an area, and wherever else there is no surface that could be measured.
    mask : (n,) uint8
        Combinations of the bits that Mask names.
    domain : str
        "vertices" or "faces": the places that all arrays belong to.
    units : dict
        The unit of each array, by name: "1/length", "length^3", or "" for none. The length is that of the positions.
    radii : dict
        The radius of each array, by name, in the unit of the positions.
    radius : float
        The first of the radii.
    corners : (k,) int32
        The vertices that the descriptor harris finds to be corners, the strongest first.
    warnings, notes : list of str
        Sentences about what limits the values, and about settings that had no effect.
    backend, device : str
        The backend that computed, and the name of its device.
    report : dict
        Counts, times and settings, by the same names as in --json of the command line.

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> result = paradesc.compute(vertices, faces, "curvedness", radius=(0.2, 0.3), radius_unit="absolute")
    >>> list(result)
    ['curvedness_r0.2', 'curvedness_r0.3']
    >>> bool((result["curvedness", 0.2] == result["curvedness_r0.2"]).all())
    True
    >>> result.units["curvedness_r0.2"]
    '1/length'
    >>> result.over_radii("curvedness").shape
    (2, 441)
    """

    def __init__(self, results: "Results") -> None:
        """Takes the results of a job."""
        from . import work

        self._values, settings = results.values, results.settings
        radii = (settings.options.radius, *settings.more_radii)
        pairs = [(name, radius) for radius in radii for name in settings.descriptors]
        self._names = dict(zip(pairs, settings.value_names(), strict=True))
        self.coverage: NDArray[np.float32] = results.coverage
        self.mask: NDArray[np.uint8] = results.mask
        self.domain = settings.domain
        map_name = settings.options.map_descriptor
        self.units = {name: work.legend.unit_of(name, map_name) for name in self}
        self.radii = {name: results.radius_of(name) for name in self}
        self.radius, self._diagonal = results.radius, float(results.mesh_report["diagonal"])
        found = results.corners
        self.corners = np.zeros(0, np.int32) if found is None else found.vertices.astype(np.int32)
        self.warnings = [*map(for_python, results.warnings), *results.facet_notes()]
        self.notes = [*results.notes, *results.unused_notes()]
        self.backend, self.device = results.backend, results.device
        self.report = self._report(results)

    def __getitem__(self, name: str | tuple[str, float]) -> NDArray[np.float32]:
        own = self._names.get(name, name)
        if own not in self._values:
            radii = [radius for known, radius in self._names if known == name]
            wanted = f"; give a radius too, result[{name!r}, {radii[0]:g}]" if radii else ""
            raise KeyError(f"{name!r} was not computed{wanted}; there is {', '.join(self._values)}")
        return self._values[own]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        count = len(self.coverage)
        share = 100 * self.radius / max(self._diagonal, np.finfo(float).tiny)
        radius = f"radius {self.radius:.4g} = {share:.3g} % of the diagonal {self._diagonal:.4g}"
        lines = [f"{count:,} {self.domain}, {radius}, {self.backend} ({self.device})"]
        lines += [self._line(name) for name in self]
        lines += [f"warning: {sentence}" for sentence in self.warnings]
        return "\n".join(lines)

    def over_radii(self, descriptor: str) -> NDArray[np.float32]:
        """Stacks the values of one descriptor at all radii.

        Parameters
        ----------
        descriptor : str
            The name without a radius.

        Returns
        -------
        (k, n) or (k, n, 3) float32
            One row for each radius, in the order in which the radii were given.

        Raises
        ------
        KeyError
            The descriptor was not computed.
        """
        pairs = [(name, radius) for name, radius in self._names if name == descriptor]
        return np.stack([self[pair] for pair in pairs or [descriptor]])

    def to(self, mesh: AnyMesh) -> AnyMesh:
        """Gives all values, and the coverage, to a mesh of another package.

        Parameters
        ----------
        mesh
            A mesh of trimesh, PyVista or Open3D that has these vertices or faces. Values at vertices go to
            vertex_attributes of trimesh, point_data of PyVista, and vertex of an Open3D tensor mesh, as (n, 1) and
            (n, 3). Values at faces go to face_attributes, cell_data and triangle; lines and vertex cells of PyVista
            have NaN.

        Returns
        -------
        mesh
            The same mesh.

        Raises
        ------
        InputError
            The mesh has another number of vertices or faces, or no place for values (faces in a triangle strip, too).
        """
        from . import work

        work.other_meshes.write_to(mesh, {**self._values, "coverage": self.coverage}, self.domain)
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

    def _report(self, results: "Results") -> dict[str, object]:
        from . import work

        shown = {}
        for name, values in self.items():
            shown[name] = {**work.statistics(values), "radius": self.radii[name], "unit": self.units[name]}
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
