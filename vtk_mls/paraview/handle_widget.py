"""Handles under the mouse: what the plugin adds to ParaView's own widgets in its GUI.

ParaView's handle widget edits one list of positions. While an edit waits for Apply it is the
pending ("unchecked") value of a server-manager property, and whoever changes it, a drag, a table or
a button, an event of the property tells so. Here these events are answered by pending edits of the
lists beside, so that Apply, Reset, Undo, trace and states work on all lists as on one.
"""

from __future__ import annotations

import time

import numpy as np

from vtk_mls.paraview import first_handles, handle_rows, late_render, live, pending_filter, undo
from vtk_mls.paraview.handle_marks import Marks, forget_line
from vtk_mls.paraview.many_handles import ManyHandles
from vtk_mls.paraview.observers import Observers
from vtk_mls.paraview.server_manager import elements, find, is_pending, proxies
from vtk_mls.paraview.surface_click import SurfaceClick
from vtk_mls.paraview.surface_drag import SurfaceDrag

_SOURCE = "MLSControlPoints"
_EDITED = "UncheckedPropertyModifiedEvent"
_NUMBERS = "NumberHandles"
_CUT = "CutType"
_AT_ONCE = 1.0  # seconds: what a click on *+* or *-* takes at most


class HandleWidget:
    """What is to know of a proxy's handles between two events."""

    def __init__(self, proxy, edited, selected=None):
        self._busy = self._is_held = False
        # when handles were last added to or removed from which list, and what was before
        self._recounted = None
        self._number, self._widgets = proxy.GetGlobalID(), set()
        self._marks, self._observers = Marks(), Observers()
        self._on_surface = []  # what the mouse does there
        self._edited = edited  # tells all pipelines, for handles may be another's control points
        self._live = live.Live(proxy) if proxy.GetProperty(live.SWITCH) else None
        first_handles.lay(proxy, selected)
        if proxy.GetXMLName() == _SOURCE:
            self._begin(proxy)
        self._deformed = handle_rows.pending(proxy.GetProperty("DeformedPoints"))
        self._rest = handle_rows.pending(proxy.GetProperty("RestPoints"))
        self._settled = handle_rows.lists(proxy)
        dragged = {
            "DeformedPoints": self._answer(self._deformed_edited),
            "RestPoints": self._answer(self._rest_edited),
        }
        self._many = ManyHandles(proxy, dragged)
        for name, answer in dragged.items():
            self._observers.add(proxy.GetProperty(name), _EDITED, answer)
        for name, answer in (
            ("Weights", lambda weights, proxy: None),
            (_NUMBERS, self._numbers_edited),
            *((name, self._laid) for name in handle_rows.LAYING),
        ):
            if proxy.GetProperty(name):
                self._observers.add(proxy.GetProperty(name), _EDITED, self._answer(answer))
        if self._live:
            for name in {live.SWITCH, *pending_filter.EDITED} - {*handle_rows.LISTS}:
                self._observers.add(proxy.GetProperty(name), _EDITED, self._map_edited)
        if proxy.GetProperty(_CUT):
            self._observers.add(proxy.GetProperty(_CUT), _EDITED, self._cut_chosen)

    def _cut_chosen(self, changed, event):
        """ParaView 5.11 shows the plane, and may not draw it."""
        views = proxies(changed.GetParent().GetSessionProxyManager(), "views")
        late_render.ask([view.GetGlobalID() for view in views])

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
            marks = self._marks.follow(widget)
            self._on_surface.append(SurfaceDrag(widget, marks))
            self._on_surface.append(SurfaceClick(widget, marks, self._add_handle))
            self._many.take(widget)
            self._mark(find(self._number))
        self._listen(widget)

    def take_cut(self, widget):
        """Take over a widget that shows the cut."""
        if widget.GetGlobalID() not in self._widgets:
            self._widgets.add(widget.GetGlobalID())
            self._listen(widget)

    def _add_handle(self, position):
        """Add a handle to the list that the mouse edits; the other lists follow."""
        proxy = find(self._number)
        if proxy:
            edited = proxy.GetProperty(handle_rows.DRAGGED[elements(proxy.GetProperty("Drag"))[0]])
            handle_rows.set_pending(edited, np.vstack([handle_rows.pending(edited), position]))
            _render(proxy)

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

        self._observers.add(widget, "StartInteractionEvent", held)
        self._observers.add(widget, "EndInteractionEvent", let_go)

    def restore(self, lists):
        """Make these lists the pending ones: Undo or Redo asks for it."""
        proxy = find(self._number)
        if proxy is None:
            return
        self._busy = True
        try:
            for name, values in zip(handle_rows.LISTS, lists):
                proxy.GetProperty(name).SetUncheckedElements(values, len(values))
            self._remember(proxy)
            self._settled = handle_rows.lists(proxy)
            self._mark(proxy)
        finally:
            self._busy = False
        self._edited(False)

    def end(self):
        """The proxy is gone."""
        self._observers.end()
        self._many.end()
        for each in self._on_surface:
            each.end()
        self._marks.end()
        if self._live:
            self._live.end()

    def _mark(self, proxy):
        """Let the views show what is pending."""
        self._marks.point(
            *(handle_rows.pending(proxy.GetProperty(name)) for name in handle_rows.LISTS[:2])
        )
        self._marks.number(bool(proxy.GetProperty(_NUMBERS).GetUncheckedElement(0)))

    def _numbers_edited(self, numbers, proxy):
        self._mark(proxy)
        _render(proxy)

    def _settle(self, proxy):
        """Tell Undo what an edit has changed, at the end of a drag, or that all is applied."""
        if self._is_held:
            return
        before, self._settled = self._settled, handle_rows.lists(proxy)
        if not any(is_pending(proxy.GetProperty(name)) for name in handle_rows.LISTS):
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
        before, self._deformed = self._deformed, handle_rows.pending(deformed)
        if not is_pending(deformed) and not self._is_one_back(before, self._deformed, self._rest):
            return
        if len(before) != len(self._deformed):
            self._count_changed(proxy, before, self._deformed, "RestPoints")
        else:
            self._correct("RestPoints", proxy, self._deformed)

    def _rest_edited(self, rest, proxy):
        """A rest position was moved, added or removed: the handle goes along."""
        before, self._rest = self._rest, handle_rows.pending(rest)
        if not is_pending(rest) and not self._is_one_back(before, self._rest, self._deformed):
            return
        if len(before) != len(self._rest):
            self._count_changed(proxy, before, self._rest, "DeformedPoints")
        elif self._correct("DeformedPoints", proxy, self._rest):
            return
        elif len(before) == len(self._deformed):
            self._deformed = self._deformed + (self._rest - before)
            handle_rows.set_pending(proxy.GetProperty("DeformedPoints"), self._deformed)

    @staticmethod
    def _is_one_back(before, after, other):
        """Whether the last edit of a list was taken back by its opposite, and the other waits."""
        return len(after) != len(other) and handle_rows.is_one_edit(before, after)

    def _count_changed(self, proxy, before, after, other):
        """Add or remove in the lists beside what was added to or removed from one."""
        beside = {name: handle_rows.pending(proxy.GetProperty(name)) for name in (other, "Weights")}
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
        if not handle_rows.is_one_edit(before, after):
            return False
        for name, rows in beside.items():
            handle_rows.set_pending(proxy.GetProperty(name), rows)
        self._insert_or_remove(proxy, before, after, other)
        undo.amend(self, handle_rows.lists(proxy))
        self._settled = handle_rows.lists(proxy)
        return True

    def _insert_or_remove(self, proxy, before, after, other):
        if len(after) > len(before):
            first = handle_rows.first_difference(before, after)
            new = after[first : first + len(after) - len(before)]
            indices = np.full(len(new), first)
            edits = {
                other: lambda rows: np.insert(rows, indices, new, axis=0),
                "Weights": lambda rows: np.insert(rows, indices, 1.0, axis=0),
            }
        else:
            kept = handle_rows.kept(before, after)
            edits = dict.fromkeys((other, "Weights"), lambda rows: rows[kept])
        for name, edit in edits.items():
            rows = handle_rows.pending(proxy.GetProperty(name))
            is_unused = name == "Weights" and len(rows) == 0  # all handles count alike
            if len(rows) == len(before) and not is_unused:
                handle_rows.set_pending(proxy.GetProperty(name), edit(rows))
        self._remember(proxy)

    def _laid(self, changed, proxy):
        """Lay the handles anew, if an edit asks for that."""
        found = handle_rows.layout(proxy) if is_pending(changed) else None
        if found is None:
            return
        for name, rows in zip(handle_rows.LISTS, found):
            handle_rows.set_pending(proxy.GetProperty(name), rows)
        self._remember(proxy)
        _render(proxy)

    def _remember(self, proxy):
        self._deformed = handle_rows.pending(proxy.GetProperty("DeformedPoints"))
        self._rest = handle_rows.pending(proxy.GetProperty("RestPoints"))


def _render(proxy):
    """Draw all views anew."""
    for view in proxies(proxy.GetSessionProxyManager(), "views"):
        view.StillRender()
