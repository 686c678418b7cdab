"""Drags of one of many handles.

When a handle has moved, ParaView sets all of its widget's, one by one, and after each the widget
sizes all: with 500 that takes seconds. So where there are many, ParaView hears of a drag when it
ends, and the sizes are found once.
"""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkObject

from vtk_mls.paraview.handle_rows import DRAGGED
from vtk_mls.paraview.observers import Observers
from vtk_mls.paraview.server_manager import find

_MANY = 50
_EDITED = "UncheckedPropertyModifiedEvent"
_BEFORE_PARAVIEW, _AFTER_PARAVIEW = 0.5, -0.5  # priorities; what corrects a drag has a higher one


class ManyHandles:
    """What ParaView does not hear of, while one of many handles is dragged.

    Parameters
    ----------
    proxy : proxy with lists of handles
    answers : dict of str to callable
        What is called with a list and an event when the list of this name was edited: by its
        property's events, and from here while these are kept from ParaView.
    """

    def __init__(self, proxy, answers):
        self._number, self._answers = proxy.GetGlobalID(), answers
        self._is_quiet = self._is_ending = False
        self._edited = {}  # lists of which ParaView has not heard, by their names
        self._drawn, self._unsized, self._observers = [], [], Observers()
        for name in answers:
            self._listen(proxy.GetProperty(name))

    def take(self, widget):
        """Keep from ParaView how a widget's handles are dragged.

        Parameters
        ----------
        widget : proxy of a vtk3DWidgetRepresentation
        """
        drawn = widget.GetClientSideObject().GetWidget()
        self._drawn.append(drawn)

        def drag(drawn, event):
            proxy, shown = find(self._number), drawn.GetRepresentation()
            if proxy and shown.GetNumberOfHandles() > _MANY and not self._is_ending:
                drawn.GetCommand(tag).SetAbortFlag(True)
                self._edit(proxy, vtk_to_numpy(shown.GetHandlePositions()))

        def end(drawn, event):
            edited, self._edited = self._edited, {}
            if edited and find(self._number):
                self._is_ending = True
                self._leave_sizes()
                try:
                    drawn.InvokeEvent("InteractionEvent")
                    for changed in edited.values():
                        changed.InvokeEvent(_EDITED)
                finally:
                    self._is_ending = False
                    self._find_sizes()

        tag = self._observers.add(drawn, "InteractionEvent", drag, _BEFORE_PARAVIEW)
        self._observers.add(drawn, "EndInteractionEvent", end, _BEFORE_PARAVIEW)

    def end(self):
        """Let ParaView hear of all drags."""
        self._observers.end()

    def _edit(self, proxy, positions):
        """Make positions pending, and let all but ParaView know."""
        name = DRAGGED[proxy.GetProperty("Drag").GetUncheckedElement(0)]
        with self._quiet():
            changed = proxy.GetProperty(name)
            changed.SetUncheckedElements(np.ravel(positions).tolist(), positions.size)

    @contextmanager
    def _quiet(self):
        self._is_quiet = True
        try:
            yield
        finally:
            self._is_quiet = False

    def _listen(self, changed):
        """Hear of edits of a list before ParaView does, and after."""

        def before(changed, event):
            if self._is_quiet:
                vtkObject.GetCommand(changed, tag).SetAbortFlag(True)  # its own is another
                self._edited[changed.GetXMLName()] = changed
                self._answers[changed.GetXMLName()](changed, event)
            else:
                self._leave_sizes()

        def after(changed, event):
            if not self._is_ending:
                self._find_sizes()

        tag = self._observers.add(changed, _EDITED, before, _BEFORE_PARAVIEW)
        self._observers.add(changed, _EDITED, after, _AFTER_PARAVIEW)

    def _leave_sizes(self):
        """Without a renderer, widgets do not find how large handles are in pixels."""
        for shown in (drawn.GetRepresentation() for drawn in self._drawn):
            if shown.GetNumberOfHandles() > _MANY and shown.GetRenderer():
                self._unsized.append((shown, shown.GetRenderer()))
                shown.SetRenderer(None)

    def _find_sizes(self):
        unsized, self._unsized = self._unsized, []
        for shown, renderer in unsized:
            shown.SetRenderer(renderer)
            shown.BuildRepresentation()
