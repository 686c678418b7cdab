"""Deforming in PyVista: `mesh.mls`, `plotter.mls`, and `read` of control points.

PyVista finds these by itself where this package is installed; in a checkout that is not,
`import vtk_mls.pyvista` makes them known.
"""

import pyvista

_OLDEST = 0, 48  # the first with accessors, components and readers of others

if pyvista.version_info[:2] < _OLDEST:
    raise ImportError(
        f"vtk_mls.pyvista needs PyVista {'.'.join(map(str, _OLDEST))} or later, this is "
        f"{pyvista.__version__}; `pip install --upgrade pyvista` brings it"
    )

from vtk_mls.pyvista import datasets, plotters, readers  # noqa: E402  only with such a PyVista
from vtk_mls.pyvista.readers import read  # noqa: E402

__all__ = ["datasets", "plotters", "read", "readers"]
