"""VTK objects from values: points, cells and colors of numpy, unlit actors."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import cell_array
from vtk_mls.vtk.objects import configured


def points(positions):
    """vtkPoints of positions (n, 3)."""
    return configured(vtkPoints(), Data=arrays.from_numpy(np.asarray(positions, float), VTK_DOUBLE))


def cells(connectivity):
    """A vtkCellArray of point ids (n, k): n cells with k points each."""
    count, size = connectivity.shape
    return cell_array(connectivity.ravel(), size * np.arange(count + 1))


def colors(values):
    """An array of colors (n, 3), 0 to 255, that mappers use directly."""
    return arrays.from_numpy(np.asarray(values).astype(np.uint8), VTK_UNSIGNED_CHAR)


def unlit_actor(source, color=None, width=1.0, opacity=1.0):
    """An actor of a vtkPolyData or an algorithm; without a color, that of the cell scalars."""
    mapper = configured(vtkPolyDataMapper(), ScalarVisibility=color is None)
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarModeToUseCellData()
    if isinstance(source, vtkPolyData):
        mapper.SetInputData(source)
    else:
        mapper.SetInputConnection(source.GetOutputPort())
    actor, color = configured(vtkActor(), Mapper=mapper, Pickable=False), color or (1, 1, 1)
    configured(actor.GetProperty(), Color=color, LineWidth=width, Opacity=opacity, Lighting=False)
    return actor


def show_points_as_balls(actor, size):
    """Draw the vertices of an actor as balls, `size` pixels wide."""
    configured(actor.GetProperty(), PointSize=size, RenderPointsAsSpheres=True)
