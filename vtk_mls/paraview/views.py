"""ParaView's views, rendered a moment later: once for any number of requests."""

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_INT

from vtk_mls.paraview.observers import Observers
from vtk_mls.paraview.server_manager import find_proxy

_DELAY = 100  # milliseconds; ParaView's own rendering is done by then
_pending = {}  # _LateRender by the ids of views


def render_later(view_ids):
    """Render views after the current events, unless they are rendered before."""
    for view_id in view_ids:
        view = find_proxy(view_id, "views")
        client = view.GetClientSideObject() if view else None
        if view_id not in _pending and client and client.GetInteractor():
            _pending[view_id] = _LateRender(view_id, client)


class _LateRender:
    """Renders a view, whose client is a vtkPVRenderView, when a timer fires."""

    def __init__(self, view_id, client):
        self._view_id, self._observers = view_id, Observers()
        interactor = client.GetInteractor()
        self._observers.add(client.GetRenderWindow(), "EndEvent", self._rendered)
        self._observers.add(interactor, "TimerEvent", self._timer_fired)
        self._timer = interactor.CreateOneShotTimer(_DELAY)

    def _rendered(self, window, event):
        self._observers.end()
        _pending.pop(self._view_id, None)

    @calldata_type(VTK_INT)
    def _timer_fired(self, interactor, event, timer):
        if timer != self._timer:
            return
        self._rendered(None, event)
        view = find_proxy(self._view_id, "views")
        if view and view.GetSession().GetPendingProgress():
            render_later([self._view_id])  # ParaView handles timers during computations, too
        elif view:
            view.StillRender()
