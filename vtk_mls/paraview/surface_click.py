"""A handle that is added where a surface is clicked, while Ctrl is held."""

from __future__ import annotations

import numpy as np

from vtk_mls.paraview.observers import Observers
from vtk_mls.rendering.visible_surface import VisibleSurface

_AFTER_WIDGETS = 0.1  # priority: a press that is heard then has taken hold of nothing
_MAX_MOTION = 3  # pixels, of a click


class SurfaceClick:
    """Hears of clicks on what one sees, beside the handles of a widget.

    Parameters
    ----------
    widget : proxy of a vtk3DWidgetRepresentation
    marks : sequence of vtkProp
        How the handles are drawn: these are no part of the surface.
    add : callable
        Called with the position (3,) that was clicked.
    """

    def __init__(self, widget, marks, add):
        self._marks, self._add, self._pressed_at = marks, add, None
        self._widget = widget.GetClientSideObject().GetWidget()
        self._observers, self._mouse = Observers(), Observers()
        self._observers.add(self._widget, "EnableEvent", self._shown)
        self._observers.add(self._widget, "DisableEvent", self._hidden)
        if self._widget.GetEnabled():
            self._shown(self._widget, None)

    def end(self):
        """Hear of clicks no more."""
        self._observers.end()
        self._mouse.end()

    def _shown(self, widget, event):
        self._mouse.end()
        for event, answer in (
            ("LeftButtonPressEvent", self._pressed),
            ("LeftButtonReleaseEvent", self._released),
        ):
            self._mouse.add(widget.GetInteractor(), event, answer, _AFTER_WIDGETS)

    def _hidden(self, widget, event):
        self._mouse.end()

    def _pressed(self, mouse, event):
        self._pressed_at = mouse.GetEventPosition() if mouse.GetControlKey() else None

    def _released(self, mouse, event):
        pressed_at, self._pressed_at = self._pressed_at, None
        pixel = mouse.GetEventPosition()
        if pressed_at is None or np.abs(np.subtract(pixel, pressed_at)).max() > _MAX_MOTION:
            return
        renderer = self._widget.GetRepresentation().GetRenderer()
        position = VisibleSurface(renderer, self._marks).at(*pixel)
        if position is not None:
            self._add(position)
