"""Control points as polydata."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls.base.errors import InputError
from vtk_mls.model.handles.handle_cells import HandleCells
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import positions_of, set_positions
from vtk_mls.vtk.handle_datasets import cells_of, set_cells

# Names of the point arrays.
DISPLACEMENT, WEIGHT, LABEL, PATH = "Displacement", "Weight", "Label", "Path"


def fill_polydata(polydata, rest, deformed, weights, labels=(), cells=None, path=()):
    """Make control-point polydata, what `arrays.control_points` reads.

    It gets the active vectors "Displacement" = q - p, "Weight" if there are weights (n,), and the
    `cells`, by default a vertex for each p. p and q are (n, 3) float64, world coordinates. Labels
    become the point array "Label" if any is not empty. The intermediate places `path` (k, n, 3)
    become "Path" of 3 k components, the displacements from p to each.
    """
    set_positions(polydata, rest, VTK_DOUBLE)
    set_cells(polydata, cells or HandleCells.points(len(rest)))
    arrays.add(polydata.GetPointData(), DISPLACEMENT, deformed - rest)
    polydata.GetPointData().SetActiveVectors(DISPLACEMENT)
    if weights is not None:
        arrays.add(polydata.GetPointData(), WEIGHT, weights)
    if any(labels):
        arrays.add_texts(polydata.GetPointData(), LABEL, labels)
    if len(path):
        arrays.add(polydata.GetPointData(), PATH, np.hstack([places - rest for places in path]))


def path_of(point_set):
    """Intermediate places (k, n, 3) of control points, world coordinates, from their array "Path".

    k is 0 without the array. ValueError if it is not finite or has the wrong shape.
    """
    count, array = point_set.GetNumberOfPoints(), point_set.GetPointData().GetArray(PATH)
    if array is None or count == 0:
        return np.zeros((0, count, 3))
    components, tuples = array.GetNumberOfComponents(), array.GetNumberOfTuples()
    if components % 3 or tuples != count:
        raise InputError(
            f", array `{PATH}`, must have 3 components per intermediate place and one tuple for "
            f"each of {count} points, got {components} components, {tuples} tuples",
            argument="ControlPoints",
        )
    moves = arrays.to_numpy(array).astype(np.float64).reshape(count, -1, 3)
    if not np.isfinite(moves).all():
        raise InputError(f", array `{PATH}`, must be finite", argument="ControlPoints")
    return positions_of(point_set) + moves.swapaxes(0, 1)


def is_moving(polydata):
    """Whether any displacement of control-point polydata, also on the way, is not 0."""
    data = [polydata.GetPointData().GetArray(name) for name in (DISPLACEMENT, PATH)]
    return any(arrays.to_numpy(array).any() for array in data if array is not None)


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
