"""Drags of handles: of one of many, and along surfaces.

When a handle moves, ParaView sets all handles of its widget one by one, and the widget computes the
sizes of all after each: seconds with 500 handles. ParaView therefore gets only the end of a drag,
and computes the sizes once.

With Ctrl a drag moves a handle along a surface, and a click adds a handle on it.
"""

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkObject
from vtkmodules.vtkInteractionWidgets import vtkPolyLineRepresentation

from vtk_mls.paraview.handle_lists import DRAGGED
from vtk_mls.paraview.server_manager import EDITED, Observers, find_proxy, pending_value
from vtk_mls.rendering.surfaces import VisibleSurface

MAX_DIRECT = 50  # handles; ParaView follows drags among fewer
# Priorities.
_ON_SURFACE = 1.0  # ParaView and deferred drags read the corrected position
_BEFORE_PARAVIEW, _AFTER_PARAVIEW = 0.5, -0.5
_AFTER_WIDGETS = 0.1  # a press that comes here did not hit a handle
_MAX_CLICK_MOTION = 3  # pixels


class DeferredDrags:
    """Keeps drags from ParaView until they end, if there are many handles.

    `callbacks` by the names of lists of the proxy are called with the list's property and an event
    for each edit that ParaView does not get yet.
    """

    def __init__(self, proxy, callbacks):
        self._proxy_id, self._callbacks = proxy.GetGlobalID(), callbacks
        self._is_dragging = self._is_ending = False
        self._deferred = {}  # properties with edits that ParaView did not get yet, by their names
        self._widgets, self._unsized, self._observers = [], [], Observers()
        for name in callbacks:
            self._observe_list(proxy.GetProperty(name))

    def add_widget(self, widget):
        """Defer the drags of a widget, a proxy of a vtk3DWidgetRepresentation."""
        widget = widget.GetClientSideObject().GetWidget()
        self._widgets.append(widget)

        def drag(widget, event):
            proxy, representation = find_proxy(self._proxy_id), widget.GetRepresentation()
            is_deferred = representation.GetNumberOfHandles() > MAX_DIRECT
            if proxy and is_deferred and not self._is_ending:
                widget.GetCommand(tag).SetAbortFlag(True)
                self._edit(proxy, vtk_to_numpy(representation.GetHandlePositions()))

        def drag_ends(widget, event):
            deferred, self._deferred = self._deferred, {}
            if not deferred or not find_proxy(self._proxy_id):
                return
            self._is_ending = True
            self._suspend_sizes()
            try:
                widget.InvokeEvent("InteractionEvent")
                for prop in deferred.values():
                    prop.InvokeEvent(EDITED)
            finally:
                self._is_ending = False
                self._compute_sizes()

        tag = self._observers.add(widget, "InteractionEvent", drag, _BEFORE_PARAVIEW)
        self._observers.add(widget, "EndInteractionEvent", drag_ends, _BEFORE_PARAVIEW)

    def end(self):
        self._observers.end()

    def _edit(self, proxy, positions):
        """Make positions pending without ParaView's reaction."""
        self._is_dragging = True
        try:
            prop = proxy.GetProperty(DRAGGED[pending_value(proxy, "Drag")])
            prop.SetUncheckedElements(np.ravel(positions).tolist(), positions.size)
        finally:
            self._is_dragging = False

    def _observe_list(self, prop):
        def before_paraview(prop, event):
            if self._is_dragging:
                vtkObject.GetCommand(prop, tag).SetAbortFlag(True)  # properties override it
                self._deferred[prop.GetXMLName()] = prop
                self._callbacks[prop.GetXMLName()](prop, event)
            else:
                self._suspend_sizes()

        def after_paraview(prop, event):
            if not self._is_ending:
                self._compute_sizes()

        tag = self._observers.add(prop, EDITED, before_paraview, _BEFORE_PARAVIEW)
        self._observers.add(prop, EDITED, after_paraview, _AFTER_PARAVIEW)

    def _suspend_sizes(self):
        """Take away the renderers: without one, a widget does not compute sizes of handles."""
        for representation in (widget.GetRepresentation() for widget in self._widgets):
            renderer = representation.GetRenderer()
            if renderer and representation.GetNumberOfHandles() > MAX_DIRECT:
                self._unsized.append((representation, renderer))
                representation.SetRenderer(None)

    def _compute_sizes(self):
        unsized, self._unsized = self._unsized, []
        for representation, renderer in unsized:
            representation.SetRenderer(renderer)
            representation.BuildRepresentation()


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
        self._observers.add(self._widget, "InteractionEvent", self._drag, _ON_SURFACE)
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
