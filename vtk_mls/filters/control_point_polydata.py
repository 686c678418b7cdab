"""Control points as polydata."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray

from vtk_mls import arrays


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
    arrays.add(polydata.GetPointData(), "Displacement", deformed - rest)
    polydata.GetPointData().SetActiveVectors("Displacement")
    if weights is not None:
        arrays.add(polydata.GetPointData(), "Weight", weights)
    if any(labels):
        arrays.add_texts(polydata.GetPointData(), "Label", labels)
