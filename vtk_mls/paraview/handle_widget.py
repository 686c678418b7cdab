"""Handles under the mouse: what the plugin adds to ParaView's own widgets in its GUI.

ParaView's handle widget edits one list of positions. While an edit waits for Apply it is the
pending ("unchecked") value of a server-manager property, and whoever changes it, a drag, a table or
a button, an event of the property tells so. Here these events are answered by pending edits of the
lists beside, so that Apply, Reset, Undo, trace and states work on all lists as on one.
"""

from __future__ import annotations

import time
from contextlib import suppress

import numpy as np
from paraview.modules.vtkRemotingCore import vtkProcessModule
from paraview.modules.vtkRemotingServerManager import vtkSMProxyManager

from vtk_mls.files import control_point_files
from vtk_mls.filters.control_points import lattice
from vtk_mls.paraview import live, messages, pending_filter, undo
from vtk_mls.paraview.handle_marks import Marks, forget_line
from vtk_mls.paraview.server_manager import elements, find, is_pending, proxies, proxies_of
from vtk_mls.paraview.surface_drag import SurfaceDrag

_FILTERS = ("MLSDeform", "MLSDisplacementField")
_SOURCE = "MLSControlPoints"
_EDITED = "UncheckedPropertyModifiedEvent"
_LISTS = ("RestPoints", "DeformedPoints", "Weights")
_FILES = ("FileName", "DeformedFileName", "Space")
_NUMBERS = "NumberHandles"
_LAYING = ("Mode", "LatticeDimensions", "Bounds", *_FILES)
# Of a display, beside the representation.
_LOOK = (
    *("ColorArrayName", "LookupTable", "MapScalars", "InterpolateScalarsBeforeMapping"),
    *("UseSeparateColorMap", "ScalarOpacityFunction", "UseTransfer2D", "TransferFunction2D"),
    *("UseSeparateOpacityArray", "OpacityArrayName", "Opacity", "AmbientColor", "DiffuseColor"),
    *("EdgeColor", "LineWidth", "PointSize", "Interpolation", "Specular", "Shade", "BlendMode"),
    *("InterpolationType", "VolumeRenderingMode", "ScalarOpacityUnitDistance"),
    *("IsosurfaceValues", "Slice", "SliceMode"),
)
_AT_ONCE = 1.0  # seconds: what a click on *+* or *-* takes at most
_watching = False


def start():
    """Watch the pipelines of all sessions of ParaView's GUI, unless somebody does already."""
    global _watching
    if _watching or vtkSMProxyManager.GetProxyManager() is None:
        return
    _watching = True
    modules = vtkProcessModule.GetProcessModule()
    sessions = modules.NewSessionIterator()
    sessions.UnRegister(None)
    sessions.InitTraversal()
    while not sessions.IsDoneWithTraversal():
        _watch(sessions.GetCurrentSession())
        sessions.GoToNextItem()

    # Plugins of PV_PLUGIN_PATH are loaded before there is a session.
    def connected(modules, event):
        _watch(modules.GetSession(modules.GetEventCallDataSessionId()))

    modules.AddObserver("ConnectionCreatedEvent", connected)


def _watch(session):
    """Watch what a session's proxy manager registers, if this is ParaView's GUI."""
    if vtkSMProxyManager.GetProxyManager().GetUndoStackBuilder() is None:
        return  # only the GUI has undo; pvpython's manager outlives Python and would call it still
    messages.start()
    manager = vtkSMProxyManager.GetProxyManager().GetSessionProxyManager(session)
    pipelines = {}  # by the ids of their proxies, so that none is kept alive
    views, displays = set(), set()  # ids

    def edited(is_held):
        for handles in list(pipelines.values()):
            handles.show_pending(is_held)

    def widgets_changed(shown, event):
        sources = {each.GetGlobalID(): each for each in proxies(manager, "sources")}
        for widget in proxies_of(shown):
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
                _show_as_input(every[number], every.values())

    def changed(manager, event):
        here = {each.GetGlobalID(): each for each in proxies(manager, "sources")}
        for number in pipelines.keys() - here.keys():
            pipelines.pop(number).end()
        for number in here.keys() - pipelines.keys():
            if here[number].GetXMLName() in (*_FILTERS, _SOURCE):
                pipelines[number] = _Handles(here[number], edited)
        for view in proxies(manager, "views"):
            shown = view.GetProperty("HiddenRepresentations")
            if shown and view.GetGlobalID() not in views:
                views.add(view.GetGlobalID())
                shown.AddObserver("ModifiedEvent", widgets_changed)
                shown = view.GetProperty("Representations")
                displays.update(each.GetGlobalID() for each in proxies_of(shown))
                shown.AddObserver("ModifiedEvent", displays_changed)

    manager.AddObserver("RegisterEvent", changed)
    manager.AddObserver("UnRegisterEvent", changed)
    changed(manager, None)


