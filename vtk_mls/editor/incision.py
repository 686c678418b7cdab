"""A cut along a line that is drawn on the surface, open or closed."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls import Surface
from vtk_mls.vtk import arrays

_DEPTH, _OUT = 0.4, 0.15  # of the size of the data, into them and out of them
_COLOUR = (1.0, 0.35, 0.45)


class Incision:
    """A line on the surface that grows point by point, and the cut through it.

    Attributes
    ----------
    points : list of (3,)
    is_closed : bool
        Whether it ends where it began; it then grows no more.

    Parameters
    ----------
    renderer : vtkRenderer
        Over the data.
    """

    def __init__(self, renderer):
        self._renderer, self.points, self.is_closed = renderer, [], False
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
        self._draw()

    def close(self):
        """Go back to the first point."""
        self.is_closed = True
        self._draw()

    def cut(self, away, size, deformation):
        """The `Surface` that goes through the line.

        Parameters
        ----------
        away : (3,) or (n, 3)
            Unit vectors into the depth, for all points or for each.
        size : float
            Of the data.
        deformation : Deformation or None
            By which what one sees is deformed: the cut is where its material rests.
        """
        line = np.array(self.points)
        rows = np.stack([line - _OUT * size * away, line, line + _DEPTH * size * away])
        if deformation is not None:
            rows = deformation.backward(rows.reshape(-1, 3)).reshape(rows.shape)
        count, triangles = len(line), []
        for above, below in ((0, count), (count, 2 * count)):
            for i, j in self._edges():
                triangles += [(above + i, above + j, below + i), (above + j, below + j, below + i)]
        return Surface(rows.reshape(-1, 3), triangles)

    def remove(self):
        """Take the line out of the view."""
        self._renderer.RemoveActor(self._actor)

    def _edges(self):
        """Rows of the points at both ends of each edge."""
        following = [*range(1, len(self.points)), 0]
        return list(enumerate(following))[: None if self.is_closed else -1]

    def _draw(self):
        count = len(self.points)
        along = np.append(np.arange(count), [0] * self.is_closed)
        points, line, ends = vtkPoints(), vtkCellArray(), vtkCellArray()
        points.SetData(arrays.from_numpy(np.array(self.points), VTK_DOUBLE))
        line.SetData(arrays.ids(np.array([0, len(along)])), arrays.ids(along))
        ends.SetData(arrays.ids(np.arange(count + 1)), arrays.ids(np.arange(count)))
        self._line.SetPoints(points)
        self._line.SetLines(line if count > 1 else vtkCellArray())
        self._line.SetVerts(ends)
