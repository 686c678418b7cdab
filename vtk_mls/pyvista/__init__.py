"""Deforming in PyVista: `mesh.mls`, `plotter.mls`, and `read` of control points.

PyVista finds these by itself where this package is installed; in a checkout that is not installed,
`import vtk_mls.pyvista` registers them.
"""

import pyvista

_MIN_VERSION = 0, 48  # the first with accessors, components and readers of other packages

if pyvista.version_info[:2] < _MIN_VERSION:
    raise ImportError(
        f"vtk_mls.pyvista needs PyVista {'.'.join(map(str, _MIN_VERSION))} or later, this is "
        f"{pyvista.__version__}; `pip install --upgrade pyvista` brings it"
    )

from vtk_mls.pyvista import datasets, plotters, readers  # noqa: E402  only with such a PyVista
from vtk_mls.pyvista.readers import read  # noqa: E402

__all__ = ["datasets", "plotters", "read", "readers"]
