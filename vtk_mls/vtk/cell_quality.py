"""The quality of cells by VTK's own measure."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE
from vtkmodules.vtkFiltersCore import vtkPointDataToCellData
from vtkmodules.vtkFiltersVerdict import vtkCellQuality

from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import is_empty, set_positions, without_empty
from vtk_mls.vtk.objects import configured, output_of

_MAX_QUALITY = 2  # that of inverted wedges is down to -1.2


def scaled_jacobians(mesh, positions):
    """VTK's scaled Jacobian (m,) of the cells of a vtkPointSet with its points at `positions`.

    At most 1, for regular cells; 0 or less for solid cells that are inside out at a corner, and for
    concave quads. NaN for cells that are no triangles, quads, tetrahedra, hexahedra, wedges or
    pyramids, and for those with a point that is not finite.
    """
    moved = mesh.NewInstance()
    moved.CopyStructure(mesh)
    set_positions(moved, positions, VTK_DOUBLE)
    result = np.full(mesh.GetNumberOfCells(), np.nan)
    filled = without_empty(moved)
    if filled.GetNumberOfCells() == 0:
        return result
    quality = configured(vtkCellQuality(), UndefinedQuality=np.nan, UnsupportedGeometry=np.nan)
    quality.SetQualityMeasureToScaledJacobian()
    data = output_of(quality, InputData=filled).GetCellData()
    values = arrays.to_numpy(data.GetArray("CellQuality")).copy()
    values[np.abs(values) > _MAX_QUALITY] = np.nan  # 1e30 if all corners are at one place
    if not np.isfinite(positions).all():
        values[~_are_finite(filled, positions)] = np.nan
    result[~is_empty(moved)] = values
    return result


def _are_finite(mesh, positions):
    """Which cells have finite points only: (m,) bool. Others have any quality by VTK."""
    arrays.add(mesh.GetPointData(), "sum", positions.sum(axis=1, dtype=np.float64))
    means = output_of(vtkPointDataToCellData(), InputData=mesh)
    return np.isfinite(arrays.to_numpy(means.GetCellData().GetArray("sum")))
