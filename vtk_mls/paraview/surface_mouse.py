"""Ctrl with the mouse: a drag moves a handle along a surface, a click adds a handle on it."""

import numpy as np
from vtkmodules.vtkInteractionWidgets import vtkPolyLineRepresentation

from vtk_mls.paraview.observers import Observers
from vtk_mls.rendering.surfaces import VisibleSurface

_BEFORE_PARAVIEW = 1.0  # priority: ParaView reads the corrected position
_AFTER_WIDGETS = 0.1  # priority: a press that comes here did not hit a handle
_MAX_CLICK_MOTION = 3  # pixels


class SurfaceMouse:
    """The surface under the mouse for the handles of a widget, while Ctrl is held.

    During a drag this is the surface as it was when Ctrl was first held: the handle bends it.
    `widget` is the proxy of a vtk3DWidgetRepresentation; `markers`, vtkProps, are not part of the
    surface; `add_handle` is called with the clicked position (3,).
    """

    def __init__(self, widget, markers, add_handle):
        self._markers, self._add_handle = markers, add_handle
        self._surface = self._pressed_at = None
        self._observers, self._mouse = Observers(), Observers()
        self._widget = widget.GetClientSideObject().GetWidget()
        self._observers.add(self._widget, "StartInteractionEvent", self._drag_starts_or_ends)
        self._observers.add(self._widget, "InteractionEvent", self._drag, _BEFORE_PARAVIEW)
        self._observers.add(self._widget, "EndInteractionEvent", self._drag_starts_or_ends)
        self._observers.follow_widget(self._widget, self._enabled, lambda *_: self._mouse.end())

    def end(self):
        self._observers.end()
        self._mouse.end()

    def _enabled(self, widget, event):
        self._mouse.end()
        mouse = widget.GetInteractor()
        self._mouse.add(mouse, "LeftButtonPressEvent", self._pressed, _AFTER_WIDGETS)
        self._mouse.add(mouse, "LeftButtonReleaseEvent", self._released, _AFTER_WIDGETS)

    def _drag_starts_or_ends(self, widget, event):
        self._surface = None

    def _drag(self, widget, event):
        representation, mouse = widget.GetRepresentation(), widget.GetInteractor()
        index = representation.GetCurrentHandleIndex()
        is_moving = representation.GetInteractionState() == vtkPolyLineRepresentation.Moving
        if not (is_moving and mouse.GetControlKey() and index >= 0):
            return
        if self._surface is None:
            self._surface = VisibleSurface(representation.GetRenderer(), self._markers)
        position = self._surface.at(*mouse.GetEventPosition())
        if position is not None:
            representation.SetHandlePosition(index, *position)

    def _pressed(self, mouse, event):
        self._pressed_at = mouse.GetEventPosition() if mouse.GetControlKey() else None

    def _released(self, mouse, event):
        pressed_at, self._pressed_at = self._pressed_at, None
        pixel = mouse.GetEventPosition()
        if pressed_at is None or np.abs(np.subtract(pixel, pressed_at)).max() > _MAX_CLICK_MOTION:
            return
        renderer = self._widget.GetRepresentation().GetRenderer()
        position = VisibleSurface(renderer, self._markers).at(*pixel)
        if position is not None:
            self._add_handle(position)
