"""ParaView's server manager: proxies, properties with edits that wait for Apply, views, events."""

# The first Python wrapper of a VTK object has the most derived class that is imported by then:
# import those of views, representations and widgets first.
import paraview.modules.vtkRemotingViews  # noqa: F401
import vtkmodules.vtkInteractionWidgets  # noqa: F401
from paraview.modules.vtkRemotingServerManager import vtkSMProxyIterator, vtkSMProxyManager
from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import VTK_INT, vtkWeakReference
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet

EDITED = "UncheckedPropertyModifiedEvent"  # of a property whose pending values were changed
_DELAY = 100  # milliseconds; ParaView's own rendering is done by then
_late_renders = {}  # _LateRender by the ids of views


def registered_proxies(manager, group):
    """The proxies registered in a group."""
    iterator = vtkSMProxyIterator()
    iterator.SetSessionProxyManager(manager)
    iterator.SetModeToOneGroup()
    iterator.Begin(group)
    while not iterator.IsAtEnd():
        yield iterator.GetProxy()
        iterator.Next()


def views_of(proxy):
    """All views of the session of a proxy."""
    return registered_proxies(proxy.GetSessionProxyManager(), "views")


def find_proxy(proxy_id, group="sources"):
    """The proxy of the active session with this global id; None if it was deleted."""
    manager = vtkSMProxyManager.GetProxyManager().GetActiveSessionProxyManager()
    proxies = registered_proxies(manager, group)
    return next((proxy for proxy in proxies if proxy.GetGlobalID() == proxy_id), None)


def proxies_in(prop):
    """The proxies in a proxy property."""
    return [prop.GetProxy(index) for index in range(prop.GetNumberOfProxies())]


def pending_values(prop):
    """The elements of a property, pending edits included."""
    return [prop.GetUncheckedElement(i) for i in range(prop.GetNumberOfUncheckedElements())]


def pending_value(proxy, name, default=None):
    """The first element of a property, pending edits included; the default without it."""
    prop = proxy.GetProperty(name)
    return prop.GetUncheckedElement(0) if prop else default


def is_pending(prop):
    """Whether a property has an edit that is not applied."""
    return pending_values(prop) != [prop.GetElement(i) for i in range(prop.GetNumberOfElements())]


def is_remote(proxy):
    """Whether another process has the data and draws them."""
    return proxy.GetSession().IsA("vtkSMSessionClient")


def input_of(proxy):
    """Source proxy and output port that a filter or a display shows; None without an input."""
    connected = proxy.GetProperty("Input")
    if not connected or not connected.GetNumberOfProxies():
        return None
    return connected.GetProxy(0), connected.GetOutputPortForConnection(0)


def input_data(proxy):
    """The input of a filter or a display, as it was last updated."""
    source, port = input_of(proxy)
    return source.GetClientSideObject().GetOutputDataObject(port)


def blocks_of(data):
    """The datasets of a composite dataset, or the dataset itself."""
    if not isinstance(data, vtkCompositeDataSet):
        return [data]
    return [block for _, block in indexed_blocks(data)]


def indexed_blocks(data):
    """The flat indices and the datasets of a composite dataset."""
    iterator = data.NewIterator()
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        yield iterator.GetCurrentFlatIndex(), iterator.GetCurrentDataObject()
        iterator.GoToNextItem()


def selected_source(manager):
    """The selected proxy of a source or of one of its outputs; None without a selection."""
    selection = manager.GetSelectionModel("ActiveSources")
    return selection.GetCurrentProxy() if selection else None


def render_later(view_ids):
    """Render views after the current events, unless they are rendered before."""
    for view_id in view_ids:
        view = find_proxy(view_id, "views")
        client = view.GetClientSideObject() if view else None
        if view_id not in _late_renders and client and client.GetInteractor():
            _late_renders[view_id] = _LateRender(view_id, client)


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
        _late_renders.pop(self._view_id, None)

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


class Observers:
    """Observers of VTK objects, removed together. They do not keep the objects alive.

    VTK keeps the Python function of an observer alive, but Python's garbage collector does not see
    VTK's references. If only a VTK object holds the function, the collector may clear it while VTK
    still calls it, and ParaView crashes. Therefore each observer has a Python object as its owner.
    """

    def __init__(self):
        self._observers = []

    def add(self, observed, event, callback, priority=0.0):
        """Call `callback(observed, event)` at each event; returns VTK's tag of the observer."""
        reference = vtkWeakReference()
        reference.Set(observed)
        tag = observed.AddObserver(event, callback, priority)
        self._observers.append((reference, tag, callback))
        return tag

    def follow_widget(self, widget, enabled, disabled=None):
        """Call functions when a vtkAbstractWidget is enabled or disabled, and now if it is enabled.

        A representation has its renderer and its actors only while the widget is enabled.
        """
        self.add(widget, "EnableEvent", enabled)
        if disabled:
            self.add(widget, "DisableEvent", disabled)
        if widget.GetEnabled():
            enabled(widget, None)

    def end(self):
        """Remove all observers."""
        observers, self._observers = self._observers, []
        for reference, tag, _ in observers:
            observed = reference.Get()
            if observed is not None:
                observed.RemoveObserver(tag)
