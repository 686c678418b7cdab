"""Arrows in ParaView's views, from where handles rest to where they are dragged.

They are drawn beside a widget's handles, while these are shown, and are no part of the pipeline:
neither states nor Undo, pickers nor the camera know of them.
"""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls.filters.handle_arrows import fill_arrows

_COLOR = (1.0, 0.67, 0.0)


class Arrows:
    """The arrows of one set of handles, in every view where a widget shows them."""

    def __init__(self):
        self._polydata, self._actors = vtkPolyData(), []

    def follow(self, widget):
        """Be shown wherever and whenever a widget's handles are.

        Parameters
        ----------
        widget : proxy of a vtk3DWidgetRepresentation
        """
        mapper, actor = vtkPolyDataMapper(), vtkActor()
        mapper.SetInputData(self._polydata)
        mapper.ScalarVisibilityOff()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(_COLOR)
        actor.PickableOff()
        actor.UseBoundsOff()
        self._actors.append(actor)

        def shown(drawn, event):
            drawn.GetRepresentation().GetRenderer().AddViewProp(actor)

        def hidden(drawn, event):
            _take_away(actor)

        drawn = widget.GetClientSideObject().GetWidget()
        drawn.AddObserver("EnableEvent", shown)
        drawn.AddObserver("DisableEvent", hidden)
        if drawn.GetEnabled():
            shown(drawn, None)

    def point(self, rest, deformed):
        """Point from p to q, pending edits included: (n, 3) each, world coordinates."""
        self._polydata.Initialize()
        if len(rest) == len(deformed):
            fill_arrows(self._polydata, rest, deformed)

    def end(self):
        """Go from all views for good."""
        for actor in self._actors:
            _take_away(actor)
            actor.SetMapper(None)


def _take_away(actor):
    """Remove an actor from the renderers that it is in, which are kept alive by nobody here."""
    for number in reversed(range(actor.GetNumberOfConsumers())):
        actor.GetConsumer(number).RemoveViewProp(actor)
