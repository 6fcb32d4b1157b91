"""Makes mesh.paradesc of PyVista's surfaces, by its entry point pyvista.accessors (PyVista 0.48 and later)."""

from collections.abc import Sequence
from typing import Any

import pyvista

from . import api
from .numpy_api.options import choice_of

# The words of PyVista's own PolyData.curvature().
CURVATURES = {
    "mean": "mean_curvature",
    "gaussian": "gaussian_curvature",
    "maximum": "principal_curvature_max",
    "minimum": "principal_curvature_min",
}


@pyvista.register_dataset_accessor("paradesc", pyvista.PolyData)
class ParadescAccessor:
    """Measures a surface, and adds what it finds to the surface's own arrays.

    Parameters
    ----------
    mesh : pyvista.PolyData
        The surface.

    Examples
    --------
    >>> import pyvista
    >>> mesh = pyvista.Sphere(radius=2).triangulate()
    >>> mesh.paradesc.curvature(radius=0.5, radius_unit="absolute").shape == (mesh.n_points,)
    True
    >>> mesh.point_data.keys()
    ['Normals', 'mean_curvature', 'coverage']
    """

    def __init__(self, mesh: "pyvista.PolyData") -> None:
        self._mesh = mesh

    def compute(
        self, descriptors: str | Sequence[str] = ("mean_curvature",), radius: Any = 0.02, **options: Any
    ) -> api.Result:
        """Adds descriptors, and the coverage, to point_data or, with domain="faces", to cell_data.

        Parameters
        ----------
        descriptors, radius, **options
            As paradesc.compute() takes them.

        Returns
        -------
        Result
            As of paradesc.compute().

        Raises
        ------
        InputError, TypeError, ParadescError
            As of paradesc.compute().
        """
        result = api.compute(self._mesh, descriptors=descriptors, radius=radius, **options)
        result.to(self._mesh)
        return result

    def curvature(self, curv_type: str = "mean", radius: Any = 0.02, **options: Any) -> Any:
        """Adds a curvature to point_data and returns it, as PyVista's own method of this name returns one.

        Parameters
        ----------
        curv_type : {"mean", "gaussian", "maximum", "minimum"}
            Which one; the array's name is that of the descriptor, such as "principal_curvature_max".
        radius, **options
            As paradesc.compute() takes them.

        Returns
        -------
        (n,) float32
            The array; with several radii (k, n).

        Raises
        ------
        InputError, TypeError, ParadescError
            As of paradesc.compute().
        """
        name = CURVATURES[choice_of("curv_type", curv_type, CURVATURES)]
        values = self.compute(name, radius, **options).over_radii(name)
        return values if len(values) > 1 else values[0]
