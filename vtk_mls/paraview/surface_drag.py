"""Dragging a handle along the surface under the mouse, while Ctrl is held."""

from __future__ import annotations

from vtkmodules.vtkInteractionWidgets import vtkPolyLineRepresentation

from vtk_mls.paraview.observers import Observers
from vtk_mls.rendering.visible_surface import VisibleSurface

_BEFORE_PARAVIEW = 1.0  # priority: it hears where the handle is when it has been put there


class SurfaceDrag:
    """Keeps the handle that is dragged on the surface as it was seen when Ctrl was first held.

    The surface is not followed while it is bent: the handle itself bends it.

    Parameters
    ----------
    widget : proxy of a vtk3DWidgetRepresentation
    marks : sequence of vtkProp
        How the handles are drawn: these are no part of the surface.
    """

    def __init__(self, widget, marks):
        self._marks, self._surface, self._observers = marks, None, Observers()
        drawn = widget.GetClientSideObject().GetWidget()
        self._observers.add(drawn, "StartInteractionEvent", self._begin_or_end)
        self._observers.add(drawn, "InteractionEvent", self._drag, _BEFORE_PARAVIEW)
        self._observers.add(drawn, "EndInteractionEvent", self._begin_or_end)

    def end(self):
        """Leave the handles to ParaView."""
        self._observers.end()

    def _begin_or_end(self, widget, event):
        self._surface = None

    def _drag(self, widget, event):
        representation, mouse = widget.GetRepresentation(), widget.GetInteractor()
        number = representation.GetCurrentHandleIndex()
        is_moved = representation.GetInteractionState() == vtkPolyLineRepresentation.Moving
        if not (is_moved and mouse.GetControlKey() and number >= 0):
            return
        if self._surface is None:
            self._surface = VisibleSurface(representation.GetRenderer(), self._marks)
        position = self._surface.at(*mouse.GetEventPosition())
        if position is not None:
            representation.SetHandlePosition(number, *position)
