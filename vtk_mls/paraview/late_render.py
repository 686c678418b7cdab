"""Views drawn anew a little later: once, however often that is asked for."""

from __future__ import annotations

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_INT

from vtk_mls.paraview.observers import Observers
from vtk_mls.paraview.server_manager import find

_SOON = 100  # milliseconds: by then ParaView has drawn what it draws anyway
_due = {}  # by the ids of views: what draws each


def ask(numbers):
    """Draw the views with these ids when what happens now is over, unless they are drawn before."""
    for number in numbers:
        view = find(number, "views")
        client = view.GetClientSideObject() if view else None
        if number not in _due and client and client.GetInteractor():
            _due[number] = _LateRender(number, client)


class _LateRender:
    """Draws a view when a timer says so.

    Parameters
    ----------
    number : int
        Id of the view.
    client : vtkPVRenderView
    """

    def __init__(self, number, client):
        self._number, self._observers = number, Observers()
        interactor = client.GetInteractor()
        self._observers.add(client.GetRenderWindow(), "EndEvent", self._drawn)
        self._observers.add(interactor, "TimerEvent", self._soon)
        self._timer = interactor.CreateOneShotTimer(_SOON)

    def _end(self):
        self._observers.end()
        _due.pop(self._number, None)

    def _drawn(self, window, event):
        self._end()

    @calldata_type(VTK_INT)
    def _soon(self, interactor, event, timer):
        if timer != self._timer:
            return
        self._end()
        view = find(self._number, "views")
        if view and view.GetSession().GetPendingProgress():
            ask([self._number])  # ParaView looks at timers while it computes, too
        elif view:
            view.StillRender()
