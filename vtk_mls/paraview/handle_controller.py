"""Behavior of handles in ParaView's GUI beyond that of ParaView's own widgets.

ParaView's handle widget edits one list of positions. Until Apply, an edit is the pending
("unchecked") value of a server-manager property, and each change, by a drag, a table or a button,
is an event of the property. Here these events cause pending edits of the other lists, so that
Apply, Reset, Undo, trace and states treat all lists as one.
"""

import time

import numpy as np

from vtk_mls.paraview import handle_lists, panels, undo
from vtk_mls.paraview.handle_drags import DeferredDrags, SurfaceMouse
from vtk_mls.paraview.handle_lists import LISTS, OTHER_LIST
from vtk_mls.paraview.handle_markers import HandleMarkers, remove_line
from vtk_mls.paraview.live import MAP_PROPERTIES, SWITCH, Live
from vtk_mls.paraview.optional_inputs import OptionalInputs
from vtk_mls.paraview.server_manager import (
    EDITED,
    Observers,
    find_proxy,
    is_pending,
    is_remote,
    pending_value,
    render_later,
    views_of,
)

_BEFORE_PLANES = 0.6  # priority of handles, where the mouse also hits the plane of a cut, at 0.5
_TABLE_EDIT_SECONDS = 1.0  # at most, between the two events of a click on *+* or *-*


