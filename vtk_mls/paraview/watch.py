"""Pipelines of ParaView's GUI, watched for what the plugin adds to them.

A plugin in Python hears of nothing but what the server manager registers: filters with handles, the
widgets that show these, and displays.
"""

from __future__ import annotations

from paraview.modules.vtkRemotingCore import vtkProcessModule
from paraview.modules.vtkRemotingServerManager import vtkSMProxyManager

from vtk_mls.paraview import messages, undo
from vtk_mls.paraview.display_look import show_as_input
from vtk_mls.paraview.handle_widget import HandleWidget
from vtk_mls.paraview.observers import Observers
from vtk_mls.paraview.panel_widgets import PanelWidgets
from vtk_mls.paraview.server_manager import elements, proxies, proxies_of, selected_source

_WITH_HANDLES = ("MLSDeform", "MLSDisplacementField", "MLSControlPoints")
_is_watching = False
_watched = {}  # by the ids of sessions: the Observers of each


def start():
    """Watch the pipelines of all sessions of ParaView's GUI, unless somebody does already."""
    global _is_watching
    if _is_watching or vtkSMProxyManager.GetProxyManager() is None:
        return
    _is_watching = True
    modules = vtkProcessModule.GetProcessModule()
    sessions = modules.NewSessionIterator()
    sessions.UnRegister(None)
    sessions.InitTraversal()
    while not sessions.IsDoneWithTraversal():
        _watch(sessions.GetCurrentSessionId())
        sessions.GoToNextItem()

    # Plugins of PV_PLUGIN_PATH are loaded before there is a session.
    modules.AddObserver("ConnectionCreatedEvent", _connected)
    modules.AddObserver("ConnectionClosedEvent", _closed)


def _connected(modules, event):
    _watch(modules.GetEventCallDataSessionId())


def _closed(modules, event):
    observers = _watched.pop(modules.GetEventCallDataSessionId(), None)
    if observers:
        observers.end()


def _watch(number):
    """Watch what the proxy manager of a session registers, if this is ParaView's GUI."""
    if vtkSMProxyManager.GetProxyManager().GetUndoStackBuilder() is None:
        return  # only the GUI has undo; pvpython's manager outlives Python and would call it still
    messages.start()
    session = vtkProcessModule.GetProcessModule().GetSession(number)
    manager = vtkSMProxyManager.GetProxyManager().GetSessionProxyManager(session)
    pipelines = {}  # by the ids of their proxies, so that none is kept alive
    views, displays = set(), set()  # ids
    observers = _watched[number] = Observers()
    panel_widgets = PanelWidgets(manager, _WITH_HANDLES, observers)

    def edited(is_held):
        for handles in list(pipelines.values()):
            handles.show_pending(is_held)

    def widgets_changed(shown, event):
        sources = {each.GetGlobalID(): each for each in proxies(manager, "sources")}
        for widget in proxies_of(shown):
            panel_widgets.follow(widget)
            for number, handles in pipelines.items():
                if number in sources and _shows(widget, sources[number]):
                    handles.take(widget)
                elif number in sources and _shows_cut(widget, sources[number]):
                    handles.take_cut(widget)

    def displays_changed(shown, event):
        every = {each.GetGlobalID(): each for each in proxies_of(shown)}
        for number in every.keys() - displays:
            displays.add(number)
            if not manager.GetInLoadXMLState() and not undo.is_busy():
                show_as_input(every[number], every.values())

    def changed(manager, event):
        here = {each.GetGlobalID(): each for each in proxies(manager, "sources")}
        for number in pipelines.keys() - here.keys():
            pipelines.pop(number).end()
        for number in here.keys() - pipelines.keys():
            if here[number].GetXMLName() in _WITH_HANDLES:
                selected = selected_source(manager)
                pipelines[number] = HandleWidget(here[number], edited, selected)
        for view in proxies(manager, "views"):
            shown = view.GetProperty("HiddenRepresentations")
            if shown and view.GetGlobalID() not in views:
                views.add(view.GetGlobalID())
                observers.add(shown, "ModifiedEvent", widgets_changed)
                shown = view.GetProperty("Representations")
                displays.update(each.GetGlobalID() for each in proxies_of(shown))
                observers.add(shown, "ModifiedEvent", displays_changed)

    for event in ("RegisterEvent", "UnRegisterEvent"):
        observers.add(manager, event, changed)
    changed(manager, None)


def _shows(widget, proxy):
    """Whether a representation is the widget of a proxy's handles: ParaView keeps them alike."""
    if widget.GetXMLName() != "PolyLineWidgetRepresentation":
        return False
    positions = elements(widget.GetProperty("HandlePositions"))
    lists = (proxy.GetProperty(name) for name in ("RestPoints", "DeformedPoints"))
    return any(positions == elements(each) for each in lists)


def _shows_cut(widget, proxy):
    """Whether a representation is the widget of a proxy's cut plane."""
    return "ImplicitPlane" in widget.GetXMLName() and all(
        proxy.GetProperty(f"Cut{name}")
        and elements(widget.GetProperty(name)) == elements(proxy.GetProperty(f"Cut{name}"))
        for name in ("Origin", "Normal")
    )
