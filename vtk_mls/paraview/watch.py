"""Watches the pipelines of ParaView's GUI for filters with handles, their widgets, and displays.

A plugin in Python learns of these only through the events of the server manager.
"""

import logging
import sys

from paraview.modules.vtkRemotingCore import vtkProcessModule
from paraview.modules.vtkRemotingServerManager import vtkSMProxyManager
from vtkmodules.vtkCommonCore import vtkOutputWindow

from vtk_mls.base import messages
from vtk_mls.paraview import handle_lists, panels, undo
from vtk_mls.paraview.displays import copied_settings, copy_settings_of_input
from vtk_mls.paraview.handle_controller import HandleController
from vtk_mls.paraview.handle_markers import actors_of
from vtk_mls.paraview.server_manager import (
    EDITED,
    Observers,
    pending_values,
    proxies_in,
    registered_proxies,
    selected_source,
)

_WITH_HANDLES = ("MLSDeform", "MLSDisplacementField", "MLSControlPoints")
_FIRST_HANDLES = ("RestPoints", "DeformedPoints", "Bounds")
_is_watching = _are_traces_extended = False
_sessions = {}  # _Session by the ids of ParaView's sessions


def start():
    """Watch all sessions of ParaView's GUI, unless this was called before."""
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
    modules.AddObserver("ConnectionCreatedEvent", _session_created)
    modules.AddObserver("ConnectionClosedEvent", _session_closed)


def _session_created(modules, event):
    _watch(modules.GetEventCallDataSessionId())


def _session_closed(modules, event):
    session = _sessions.pop(modules.GetEventCallDataSessionId(), None)
    if session:
        session.end()


def _watch(session_id):
    """Watch a session if this process is ParaView's GUI."""
    if vtkSMProxyManager.GetProxyManager().GetUndoStackBuilder() is None:
        return  # only the GUI has undo; pvpython's manager would call observers after Python's end
    if not any(isinstance(handler, _OutputMessages) for handler in messages.LOG.handlers):
        messages.LOG.addHandler(_OutputMessages())
        messages.LOG.propagate = False
    session = vtkProcessModule.GetProcessModule().GetSession(session_id)
    manager = vtkSMProxyManager.GetProxyManager().GetSessionProxyManager(session)
    _sessions[session_id] = _Session(manager)


class _Session:
    """The pipelines and views of a session, by its vtkSMSessionProxyManager."""

    def __init__(self, manager):
        self._manager, self._observers = manager, Observers()
        self._controllers = {}  # HandleController by the ids of proxies
        self._source_ids, self._view_ids, self._display_ids = set(), set(), set()
        self._panel_widgets = PanelWidgets(manager, self._observers)
        for event in ("RegisterEvent", "UnRegisterEvent"):
            self._observers.add(manager, event, self._proxies_changed)
        self._proxies_changed(manager, None)

    def end(self):
        self._observers.end()

    def _sources(self):
        sources = registered_proxies(self._manager, "sources")
        return {source.GetGlobalID(): source for source in sources}

    def _edited(self, is_dragging):
        for controller in list(self._controllers.values()):
            controller.show_pending(is_dragging)

    def _proxies_changed(self, manager, event):
        _extend_traces()
        sources = self._sources()
        for deleted in self._controllers.keys() - sources.keys():
            self._controllers.pop(deleted).end()
        for new in sources.keys() - self._source_ids:
            if sources[new].GetXMLName() in _WITH_HANDLES:
                selected = selected_source(manager)
                self._controllers[new] = HandleController(sources[new], self._edited, selected)
            if restored := sources[new].GetProperty(panels.RESTORED):
                restored.SetElement(0, 0)
                self._observers.add(restored, EDITED, self._restored)
        self._source_ids = sources.keys()
        for view in registered_proxies(manager, "views"):
            widgets = view.GetProperty("HiddenRepresentations")
            if widgets and view.GetGlobalID() not in self._view_ids:
                self._view_ids.add(view.GetGlobalID())
                self._observers.add(widgets, "ModifiedEvent", self._widgets_changed)
                displays = view.GetProperty("Representations")
                self._display_ids.update(display.GetGlobalID() for display in proxies_in(displays))
                self._observers.add(displays, "ModifiedEvent", self._displays_changed)

    def _restored(self, restored, event):
        """After Restore Defaults, choose arrays as in a new filter, not as ParaView guesses."""
        if restored.GetElement(0):
            restored.SetElement(0, 0)
            for prop in filter(None, map(restored.GetParent().GetProperty, panels.ARRAYS)):
                prop.ResetToXMLDefaults()
                handle_lists.show_empty_list(prop)

    def _widgets_changed(self, widgets, event):
        sources = self._sources()
        for widget in proxies_in(widgets):
            self._panel_widgets.add(widget)
            for source_id, controller in self._controllers.items():
                if source_id in sources and _shows_handles(widget, sources[source_id]):
                    controller.add_widget(widget)
                elif source_id in sources and _shows_cut(widget, sources[source_id]):
                    controller.observe_drags(widget)

    def _displays_changed(self, prop, event):
        displays = {display.GetGlobalID(): display for display in proxies_in(prop)}
        for new in displays.keys() - self._display_ids:
            self._display_ids.add(new)
            if not self._manager.GetInLoadXMLState() and not undo.is_running():
                copy_settings_of_input(displays[new], displays.values())


