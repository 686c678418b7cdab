"""The widgets of a filter's panel come back when the filter is selected again.

When another source is selected, ParaView hides a panel's widgets twice: as the source is left, and
with the panel. It restores what it has seen at the second time, so they would stay away for good.
Here the visibility is set back at once, unless the user has hidden the widget himself; nothing is
drawn by that, for the widget is disabled meanwhile.
"""

from __future__ import annotations

from vtk_mls.paraview.server_manager import selected_source
from vtk_mls.paraview.thin_plane import draw_thin


class PanelWidgets:
    """The widgets that ParaView's views show for the selected source.

    Parameters
    ----------
    manager : vtkSMSessionProxyManager
    sources : sequence of str
        XML names of the proxies whose widgets come back.
    observers : Observers
        Of the session.
    """

    def __init__(self, manager, sources, observers):
        self._manager, self._sources, self._observers = manager, sources, observers
        self._owners = {}  # ids of sources, by the ids of the shapes they show; None: others
        self._is_restoring = False

    def follow(self, widget):
        """Follow the visibility of a widget, a proxy of a vtk3DWidgetRepresentation."""
        visibility = widget.GetProperty("Visibility")
        shape = visibility.GetParent()  # what the widget lets its user see
        if shape.GetGlobalID() not in self._owners:
            self._owners[shape.GetGlobalID()] = None
            self._observers.add(visibility, "ModifiedEvent", self._visibility_changed)
            self._visibility_changed(visibility, None)
            if "ImplicitPlane" in shape.GetXMLName():
                plane = widget.GetClientSideObject().GetWidget()
                self._observers.add(plane, "EnableEvent", self._plane_shown)
                if plane.GetEnabled():
                    self._plane_shown(plane, None)

    def _plane_shown(self, plane, event):  # only then it tells its actors
        if self._selected() is not None:
            draw_thin(plane.GetRepresentation())

    def _visibility_changed(self, visibility, event):
        shape = visibility.GetParent()
        number = shape.GetGlobalID()
        if self._is_restoring:
            return
        selected = self._selected()
        if visibility.GetElement(0):
            self._owners[number] = selected
        elif self._owners[number] not in (None, selected):
            self._is_restoring = True
            visibility.SetElement(0, 1)
            self._is_restoring = False

    def _selected(self):
        """Id of the selected source; None if its widgets need no help."""
        source = selected_source(self._manager)
        if source and source.IsA("vtkSMOutputPort"):
            source = source.GetSourceProxy()
        is_ours = source and source.GetXMLName() in self._sources
        return source.GetGlobalID() if is_ours else None
