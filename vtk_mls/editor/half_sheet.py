"""The half of a plane that cuts, and the edge where it ends."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPlane
from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkCutter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

_FACE, _EDGE = (0.35, 0.75, 1.0), (1.0, 0.45, 0.55)
_OPACITY, _WIDTH = 0.3, 4
_WITHIN = 0.1, 0.45  # opacities of sheet and edge where data hide them


class HalfSheet:
    """Draws a HalfPlane as far as it is within a box.

    Parameters
    ----------
    renderer, overlay : vtkRenderer
        Of the data, and one that is drawn over them.
    corners : (2, 3)
        Of the box.
    """

    def __init__(self, renderer, overlay, corners):
        box, self._plane, self._rim = vtkImageData(), vtkPlane(), vtkPlane()
        box.SetDimensions(2, 2, 2)
        box.SetOrigin(corners[0])
        box.SetSpacing(np.maximum(np.ptp(corners, axis=0), 1e-9 * np.ptp(corners)))
        sheet, half, edge = vtkCutter(), vtkClipPolyData(), vtkCutter()
        sheet.SetInputData(box)
        sheet.SetCutFunction(self._plane)
        half.SetInputConnection(sheet.GetOutputPort())
        half.SetClipFunction(self._rim)
        edge.SetInputConnection(sheet.GetOutputPort())
        edge.SetCutFunction(self._rim)
        self._actors = []
        for where, opacities in ((renderer, (_OPACITY, 1.0)), (overlay, _WITHIN)):
            for drawn, colour, opacity in zip((half, edge), (_FACE, _EDGE), opacities):
                self._actors.append(_actor(drawn, colour, opacity))
                where.AddActor(self._actors[-1])
        self.set_visible(False)

    def show(self, cut):
        """Draw a HalfPlane."""
        for plane, normal in ((self._plane, cut.normal), (self._rim, cut.inward)):
            plane.SetOrigin(cut.point)
            plane.SetNormal(normal)

    def set_visible(self, is_visible):
        """Show or hide it."""
        for actor in self._actors:
            actor.SetVisibility(is_visible)


def _actor(algorithm, colour, opacity):
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputConnection(algorithm.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor.SetMapper(mapper)
    actor.PickableOff()
    drawn_as = actor.GetProperty()
    drawn_as.SetColor(colour)
    drawn_as.SetOpacity(opacity)
    drawn_as.SetLineWidth(_WIDTH)
    drawn_as.LightingOff()
    return actor
