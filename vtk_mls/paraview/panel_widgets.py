"""The widgets of a filter's panel come back when the filter is selected again.

When another source is selected, ParaView hides the widgets of a panel twice. It restores the
visibility that it saved the second time, so the widgets would stay hidden. Here the visibility is
restored at once, unless the user hid the widget. This draws nothing: the widget is disabled then.
"""

from vtkmodules.vtkRenderingCore import vtkPropCollection

from vtk_mls.paraview.server_manager import selected_source


class PanelWidgets:
    """The widgets that ParaView's views show for the selected source.

    `source_names` are the XML names of the proxies whose widgets come back.
    """

    def __init__(self, manager, source_names, observers):
        self._manager, self._source_names, self._observers = manager, source_names, observers
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
        is_ours = source and source.GetXMLName() in self._source_names
        return source.GetGlobalID() if is_ours else None


def actors_of(representation):
    """The actors of an enabled widget's representation."""
    actors = vtkPropCollection()
    representation.GetActors(actors)
    return [actors.GetItemAsObject(index) for index in range(actors.GetNumberOfItems())]
