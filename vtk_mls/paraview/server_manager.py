"""What ParaView's server manager knows: proxies, and their properties with edits that wait."""

from __future__ import annotations

# An object that Python meets before its class stays one of a base class: import those of views,
# their representations and widgets first.
import paraview.modules.vtkRemotingViews  # noqa: F401
import vtkmodules.vtkInteractionWidgets  # noqa: F401
from paraview.modules.vtkRemotingServerManager import vtkSMProxyIterator, vtkSMProxyManager
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet


def proxies(manager, group):
    """The proxies registered in a group."""
    iterator = vtkSMProxyIterator()
    iterator.SetSessionProxyManager(manager)
    iterator.SetModeToOneGroup()
    iterator.Begin(group)
    while not iterator.IsAtEnd():
        yield iterator.GetProxy()
        iterator.Next()


def proxies_of(changed):
    """The proxies that a property has."""
    return [changed.GetProxy(number) for number in range(changed.GetNumberOfProxies())]


def find(number, group="sources"):
    """The proxy of the active session with this id, if it is still there."""
    manager = vtkSMProxyManager.GetProxyManager().GetActiveSessionProxyManager()
    found = (each for each in proxies(manager, group) if each.GetGlobalID() == number)
    return next(found, None)


def elements(changed):
    """The pending elements of a property."""
    return [changed.GetUncheckedElement(i) for i in range(changed.GetNumberOfUncheckedElements())]


def is_pending(changed):
    """Whether a property has an edit that is not applied."""
    count = changed.GetNumberOfUncheckedElements()
    if count != changed.GetNumberOfElements():
        return True
    return any(changed.GetUncheckedElement(i) != changed.GetElement(i) for i in range(count))


def is_remote(proxy):
    """Whether data and what draws them are not in this process."""
    return proxy.GetSession().IsA("vtkSMSessionClient")


def input_of(proxy):
    """A filter's input, as it was last updated."""
    source = proxy.GetProperty("Input")
    client = source.GetProxy(0).GetClientSideObject()
    return client.GetOutputDataObject(source.GetOutputPortForConnection(0))


def blocks_of(data):
    """The datasets of which data consist."""
    if not isinstance(data, vtkCompositeDataSet):
        return [data]
    blocks, iterator = [], data.NewIterator()
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        blocks.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return blocks


def selected_source(manager):
    """What is selected in the pipeline: proxy of a source or of one of its outputs, or None."""
    selection = manager.GetSelectionModel("ActiveSources")
    return selection.GetCurrentProxy() if selection else None