class HandleController:
    """The handles of a proxy with lists of handles.

    `edited` is called with whether the mouse drags, after edits that may change a deformation: the
    handles may be the control points of another filter. `selected` is the selection before the
    proxy was made, a proxy of a source or an output port, or None.
    """

    def __init__(self, proxy, edited, selected):
        self._proxy_id, self._edited = proxy.GetGlobalID(), edited
        self._is_busy = self._is_dragging = False
        self._last_count_change = None  # time, name of the other list, rows before of all lists
        self._widget_ids, self._surface_mice = set(), []
        self._markers, self._observers = HandleMarkers(), Observers()
        self._live = Live(proxy) if proxy.GetProperty(SWITCH) else None
        handle_lists.place(proxy, selected)
        deformed = proxy.GetProperty("DeformedPoints")
        if pending_value(proxy, "Mode") == "points" and deformed.GetNumberOfElements() == 0:
            deformed.Copy(proxy.GetProperty("RestPoints"))  # to be dragged
        proxy.UpdateVTKObjects()
        self._store_rows(proxy)
        self._undo_state = handle_lists.pending_lists(proxy)
        callback = self._edit_callback(self._list_edited)
        self._deferred_drags = DeferredDrags(proxy, dict.fromkeys(OTHER_LIST, callback))
        for name in OTHER_LIST:
            self._observe(proxy, name, callback)
        self._observe(proxy, "Weights", self._edit_callback(lambda weights, proxy: None))
        self._observe(proxy, "NumberHandles", self._edit_callback(self._numbering_edited))
        for name in handle_lists.LAYOUT_PROPERTIES:
            self._observe(proxy, name, self._edit_callback(self._layout_edited))
        if self._live:
            for name in {SWITCH, *MAP_PROPERTIES} - {*LISTS}:
                self._observe(proxy, name, lambda *_: self._edited(self._is_dragging))
        self._observe(proxy, "CutType", self._cut_type_edited)
        OptionalInputs(proxy, self._observers)
        self._observe(proxy, panels.RESTORED, self._edit_callback(self._restored))

    def show_pending(self, is_dragging):
        """Draw the result of pending edits in the views."""
        if self._live:
            self._live.edited(is_dragging)

    def add_widget(self, widget):
        """Extend a widget that shows these handles."""
        if not self.observe_drags(widget):
            return
        vtk_widget = widget.GetClientSideObject().GetWidget()
        vtk_widget.SetPriority(_BEFORE_PLANES)
        if vtk_widget.GetEnabled():  # it keeps the priority with which it was enabled
            vtk_widget.Off()
            vtk_widget.On()
        self._observers.follow_widget(vtk_widget, remove_line)
        if not is_remote(widget):  # otherwise the server draws
            markers = self._markers.add_widget(widget)
            self._surface_mice.append(SurfaceMouse(widget, markers, self._add_handle))
            self._deferred_drags.add_widget(widget)
            self._update_markers(find_proxy(self._proxy_id))

    def restore(self, lists):
        """Make these lists the pending ones, for Undo or Redo."""
        proxy = find_proxy(self._proxy_id)
        if proxy is None:
            return
        self._is_busy = True
        try:
            for name, values in zip(LISTS, lists):
                proxy.GetProperty(name).SetUncheckedElements(values, len(values))
            self._store_rows(proxy)
            self._undo_state = handle_lists.pending_lists(proxy)
            self._update_markers(proxy)
        finally:
            self._is_busy = False
        self._edited(False)

    def end(self):
        """Stop, since the proxy is deleted."""
        for part in (self._observers, self._deferred_drags, *self._surface_mice, self._markers):
            part.end()
        if self._live:
            self._live.end()

    def _observe(self, proxy, name, callback):
        if proxy.GetProperty(name):
            self._observers.add(proxy.GetProperty(name), EDITED, callback)

    def _edit_callback(self, method):
        """An observer that calls `method(property, proxy)`, except for events that this causes."""

        def callback(prop, event):
            if self._is_busy:
                return
            proxy = prop.GetParent()
            self._is_busy = True
            try:
                method(prop, proxy)
                self._update_undo(proxy)
                self._update_markers(proxy)
            finally:
                self._is_busy = False
            self._edited(self._is_dragging)

        return callback

    def observe_drags(self, widget):
        """Observe the drags of a widget of handles or the cut; False if it is observed already."""
        if widget.GetGlobalID() in self._widget_ids:
            return False
        self._widget_ids.add(widget.GetGlobalID())

        def drag_starts(widget, event):
            self._is_dragging = True

        def drag_ends(widget, event):
            self._is_dragging = False
            proxy = find_proxy(self._proxy_id)
            if proxy:
                self._update_undo(proxy)
            self._edited(False)

        self._observers.add(widget, "StartInteractionEvent", drag_starts)
        self._observers.add(widget, "EndInteractionEvent", drag_ends)
        return True

    def _add_handle(self, position):
        """Add a handle to the list that the mouse edits; the other lists follow."""
        proxy = find_proxy(self._proxy_id)
        if proxy:
            dragged = proxy.GetProperty(handle_lists.DRAGGED[pending_value(proxy, "Drag")])
            rows = np.vstack([handle_lists.pending_rows(dragged), position])
            handle_lists.set_pending_rows(dragged, rows)
            _render(proxy)

    def _store_rows(self, proxy):
        self._rows = {
            name: handle_lists.pending_rows(proxy.GetProperty(name)) for name in OTHER_LIST
        }

    def _update_markers(self, proxy):
        rest, deformed = (handle_lists.pending_rows(proxy.GetProperty(name)) for name in LISTS[:2])
        self._markers.update(rest, deformed, bool(pending_value(proxy, "NumberHandles")))

    def _update_undo(self, proxy):
        """Add an edit to the undo stack when a drag has ended; remove all when all is applied."""
        if self._is_dragging:
            return
        before, self._undo_state = self._undo_state, handle_lists.pending_lists(proxy)
        if not any(is_pending(proxy.GetProperty(name)) for name in LISTS):
            undo.forget(self)
        elif before != self._undo_state:
            undo.add("Edit Handles", self, before, self._undo_state)

    def _cut_type_edited(self, prop, event):
        """ParaView 5.11 shows the plane without rendering it."""
        render_later([view.GetGlobalID() for view in views_of(prop.GetParent())])

    def _numbering_edited(self, prop, proxy):
        self._update_markers(proxy)
        _render(proxy)

    def _restored(self, restored, proxy):
        if restored.GetElement(0):
            handle_lists.place(proxy)
            self._store_rows(proxy)

    def _layout_edited(self, prop, proxy):
        """Replace the handles by those of a lattice or a file."""
        layout = handle_lists.pending_layout(proxy) if is_pending(prop) else None
        if layout is None:
            return
        for name, rows in zip(LISTS, layout):
            handle_lists.set_pending_rows(proxy.GetProperty(name), rows)
        self._store_rows(proxy)
        _render(proxy)

    def _list_edited(self, prop, proxy):
        """Update the other lists after an edit of one, or after Apply or Reset.

        Handles are added and removed in all lists; a handle moves along with its rest position.
        """
        name = prop.GetXMLName()
        other = OTHER_LIST[name]
        before, after = self._rows[name], handle_lists.pending_rows(prop)
        self._rows[name] = after
        if not is_pending(prop):
            # the opposite edit restored this list, but not yet the other list
            has_other_length = len(after) != len(self._rows[other])
            if not (has_other_length and handle_lists.is_one_edit(before, after)):
                return
        if len(before) != len(after):
            names = other, "Weights"
            rows = {name: handle_lists.pending_rows(proxy.GetProperty(name)) for name in names}
            self._last_count_change = time.monotonic(), other, before, rows
            self._insert_or_remove(proxy, before, after, other)
        elif self._complete_table_edit(proxy, after, other):
            return
        elif name == "RestPoints" and len(before) == len(self._rows[other]):
            self._rows[other] = self._rows[other] + (after - before)
            handle_lists.set_pending_rows(proxy.GetProperty(other), self._rows[other])

    def _complete_table_edit(self, proxy, after, other):
        """Handle the second event of *+* or *-*; False for other events.

        The table first appends a row or removes the last one, then moves rows to their new places.
        The other lists can follow only after that.
        """
        if self._last_count_change is None or self._is_dragging:
            return False
        changed_at, expected, before, other_rows = self._last_count_change
        if expected != other or time.monotonic() - changed_at > _TABLE_EDIT_SECONDS:
            return False
        if not handle_lists.is_one_edit(before, after):
            return False
        for name, rows in other_rows.items():
            handle_lists.set_pending_rows(proxy.GetProperty(name), rows)
        self._insert_or_remove(proxy, before, after, other)
        self._undo_state = handle_lists.pending_lists(proxy)
        undo.amend(self, self._undo_state)
        return True

    def _insert_or_remove(self, proxy, before, after, other):
        """Change the other lists as one list changed from `before` to `after`."""
        if len(after) > len(before):
            first = handle_lists.first_difference(before, after)
            new = after[first : first + len(after) - len(before)]
            indices = np.full(len(new), first)
            edits = {
                other: lambda rows: np.insert(rows, indices, new, axis=0),
                "Weights": lambda rows: np.insert(rows, indices, 1.0, axis=0),
            }
        else:
            mask = handle_lists.remaining_rows(before, after)
            edits = dict.fromkeys((other, "Weights"), lambda rows: rows[mask])
        for name, edit in edits.items():
            rows = handle_lists.pending_rows(proxy.GetProperty(name))
            is_unused = name == "Weights" and len(rows) == 0  # all weights are 1
            if len(rows) == len(before) and not is_unused:
                handle_lists.set_pending_rows(proxy.GetProperty(name), edit(rows))
        self._store_rows(proxy)


def _render(proxy):
    for view in views_of(proxy):
        view.StillRender()
