"""Changes of optional inputs that ParaView does not survive."""

from vtkmodules.vtkCommonCore import vtkOutputWindow

from vtk_mls.paraview.server_manager import EDITED, find_proxy, proxies_in

_NAMES = ("ControlPoints", "DeformedControlPoints", "Cuts", "Mask", "Reference")
_BEFORE_PARAVIEW, _AFTER_PARAVIEW = 1.0, -1.0  # priorities


class OptionalInputs:
    """The optional inputs of a proxy.

    The output of the proxy cannot be its own input: it is disconnected again.

    ParaView's pipeline browser removes the link of an input wrongly if another input is further
    down, such as the Transform of a surface, and crashes when that one changes. So
    DeformedControlPoints is disconnected before ControlPoints changes, and connected again
    afterwards. Without ControlPoints it stays disconnected.
    """

    def __init__(self, proxy, observers):
        self._proxy, self._connections = proxy.GetGlobalID(), []
        for name in _NAMES:
            if prop := proxy.GetProperty(name):
                observers.add(prop, "ModifiedEvent", self._refuse_own_output, _BEFORE_PARAVIEW)
        if cuts := proxy.GetProperty("Cuts"):
            observers.add(cuts, EDITED, self._name_cuts)
            manager = proxy.GetSessionProxyManager()
            observers.add(manager, "UnRegisterEvent", self._name_cuts)  # the end of a new name
            self._name_cuts(None, None)
        points, self._moved = map(proxy.GetProperty, _NAMES[:2])
        if points:
            observers.add(points, "ModifiedEvent", self._disconnect, _BEFORE_PARAVIEW)
            observers.add(points, "ModifiedEvent", self._connect, _AFTER_PARAVIEW)
            observers.add(proxy, "UpdateEvent", lambda *_: self._connections.clear())

    def _refuse_own_output(self, prop, event):
        if any(self._is_downstream(source) for source in proxies_in(prop)):
            prop.RemoveAllProxies()
            vtkOutputWindow.GetInstance().DisplayWarningText(
                f"{prop.GetXMLLabel()} cannot be the output of this filter: it was disconnected.\n"
            )

    def _is_downstream(self, source):
        producers = map(source.GetProducerProxy, range(source.GetNumberOfProducers()))
        return source.GetGlobalID() == self._proxy or any(map(self._is_downstream, producers))

    def _name_cuts(self, observed, event):
        """Name the pending Cuts in the panel."""
        if proxy := find_proxy(self._proxy):
            manager = proxy.GetSessionProxyManager()
            cuts = [source for source, _ in _pending(proxy.GetProperty("Cuts")) if source]
            names = [manager.GetProxyName("sources", source) or "?" for source in cuts]
            proxy.GetProperty("ConnectedCuts").SetElement(0, ", ".join(names) or "none")

    def _disconnect(self, points, event):
        if connections := _pending(self._moved):
            self._connections = connections
            self._moved.RemoveAllProxies()

    def _connect(self, points, event):
        if points.GetNumberOfProxies() == 0:
            return  # Python removes an input before it adds another
        for source, port in self._connections:
            self._moved.AddInputConnection(source, port)
        self._connections.clear()


def _pending(prop):
    """Proxies and ports of an input, those that wait for an Apply included."""
    count = range(prop.GetNumberOfUncheckedProxies())
    return [(prop.GetUncheckedProxy(i), prop.GetUncheckedOutputPortForConnection(i)) for i in count]