class _Handles:
    """What is to know of a proxy's handles between two events."""

    def __init__(self, proxy, edited):
        self._busy = self._is_held = False
        # when handles were last added to or removed from which list, and what was before
        self._recounted = None
        self._number, self._widgets = proxy.GetGlobalID(), set()
        self._marks = Marks()
        self._edited = edited  # tells all pipelines, for handles may be another's control points
        self._live = live.Live(proxy) if proxy.GetProperty(live.SWITCH) else None
        if proxy.GetXMLName() == _SOURCE:
            self._begin(proxy)
        self._deformed = _pending(proxy.GetProperty("DeformedPoints"))
        self._rest = _pending(proxy.GetProperty("RestPoints"))
        self._settled = _lists(proxy)
        for name, answer in (
            ("DeformedPoints", self._deformed_edited),
            ("RestPoints", self._rest_edited),
            ("Weights", lambda weights, proxy: None),
            (_NUMBERS, self._numbers_edited),
            *((name, self._laid) for name in _LAYING),
        ):
            if proxy.GetProperty(name):
                proxy.GetProperty(name).AddObserver(_EDITED, self._answer(answer))
        if self._live:
            for name in {live.SWITCH, *pending_filter.EDITED} - {*_LISTS}:
                proxy.GetProperty(name).AddObserver(_EDITED, self._map_edited)

    def _map_edited(self, changed, event):
        self._edited(self._is_held)

    def show_pending(self, is_held):
        """Draw what is pending, in the views."""
        if self._live:
            self._live.edited(is_held)

    def _answer(self, method):
        """A callback for the events of a property, unless it is we who cause them."""

        def callback(changed, event):
            if not self._busy:
                self._busy = True
                try:
                    method(changed, changed.GetParent())
                    self._settle(changed.GetParent())
                    self._mark(changed.GetParent())
                finally:
                    self._busy = False
                self._edited(self._is_held)

        return callback

    def take(self, widget):
        """Take over a widget that shows these handles."""
        if widget.GetGlobalID() in self._widgets:
            return
        self._widgets.add(widget.GetGlobalID())
        forget_line(widget)
        if not widget.GetSession().IsA("vtkSMSessionClient"):  # the server draws
            SurfaceDrag(widget, self._marks.follow(widget))
            self._mark(find(self._number))
        self._listen(widget)

    def take_cut(self, widget):
        """Take over a widget that shows the cut."""
        if widget.GetGlobalID() not in self._widgets:
            self._widgets.add(widget.GetGlobalID())
            self._listen(widget)

    def _listen(self, widget):
        """Hear when a drag of a widget's handles begins or ends."""

        def held(widget, event):
            self._is_held = True

        def let_go(widget, event):
            self._is_held = False
            proxy = find(self._number)
            if proxy:
                self._settle(proxy)
            self._edited(False)

        widget.AddObserver("StartInteractionEvent", held)
        widget.AddObserver("EndInteractionEvent", let_go)

    def restore(self, lists):
        """Make these lists the pending ones: Undo or Redo asks for it."""
        proxy = find(self._number)
        if proxy is None:
            return
        self._busy = True
        try:
            for name, values in zip(_LISTS, lists):
                proxy.GetProperty(name).SetUncheckedElements(values, len(values))
            self._remember(proxy)
            self._settled = _lists(proxy)
            self._mark(proxy)
        finally:
            self._busy = False
        self._edited(False)

    def end(self):
        """The proxy is gone."""
        self._marks.end()
        if self._live:
            self._live.end()

    def _mark(self, proxy):
        """Let the views show what is pending."""
        self._marks.point(*(_pending(proxy.GetProperty(name)) for name in _LISTS[:2]))
        self._marks.number(bool(proxy.GetProperty(_NUMBERS).GetUncheckedElement(0)))

    def _numbers_edited(self, numbers, proxy):
        self._mark(proxy)
        _render(proxy)

    def _settle(self, proxy):
        """Tell Undo what an edit has changed, at the end of a drag, or that all is applied."""
        if self._is_held:
            return
        before, self._settled = self._settled, _lists(proxy)
        if not any(is_pending(proxy.GetProperty(name)) for name in _LISTS):
            undo.forget(self)
        elif before != self._settled:
            undo.add("Edit Handles", self, before, self._settled)

    def _begin(self, proxy):
        """A source without deformed points gets them where the rest points are, to be dragged."""
        rest, deformed = proxy.GetProperty("RestPoints"), proxy.GetProperty("DeformedPoints")
        listed = proxy.GetProperty("Mode").GetElement(0) == "points"
        if listed and deformed.GetNumberOfElements() == 0:
            positions = [rest.GetElement(i) for i in range(rest.GetNumberOfElements())]
            deformed.SetElements(positions, len(positions))
            proxy.UpdateVTKObjects()

    def _deformed_edited(self, deformed, proxy):
        """A handle was dragged, added or removed, or an edit was applied or taken back."""
        before, self._deformed = self._deformed, _pending(deformed)
        if not is_pending(deformed):
            return
        if len(before) != len(self._deformed):
            self._count_changed(proxy, before, self._deformed, "RestPoints")
        else:
            self._correct("RestPoints", proxy, self._deformed)

    def _rest_edited(self, rest, proxy):
        """A rest position was moved, added or removed: the handle goes along."""
        before, self._rest = self._rest, _pending(rest)
        if not is_pending(rest):
            return
        if len(before) != len(self._rest):
            self._count_changed(proxy, before, self._rest, "DeformedPoints")
        elif self._correct("DeformedPoints", proxy, self._rest):
            return
        elif len(before) == len(self._deformed):
            self._deformed = self._deformed + (self._rest - before)
            _set_pending(proxy.GetProperty("DeformedPoints"), self._deformed)

    def _count_changed(self, proxy, before, after, other):
        """Add or remove in the lists beside what was added to or removed from one."""
        beside = {name: _pending(proxy.GetProperty(name)) for name in (other, "Weights")}
        self._recounted = time.monotonic(), other, before, beside
        self._insert_or_remove(proxy, before, after, other)

    def _correct(self, other, proxy, after):
        """Whether an edit is the second part of *+* or *-*: the table has appended a row or dropped
        the last, now it has moved the others to their positions. Then the lists beside follow.
        """
        if self._recounted is None or self._is_held:
            return False
        since, expected, before, beside = self._recounted
        if expected != other or time.monotonic() - since > _AT_ONCE:
            return False
        if not _is_one_edit(before, after):
            return False
        for name, rows in beside.items():
            _set_pending(proxy.GetProperty(name), rows)
        self._insert_or_remove(proxy, before, after, other)
        undo.amend(self, _lists(proxy))
        self._settled = _lists(proxy)
        return True

    def _insert_or_remove(self, proxy, before, after, other):
        if len(after) > len(before):
            first = _first_difference(before, after)
            new = after[first : first + len(after) - len(before)]
            indices = np.full(len(new), first)
            edits = {
                other: lambda rows: np.insert(rows, indices, new, axis=0),
                "Weights": lambda rows: np.insert(rows, indices, 1.0, axis=0),
            }
        else:
            kept = _kept(before, after)
            edits = dict.fromkeys((other, "Weights"), lambda rows: rows[kept])
        for name, edit in edits.items():
            rows = _pending(proxy.GetProperty(name))
            is_unused = name == "Weights" and len(rows) == 0  # all handles count alike
            if len(rows) == len(before) and not is_unused:
                _set_pending(proxy.GetProperty(name), edit(rows))
        self._remember(proxy)

    def _laid(self, changed, proxy):
        """Lay the handles anew, if an edit asks for that."""
        found = _layout(proxy) if is_pending(changed) else None
        if found is None:
            return
        for name, rows in zip(_LISTS, found):
            _set_pending(proxy.GetProperty(name), rows)
        self._remember(proxy)
        _render(proxy)

    def _remember(self, proxy):
        self._deformed = _pending(proxy.GetProperty("DeformedPoints"))
        self._rest = _pending(proxy.GetProperty("RestPoints"))


