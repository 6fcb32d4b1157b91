"""Makes mesh.paradesc of PyVista's surfaces, by its entry point pyvista.accessors (PyVista 0.48 and later)."""

from typing import TYPE_CHECKING, Any

import pyvista

from . import api

if TYPE_CHECKING:
    from collections.abc import Sequence


@pyvista.register_dataset_accessor("paradesc", pyvista.PolyData)
class ParadescAccessor:
    """Measures a surface of PyVista, as in mesh.paradesc.compute("curvedness", radius=0.05)["curvedness"].

    Parameters
    ----------
    mesh : pyvista.PolyData
        The surface.
    """

    def __init__(self, mesh: "pyvista.PolyData") -> None:
        self._mesh = mesh

    def compute(
        self, descriptors: "str | Sequence[str]" = ("mean_curvature",), radius: Any = 0.02, **options: Any
    ) -> Any:
        """Returns a copy of the surface with the values in point_data, or in cell_data with domain="faces".

        Parameters
        ----------
        descriptors, radius, **options
            The same as in paradesc.compute().

        Returns
        -------
        pyvista.PolyData
            A copy with an array for each descriptor, and the coverage.

        Raises
        ------
        InputError, ParadescError
            As paradesc.compute() does.

        Examples
        --------
        >>> import pyvista
        >>> measured = pyvista.ParametricTorus().clean().paradesc.compute("curvedness", radius=0.1)
        >>> measured.active_scalars_name
        'curvedness'
        """
        result = api.compute(self._mesh, descriptors=descriptors, radius=radius, **options)
        measured = result.to(self._mesh.copy())
        first = next(iter(result))
        if result[first].ndim == 1:
            measured.set_active_scalars(first, preference="cell" if result.domain == "faces" else "point")
        return measured

    def curvature(self, radius: Any = 0.02, **options: Any) -> Any:
        """Returns a copy of the surface with the mean, the Gaussian and both principal curvatures.

        Parameters
        ----------
        radius, **options
            The same as in paradesc.compute().

        Returns
        -------
        pyvista.PolyData
            A copy with an array for each curvature, and the coverage.

        Raises
        ------
        InputError, ParadescError
            As paradesc.compute() does.
        """
        return self.compute(CURVATURES, radius, **options)


CURVATURES = ("mean_curvature", "gaussian_curvature", "principal_curvature_max", "principal_curvature_min")
