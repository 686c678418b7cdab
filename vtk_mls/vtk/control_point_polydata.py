"""Control points as polydata."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from vtk_mls.vtk import arrays

# Names of the point arrays.
DISPLACEMENT, WEIGHT, LABEL = "Displacement", "Weight", "Label"


def fill_polydata(polydata, rest, deformed, weights, labels=()):
    """Make control-point polydata, what `arrays.control_points` reads.

    Parameters
    ----------
    polydata : vtkPolyData
        Gets a vertex for each p, the active vectors "Displacement" = q - p, and "Weight" if there
        are weights; float64.
    rest, deformed : (n, 3) float64, world coordinates
    weights : (n,) float64 or None
    labels : list of n str, optional
        Become the point array "Label" if any is not empty.
    """
    points = vtkPoints()
    points.SetData(arrays.from_numpy(rest, VTK_DOUBLE))
    polydata.SetPoints(points)
    vertices = vtkCellArray()
    vertices.SetData(arrays.ids(np.arange(len(rest) + 1)), arrays.ids(np.arange(len(rest))))
    polydata.SetVerts(vertices)
    arrays.add(polydata.GetPointData(), DISPLACEMENT, deformed - rest)
    polydata.GetPointData().SetActiveVectors(DISPLACEMENT)
    if weights is not None:
        arrays.add(polydata.GetPointData(), WEIGHT, weights)
    if any(labels):
        arrays.add_texts(polydata.GetPointData(), LABEL, labels)


def as_polydata(point_set):
    """The points of a vtkPointSet, with their arrays, as vtkPolyData; polydata as it is."""
    if isinstance(point_set, vtkPolyData):
        return point_set
    polydata = vtkPolyData()
    polydata.SetPoints(point_set.GetPoints())
    polydata.GetPointData().ShallowCopy(point_set.GetPointData())
    polydata.GetFieldData().ShallowCopy(point_set.GetFieldData())
    return polydata
