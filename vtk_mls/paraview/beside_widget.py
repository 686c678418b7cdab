"""Props of our own in ParaView's views, shown wherever and whenever a widget's handles are.

They are no part of the pipeline: neither states nor Undo nor pickers know of them.
"""

from __future__ import annotations


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
        self._props, self._frame, self._observed = props, frame, None
        self._widget = widget.GetClientSideObject().GetWidget()
        for prop in props:
            prop.PickableOff()
        self._widget.AddObserver("EnableEvent", self._shown)
        self._widget.AddObserver("DisableEvent", lambda widget, event: self.hide())
        if self._widget.GetEnabled():
            self._shown(self._widget, None)

    def _shown(self, widget, event):
        self.hide()
        representation = widget.GetRepresentation()
        renderer = representation.GetRenderer()
        for prop in self._props:
            renderer.AddViewProp(prop)

        def frame(renderer, event):
            self._frame(representation)

        # what draws it is ours; it is picked all the same, for that its renderer is not asked
        renderer.RemoveViewProp(representation)
        self._observed = renderer, renderer.AddObserver("StartEvent", frame)

    def hide(self):
        """Go from the view, until the widget is shown again."""
        if self._observed is None:
            return
        renderer, tag = self._observed
        self._observed = None
        renderer.RemoveObserver(tag)
        for prop in self._props:
            renderer.RemoveViewProp(prop)