def _render(proxy):
    """Draw all views anew."""
    for view in proxies(proxy.GetSessionProxyManager(), "views"):
        view.StillRender()


def _show_as_input(display, others):
    """Show the output of MLSDeform as its input is shown, if it is, in the same view."""
    deform = display.GetProperty("Input").GetProxy(0) if display.GetProperty("Input") else None
    if deform is None or deform.GetXMLName() != "MLSDeform":
        return
    source = deform.GetProperty("Input")
    wanted = source.GetProxy(0), source.GetOutputPortForConnection(0)
    for other in others:
        shown = other.GetProperty("Input")
        if shown and (shown.GetProxy(0), shown.GetOutputPortForConnection(0)) == wanted:
            for name in _LOOK:
                if display.GetProperty(name) and other.GetProperty(name):
                    display.GetProperty(name).Copy(other.GetProperty(name))
            display.UpdateVTKObjects()
            if display.GetProperty("Representation") and other.GetProperty("Representation"):
                display.SetRepresentationType(other.GetProperty("Representation").GetElement(0))
            return


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


def _layout(proxy):
    """p, q and weights of the lattice or the file that pending edits ask for; None without."""
    mode = proxy.GetProperty("Mode")
    mode = mode.GetUncheckedElement(0) if mode else "lattice"
    with suppress(ValueError, OSError):  # Apply will say it, and the file may be the server's
        if mode == "file":
            named = (proxy.GetProperty(name) for name in _FILES)
            rest, deformed, weights = control_point_files.read(
                *(elements(each)[0] for each in named)
            )
            return rest, deformed, np.empty(0) if weights is None else weights
        if mode == "lattice":
            positions = lattice(elements(proxy.GetProperty("LatticeDimensions")), _bounds(proxy))
            return positions, positions, np.empty(0)
    return None


