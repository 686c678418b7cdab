"""Access to ParaView's server manager: proxies, and properties with edits that wait for Apply."""

# The first Python wrapper of a VTK object has the most derived class that is imported by then:
# import those of views, representations and widgets first.
import paraview.modules.vtkRemotingViews  # noqa: F401
import vtkmodules.vtkInteractionWidgets  # noqa: F401
from paraview.modules.vtkRemotingServerManager import vtkSMProxyIterator, vtkSMProxyManager
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet

EDITED = "UncheckedPropertyModifiedEvent"  # of a property whose pending values were changed


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
    values = [prop.GetElement(i) for i in range(prop.GetNumberOfElements())]
    return pending_values(prop) != values


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
