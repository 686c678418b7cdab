"""A cut along a line that is drawn on the surface: as deep as the line is seen."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls import Surface, arrays
from vtk_mls.linear_algebra import unit

_DEPTH, _OUT = 0.4, 0.15  # of the size of the data, into them and out of them
_COLOUR = (1.0, 0.35, 0.45)


class Incision:
    """A line on the surface that grows point by point, and the cut through it.

    Parameters
    ----------
    renderer : vtkRenderer
        Over the data.
    """

    def __init__(self, renderer):
        self._renderer, self.points = renderer, []
        self._line, mapper, self._actor = vtkPolyData(), vtkPolyDataMapper(), vtkActor()
        mapper.SetInputData(self._line)
        self._actor.SetMapper(mapper)
        drawn_as = self._actor.GetProperty()
        drawn_as.SetColor(_COLOUR)
        drawn_as.SetLineWidth(4)
        drawn_as.SetPointSize(9)
        drawn_as.RenderPointsAsSpheresOn()
        drawn_as.LightingOff()
        renderer.AddActor(self._actor)

    def add(self, point):
        """Go on to a point (3,)."""
        self.points.append(np.array(point))
        count = len(self.points)
        points, line, ends = vtkPoints(), vtkCellArray(), vtkCellArray()
        points.SetData(arrays.from_numpy(np.array(self.points), VTK_DOUBLE))
        line.SetData(arrays.ids(np.array([0, count])), arrays.ids(np.arange(count)))
        ends.SetData(arrays.ids(np.arange(count + 1)), arrays.ids(np.arange(count)))
        self._line.SetPoints(points)
        self._line.SetLines(line if count > 1 else vtkCellArray())
        self._line.SetVerts(ends)

    def cut(self, eye, size, deformation):
        """The `Surface` that goes through the line, away from the eye.

        Parameters
        ----------
        eye : (3,)
        size : float
            Of the data.
        deformation : Deformation or None
            By which what one sees is deformed: the cut is where its material rests.
        """
        line = np.array(self.points)
        away = unit(line - eye)
        rows = np.stack([line - _OUT * size * away, line, line + _DEPTH * size * away])
        if deformation is not None:
            rows = deformation.backward(rows.reshape(-1, 3)).reshape(rows.shape)
        count, triangles = len(line), []
        for row in range(2):
            for i in range(count - 1):
                a, b = row * count + i, (row + 1) * count + i
                triangles += [(a, a + 1, b), (a + 1, b + 1, b)]
        return Surface(rows.reshape(-1, 3), triangles)

    def remove(self):
        """Take the line out of the view."""
        self._renderer.RemoveActor(self._actor)