class _OutputMessages(logging.Handler):
    """Announcements as lines of Output Messages, whose window does not open for them.

    ParaView's sys.stderr would show them as errors.
    """

    def emit(self, record):
        line = f"{self.format(record)}\n"
        vtkOutputWindow.GetInstance().DisplayText(line)
        if sys.__stderr__ is not None:  # the terminal
            sys.__stderr__.write(line)
            sys.__stderr__.flush()


def _shows_handles(widget, proxy):
    """Whether a representation is the widget of a proxy's handles: it has the same positions."""
    if widget.GetXMLName() != "PolyLineWidgetRepresentation":
        return False
    positions = pending_values(widget.GetProperty("HandlePositions"))
    lists = (proxy.GetProperty(name) for name in ("RestPoints", "DeformedPoints"))
    return any(positions == pending_values(prop) for prop in lists)


def _shows_cut(widget, proxy):
    """Whether a representation is the widget of a proxy's cut plane."""
    return "ImplicitPlane" in widget.GetXMLName() and all(
        proxy.GetProperty(f"Cut{name}")
        and pending_values(widget.GetProperty(name))
        == pending_values(proxy.GetProperty(f"Cut{name}"))
        for name in ("Origin", "Normal")
    )


def _extend_traces():
    """Add what the plugin sets for the user where a trace creates a proxy, from the next trace on.

    *Only User-Modified Properties*, the default of *Start Trace*, leaves out what no panel has set:
    the first handles, and the settings that a display has from that of the input.
    """
    global _are_traces_extended
    smtrace = sys.modules.get("paraview.smtrace")  # imported when a trace starts
    if smtrace is None or _are_traces_extended:
        return
    _are_traces_extended = True

    class Accessor(smtrace.RealProxyAccessor):
        def trace_ctor(self, ctor, filter, *arguments, **keywords):
            proxy, usual = self.get_object().SMProxy, filter.should_trace_in_create
            has_handles = proxy.GetXMLName() in _WITH_HANDLES
            names = _FIRST_HANDLES if has_handles else copied_settings(proxy)

            def should_trace(accessor):
                prop = accessor.get_object()
                is_set = prop.GetXMLName() in names and (has_handles or not prop.IsValueDefault())
                return is_set or usual(accessor)

            filter.should_trace_in_create = should_trace
            return super().trace_ctor(ctor, filter, *arguments, **keywords)

    smtrace.RealProxyAccessor.register_create_callback(Accessor)


class PanelWidgets:
    """The widgets that ParaView's views show for the selected source: they come back with it.

    When another source is selected, ParaView hides the widgets of a panel twice. It restores the
    visibility that it saved the second time, so the widgets would stay hidden. Here the visibility
    is restored at once, unless the user hid it. This draws nothing: the widget is disabled then.
    """

    def __init__(self, manager, observers):
        self._manager, self._observers = manager, observers
        self._owners = {}  # ids of sources, or None, by the ids of representations
        self._is_restoring = False

    def add(self, widget):
        """Restore the visibility of a widget, a proxy of a vtk3DWidgetRepresentation."""
        visibility = widget.GetProperty("Visibility")
        representation = visibility.GetParent()
        if representation.GetGlobalID() in self._owners:
            return
        self._owners[representation.GetGlobalID()] = None
        self._observers.add(visibility, "ModifiedEvent", self._visibility_changed)
        self._visibility_changed(visibility, None)
        if "ImplicitPlane" in representation.GetXMLName():
            plane = widget.GetClientSideObject().GetWidget()
            self._observers.follow_widget(plane, self._plane_enabled)

    def _plane_enabled(self, plane, event):
        """Draw the edges of a plane as lines: tubes would hide the gap of a cut."""
        if self._selected_id() is None:
            return
        for actor in actors_of(plane.GetRepresentation()):
            algorithm = actor.GetMapper().GetInputAlgorithm()
            if algorithm.IsA("vtkTubeFilter"):
                actor.GetMapper().SetInputConnection(algorithm.GetInputConnection(0, 0))

    def _visibility_changed(self, visibility, event):
        if self._is_restoring:
            return
        representation_id = visibility.GetParent().GetGlobalID()
        selected_id = self._selected_id()
        if visibility.GetElement(0):
            self._owners[representation_id] = selected_id
        elif self._owners[representation_id] not in (None, selected_id):
            self._is_restoring = True
            visibility.SetElement(0, 1)
            self._is_restoring = False

    def _selected_id(self):
        """Id of the selected source; None if its widgets are not ours to restore."""
        source = selected_source(self._manager)
        if source and source.IsA("vtkSMOutputPort"):
            source = source.GetSourceProxy()
        return source.GetGlobalID() if source and source.GetXMLName() in _WITH_HANDLES else None
