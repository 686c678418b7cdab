"""Views drawn anew a little later: once, however often that is asked for."""

from __future__ import annotations

from vtkmodules.vtkCommonCore import VTK_INT

from vtk_mls.paraview.server_manager import find

_SOON = 100  # milliseconds: by then ParaView has drawn what it draws anyway
_due = set()  # ids of views


def ask(numbers):
    """Draw the views with these ids when what happens now is over, unless they are drawn before."""
    for number in numbers:
        view = find(number, "views")
        client = view.GetClientSideObject() if view else None
        if number not in _due and client and client.GetInteractor():
            _due.add(number)
            _wait(number, client.GetRenderWindow(), client.GetInteractor())


def _wait(number, window, interactor):
    """Draw a view when a timer says so."""

    def end():
        window.RemoveObserver(observed)
        interactor.RemoveObserver(awaited)
        _due.discard(number)

    def drawn(window, event):
        end()

    def soon(interactor, event, which):
        if which == timer:
            end()
            view = find(number, "views")
            if view and view.GetSession().GetPendingProgress():
                ask([number])  # ParaView looks at timers while it computes, too
            elif view:
                view.StillRender()

    soon.CallDataType = VTK_INT
    observed = window.AddObserver("EndEvent", drawn)
    awaited = interactor.AddObserver("TimerEvent", soon)
    timer = interactor.CreateOneShotTimer(_SOON)
