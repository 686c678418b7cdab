"""Texts and a rubber band above the data, and names beside handles."""

import textwrap

import numpy as np
import vtkmodules.vtkRenderingFreeType  # noqa: F401  renders texts
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D, vtkTextActor
from vtkmodules.vtkRenderingLabel import vtkLabelPlacementMapper, vtkPointSetToLabelHierarchy

from vtk_mls.editor import polydata
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

_SOFT, _AMBER, _GREEN = (0.74, 0.80, 0.87), (1, 0.78, 0.35), (0.5, 0.95, 0.65)
_PANEL, _MARGIN, _SIZE = (0.04, 0.05, 0.08), 14, 14
_NAME_COLOR, _NAME_SIZE = (0.95, 0.95, 0.8), 13


class Overlay:
    """The texts in a window: a `hint`, the status line with a `note`, a message; and a rubber band.

    The renderer is a layer above the data.
    """

    def __init__(self, renderer, hint):
        self.renderer, self.message, self.status, self.note = renderer, "", "", ""
        mapper = configured(vtkPolyDataMapper2D(), InputData=vtkPolyData())
        self._band = configured(vtkActor2D(), Mapper=mapper, Pickable=False)
        mapper.GetInput().SetLines(polydata.cells(np.array([(0, 1, 2, 3, 0)])))
        configured(self._band.GetProperty(), Color=_GREEN, LineWidth=1.5)
        self._hint, self._status = text_actor(_SOFT), text_actor(_SOFT)
        self._message = text_actor(_AMBER, _SIZE + 3)
        self._hint.GetTextProperty().SetVerticalJustificationToTop()
        font = self._message.GetTextProperty()
        configured(font, BackgroundColor=_PANEL, BackgroundOpacity=0.75)
        font.SetJustificationToCentered()
        for prop in (self._hint, self._status, self._message, self._band):
            renderer.AddViewProp(prop)
        self.set_hint(hint)
        self.set_band(None)

    def set_hint(self, hint):
        """Show another hint."""
        self._hint.SetInput(hint)

    def set_texts_visible(self, are_visible):
        """Show or hide status and hint."""
        self._status.SetVisibility(are_visible)
        self._hint.SetVisibility(are_visible)

    def say(self, sentence):
        """Set the message; empty for none."""
        self.message = sentence
        width = max(self.renderer.GetSize()[0] // 10, 30)  # characters
        self._message.SetInput("\n".join(textwrap.wrap(sentence, width)))

    def set_status(self, text):
        """Set the status line; the note is drawn at its end only, as the page has another place."""
        self.status = text
        self._status.SetInput(f"{text}   {self.note}")

    def set_band(self, corners):
        """Show a rectangle between two corners in pixels, or none for None."""
        self._band.SetVisibility(corners is not None)
        if corners is not None:
            (left, low), (right, high) = corners
            places = [(left, low, 0), (right, low, 0), (right, high, 0), (left, high, 0)]
            self._band.GetMapper().GetInput().SetPoints(polydata.points(places))

    def lay_out(self):
        """Place the texts for the size of the window."""
        width, height = self.renderer.GetSize()
        self._hint.SetPosition(_MARGIN, height - _MARGIN)
        self._status.SetPosition(_MARGIN, _MARGIN)
        self._message.SetPosition(width // 2, 3 * _MARGIN + _SIZE)


class Names:
    """Names beside points of a renderer; those that would overlap another are left out."""

    def __init__(self, renderer):
        self._points, self._actor = vtkPolyData(), vtkActor2D()
        labels = configured(vtkPointSetToLabelHierarchy(), InputData=self._points)
        configured(labels, LabelArrayName="name", PriorityArrayName="priority")
        font = configured(labels.GetTextProperty(), FontSize=_NAME_SIZE, Color=_NAME_COLOR)
        configured(font, Bold=True, Shadow=True).SetFontFamilyToArial()
        font.SetJustificationToLeft()
        mapper = configured(vtkLabelPlacementMapper(), InputConnection=labels.GetOutputPort())
        configured(self._actor, Mapper=mapper, Pickable=False)
        renderer.AddViewProp(self._actor)

    def show(self, positions, names, priorities, are_visible):
        """Draw names at positions (n, 3): of overlapping ones that with the highest priority."""
        self._points.Initialize()
        self._points.SetPoints(polydata.points(positions))
        arrays.add_texts(self._points.GetPointData(), "name", [f"  {name}" for name in names])
        arrays.add(self._points.GetPointData(), "priority", np.array(priorities, float))
        self._actor.SetVisibility(are_visible and len(names) > 0)


def text_actor(color, size=_SIZE):
    """A vtkTextActor of a color, 0 to 1, and a font size in pixels."""
    actor = configured(vtkTextActor(), Pickable=False)
    configured(actor.GetTextProperty(), FontSize=size, Color=color)
    return actor
