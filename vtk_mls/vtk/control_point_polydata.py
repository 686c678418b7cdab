"""Control points as polydata."""

from __future__ import annotations

from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls.handles.handle_cells import HandleCells
from vtk_mls.vtk import arrays
from vtk_mls.vtk.handle_cells import cells_of, set_cells

# Names of the point arrays.
DISPLACEMENT, WEIGHT, LABEL = "Displacement", "Weight", "Label"


def fill_polydata(polydata, rest, deformed, weights, labels=(), cells=None):
    """Make control-point polydata, what `arrays.control_points` reads.

    Parameters
    ----------
    polydata : vtkPolyData
        Gets the active vectors "Displacement" = q - p, "Weight" if there are weights, float64, and
        the cells.
    rest, deformed : (n, 3) float64, world coordinates
    weights : (n,) float64 or None
    labels : list of n str, optional
        Become the point array "Label" if any is not empty.
    cells : HandleCells, optional
        By default a vertex for each p.
    """
    points = vtkPoints()
    points.SetData(arrays.from_numpy(rest, VTK_DOUBLE))
    polydata.SetPoints(points)
    set_cells(polydata, cells or HandleCells.points(len(rest)))
    arrays.add(polydata.GetPointData(), DISPLACEMENT, deformed - rest)
    polydata.GetPointData().SetActiveVectors(DISPLACEMENT)
    if weights is not None:
        arrays.add(polydata.GetPointData(), WEIGHT, weights)
    if any(labels):
        arrays.add_texts(polydata.GetPointData(), LABEL, labels)


def as_polydata(point_set):
    """A vtkPointSet as vtkPolyData with its cells as handles; polydata as it is."""
    if isinstance(point_set, vtkPolyData):
        return point_set
    polydata = vtkPolyData()
    polydata.SetPoints(point_set.GetPoints())
    polydata.GetPointData().ShallowCopy(point_set.GetPointData())
    polydata.GetFieldData().ShallowCopy(point_set.GetFieldData())
    set_cells(polydata, cells_of(point_set))
    return polydata
