"""Holds what one computation gave: arrays by name, with their units and what limits them. Never imports bpy."""

import enum
from collections.abc import Iterator, Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..bridge import abi
from ..core import legend
from ..core.job import Results
from ..core.statistics import statistics
from .other_meshes import write_to

AnyMesh = TypeVar("AnyMesh")
# What mends a mesh in Python, where nobody has Blender's menus, by words of the sentences, which end with a menu.
IN_PYTHON = {
    "wound against each other": "trimesh.repair.fix_winding",
    "wound inwards": "trimesh.repair.fix_inversion",
    "By Distance": "trimesh's merge_vertices with fewer digits",
}


def for_python(sentence: str) -> str:
    """The sentence with what does the same in Python as the menu at its end."""
    call = next((call for words, call in IN_PYTHON.items() if words in sentence), "")
    return f"{sentence.removesuffix(').')}, or {call})." if call else sentence


class ParadescWarning(UserWarning):
    """Says in one sentence what limits the values of a computation.

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> import warnings
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", paradesc.ParadescWarning)  # it is wanted so
    ...     result = paradesc.compute(vertices, faces, radius=0.05, radius_unit="absolute")
    >>> print(result.warnings[0])
    The radius is 0.44 of the mean edge: values show facets, not the surface; choose a larger one.
    """


class Mask(enum.IntFlag):
    """The bits of Result.mask, which say at each vertex or face what limits its values.

    Attributes
    ----------
    NO_FACE
        The vertex has no face, or the face no area; values are NaN.
    BOUNDARY
        A boundary of the mesh cuts the neighborhood; values are those of what is there.
    LOW_COVERAGE
        The coverage is below 0.9: a graphics card has not found all of the neighborhood in the UV map.
    NO_UV
        There is no place in the UV map, which graphics cards need; values are NaN.

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
    """The values at the vertices (or the faces) that were given, in their order, by the names of descriptors.

    Each is (n,) or, of a direction, (n, 3) float32; NaN where it does not exist. With several radii the names end with
    them, "mean_curvature_r0.01", and result["mean_curvature", 0.01] takes a radius as it was given. str(result) shows
    the least, middle and largest of each.

    Attributes
    ----------
    coverage : (n,) float32
        The share of the neighborhood that was found; 1 where all was.
    mask : (n,) uint8
        Sums of the bits that Mask names.
    domain : str
        "vertices", or "faces" where all arrays are of those.
    units : dict
        By name: "1/length", "length^3" or "" for none; length is that of the positions.
    radii : dict
        By name, in units of the positions.
    radius : float
        The first of them.
    corners : (k,) int32
        Vertices that are corners, the strongest first; of the descriptor harris.
    warnings, notes : list of str
        Sentences about what limits the values, and about what had no effect or was done otherwise.
    backend, device : str
        What computed, and its name for people.
    report : dict
        Counts, times and settings by the names of the command line's --json.

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

    def __init__(self, results: Results) -> None:
        """Takes the results of a job."""
        self._values, settings = results.values, results.settings
        radii = (settings.options.radius, *settings.more_radii)
        pairs = [(name, radius) for radius in radii for name in settings.descriptors]
        self._names = dict(zip(pairs, settings.value_names(), strict=True))
        self.coverage: NDArray[np.float32] = results.coverage
        self.mask: NDArray[np.uint8] = results.mask
        self.domain = settings.domain
        map_name = settings.options.map_descriptor
        self.units = {name: legend.unit_of(name, map_name) for name in self}
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
            raise KeyError(f"{name!r} was not computed; there is {', '.join(self._values)}")
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
        """The values of one descriptor at all radii.

        Parameters
        ----------
        descriptor : str
            Its name without a radius.

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
            A mesh of trimesh, PyVista or Open3D with these vertices or faces. trimesh keeps values in
            vertex_attributes, PyVista in point_data, an Open3D tensor mesh in vertex, there (n, 1) and (n, 3); those of
            faces in face_attributes, cell_data and triangle.

        Returns
        -------
        mesh
            The same.

        Raises
        ------
        InputError
            It has another number of vertices or faces, or no place for values.
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
