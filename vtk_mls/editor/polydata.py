"""Polydata from numpy arrays, and unlit actors for them."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import cell_array


def points(positions):
    """vtkPoints of positions (n, 3)."""
    result = vtkPoints()
    result.SetData(arrays.from_numpy(np.asarray(positions, float), VTK_DOUBLE))
    return result


def cells(connectivity):
    """A vtkCellArray of point ids (n, k): n cells with k points each."""
    count, size = connectivity.shape
    return cell_array(connectivity.ravel(), size * np.arange(count + 1))


def colors(values):
    """An array of colors (n, 3), 0 to 255, that mappers use directly."""
    return arrays.from_numpy(np.asarray(values).astype(np.uint8), VTK_UNSIGNED_CHAR)


def unlit_actor(source, color=None, width=1.0, opacity=1.0):
    """An actor of a vtkPolyData or an algorithm; without a color, that of the cell scalars."""
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    if isinstance(source, vtkPolyData):
        mapper.SetInputData(source)
    else:
        mapper.SetInputConnection(source.GetOutputPort())
    mapper.SetScalarVisibility(color is None)
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarModeToUseCellData()
    actor.SetMapper(mapper)
    actor.PickableOff()
    actor.GetProperty().SetColor(color or (1, 1, 1))
    actor.GetProperty().SetLineWidth(width)
    actor.GetProperty().SetOpacity(opacity)
    actor.GetProperty().LightingOff()
    return actor
