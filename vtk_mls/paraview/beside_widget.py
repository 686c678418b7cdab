"""Props of our own in ParaView's views, shown wherever and whenever a widget's handles are.

They are no part of the pipeline: neither states nor Undo nor pickers know of them.
"""

from __future__ import annotations

from vtk_mls.paraview.observers import Observers


class BesideWidget:
    """Props that are shown together with a widget.

    Parameters
    ----------
    widget : proxy of a vtk3DWidgetRepresentation
    props : sequence of vtkProp
    frame : callable
        Called with the widget's representation at the beginning of each frame.
    """

    def __init__(self, widget, props, frame):
        self._props, self._frame, self._renderer = props, frame, None
        self._observers, self._frames = Observers(), Observers()
        drawn = widget.GetClientSideObject().GetWidget()
        for prop in props:
            prop.PickableOff()
        self._observers.add(drawn, "EnableEvent", self._shown)
        self._observers.add(drawn, "DisableEvent", self._hidden)
        if drawn.GetEnabled():
            self._shown(drawn, None)

    def end(self):
        """Go from the view for good."""
        self._observers.end()
        self.hide()

    def _hidden(self, drawn, event):
        self.hide()

    def _shown(self, drawn, event):
        self.hide()
        representation = drawn.GetRepresentation()
        renderer = self._renderer = representation.GetRenderer()
        for prop in self._props:
            renderer.AddViewProp(prop)

        def frame(renderer, event):
            self._frame(representation)

        # what draws it is ours; it is picked all the same, for that its renderer is not asked
        renderer.RemoveViewProp(representation)
        self._frames.add(renderer, "StartEvent", frame)

    def hide(self):
        """Go from the view, until the widget is shown again."""
        if self._renderer is None:
            return
        renderer, self._renderer = self._renderer, None
        self._frames.end()
        for prop in self._props:
            renderer.RemoveViewProp(prop)
