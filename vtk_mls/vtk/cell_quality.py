"""The quality of cells by VTK's own measure."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE
from vtkmodules.vtkFiltersVerdict import vtkCellQuality

from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import is_empty, set_positions, without_empty


def scaled_jacobians(mesh, positions):
    """VTK's scaled Jacobian of the cells of a mesh with its points at `positions`.

    Parameters
    ----------
    mesh : vtkPointSet
    positions : (n, 3) array, world coordinates

    Returns
    -------
    (m,) float64
        At most 1, for regular cells; 0 or less for solid cells that are inside out at a corner,
        and for concave quads. NaN for cells that are no triangles, quads, tetrahedra, hexahedra,
        wedges or pyramids, and for those with a point that is not finite.
    """
    moved = mesh.NewInstance()
    moved.CopyStructure(mesh)
    set_positions(moved, positions, VTK_DOUBLE)
    result = np.full(mesh.GetNumberOfCells(), np.nan)
    filled = without_empty(moved)
    if filled.GetNumberOfCells() == 0:
        return result
    quality = vtkCellQuality()
    quality.SetInputData(filled)
    quality.SetQualityMeasureToScaledJacobian()
    quality.SetUndefinedQuality(np.nan)
    quality.SetUnsupportedGeometry(np.nan)
    quality.Update()
    data = quality.GetOutput().GetCellData()
    values = arrays.to_numpy(data.GetArray("CellQuality"))
    # points at NaN, or all at one place, have any value, up to 1e30
    result[~is_empty(moved)] = np.where(np.abs(values) <= 1 + 1e-9, values, np.nan)
    return result