def _bounds(proxy):
    """Bounds for a lattice: the property's, or those of the input."""
    if proxy.GetProperty("Bounds"):
        return elements(proxy.GetProperty("Bounds"))
    source = proxy.GetProperty("Input")
    data = source.GetProxy(0).GetDataInformation(source.GetOutputPortForConnection(0))
    return data.GetBounds()


def _lists(proxy):
    """The pending elements of all lists."""
    return [elements(proxy.GetProperty(name)) for name in _LISTS]


def _pending(changed):
    """The pending rows of a list property: (n, columns)."""
    values = elements(changed)
    columns = 1 if changed.GetXMLName() == "Weights" else 3
    return np.reshape(values, (-1, columns)).astype(float)


def _set_pending(changed, rows):
    changed.SetUncheckedElements(np.ravel(rows).tolist(), rows.size)


def _first_difference(before, after):
    """The first row in which `after`, which is not shorter, differs from `before`."""
    differs = (before != after[: len(before)]).any(axis=1)
    return int(differs.argmax()) if differs.any() else len(before)


def _is_one_edit(before, after):
    """Whether rows were only added to `before`, all at one place, or only removed from it."""
    if len(after) < len(before):
        return np.count_nonzero(_kept(before, after)) == len(after)
    first, count = _first_difference(before, after), len(after) - len(before)
    return np.array_equal(np.delete(after, slice(first, first + count), axis=0), before)


def _kept(before, after):
    """Which rows of `before` are, in their order, those of `after`: bool."""
    kept, found = np.zeros(len(before), bool), 0
    for number, row in enumerate(before):
        if found < len(after) and (row == after[found]).all():
            kept[number] = True
            found += 1
    return kept
