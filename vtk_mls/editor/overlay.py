"""Texts and a rubber band above the data, and names beside handles."""

from __future__ import annotations

import textwrap

import numpy as np
import vtkmodules.vtkRenderingFreeType  # noqa: F401  renders texts
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D, vtkTextActor
from vtkmodules.vtkRenderingLabel import vtkLabelPlacementMapper, vtkPointSetToLabelHierarchy

from vtk_mls.editor import polydata
from vtk_mls.editor.polydata import configured
from vtk_mls.vtk import arrays

_SOFT, _AMBER, _GREEN = (0.74, 0.80, 0.87), (1, 0.78, 0.35), (0.5, 0.95, 0.65)
_PANEL, _MARGIN, _SIZE = (0.04, 0.05, 0.08), 14, 14
_NAME_COLOR, _NAME_SIZE = (0.95, 0.95, 0.8), 13


class Overlay:
    """The texts in a window: legend of keys, hint, status line and message.

    `keys` are lines (str, str) of the legend, which is hidden at first; `hint` (str, str) is shown
    without it, in narrow windows the second part only.
    """

    def __init__(self, renderer, keys, hint):
        names, texts = zip(*keys)
        self.renderer, self._has_texts, self.message, self.status = renderer, True, "", ""
        self._lift, self._hint_share, self._home = 0, 1.0, renderer
        self.set_hint(hint)
        self._keys = text_actor(_AMBER), text_actor(_SOFT)
        self._keys[0].SetInput("\n".join(names))
        self._keys[1].SetInput("\n".join(texts))
        for actor in self._keys:
            actor.GetTextProperty().SetLineSpacing(1.15)
        self._panel, self._band = _shape(_PANEL), _shape(_GREEN)
        rectangle = np.arange(4)[None]
        self._panel.GetMapper().GetInput().SetPolys(polydata.cells(rectangle))
        self._panel.GetProperty().SetOpacity(0.62)
        self._band.GetMapper().GetInput().SetLines(polydata.cells(np.c_[rectangle, 0]))
        self._band.GetProperty().SetLineWidth(1.5)
        self._hint, self._status = text_actor(_SOFT), text_actor(_SOFT)
        self._message = text_actor(_AMBER, _SIZE + 3)
        for actor in (*self._keys, self._hint):
            actor.GetTextProperty().SetVerticalJustificationToTop()
        font = self._message.GetTextProperty()
        configured(
            font, BackgroundColor=_PANEL, BackgroundOpacity=0.75
        ).SetJustificationToCentered()
        texts = self._hint, self._status, self._message
        self._props = self._panel, *self._keys, *texts, self._band
        for prop in self._props:
            renderer.AddViewProp(prop)
        self.set_band(None)
        self.set_keys_visible(False)

    def set_hint(self, hint):
        """Show another hint (str, str)."""
        self._long_hint, self._short_hint = "   ".join(hint), hint[1]

    def move_to(self, renderer=None, lift=0, hint_share=1.0):
        """Draw the texts in another renderer, or the first one, with a gap of pixels below.

        The hint takes at most a share of the width.
        """
        renderer = self._home if renderer is None else renderer
        for prop in self._props:
            if self.renderer.HasViewProp(prop):
                self.renderer.RemoveViewProp(prop)
                renderer.AddViewProp(prop)
        self.renderer, self._lift, self._hint_share = renderer, lift, hint_share

    @property
    def shows_keys(self):
        """Whether the legend is visible."""
        return bool(self._panel.GetVisibility())

    def set_keys_visible(self, is_visible):
        """Show or hide the legend; without it, the hint is visible."""
        for actor in (self._panel, *self._keys):
            actor.SetVisibility(is_visible)
        self._hint.SetVisibility(self._has_texts and not is_visible)

    def set_texts_visible(self, are_visible):
        """Show or hide status and hint, and hide the legend."""
        self._has_texts = are_visible
        self._status.SetVisibility(are_visible)
        self.set_keys_visible(False)

    def set_message_visible(self, is_visible):
        """Show or hide the message."""
        self._message.SetVisibility(is_visible)

    def say(self, sentence):
        """Set the message; empty for none."""
        self.message = sentence
        width = max(self.renderer.GetSize()[0] // 10, 30)  # characters
        self._message.SetInput("\n".join(textwrap.wrap(sentence, width)))

    def set_status(self, text):
        """Set the status line."""
        self.status = text
        self._status.SetInput(text)

    def set_band(self, corners):
        """Show a rectangle between two corners in pixels, or none for None."""
        self._band.SetVisibility(corners is not None)
        if corners is not None:
            _set_corners(self._band, *corners)

    def lay_out(self):
        """Place everything for the size of the window."""
        width, height = self.renderer.GetSize()
        (first, tall), (second, _) = (size_of(actor, self.renderer) for actor in self._keys)
        top = height - _MARGIN
        self._keys[0].SetPosition(2 * _MARGIN, top - _MARGIN)
        self._keys[1].SetPosition(2 * _MARGIN + first + _MARGIN, top - _MARGIN)
        low = (_MARGIN, top - tall - 2 * _MARGIN)
        _set_corners(self._panel, low, (first + second + 4 * _MARGIN, top))
        self._hint.SetPosition(_MARGIN, top)
        hint_width = 0.6 * _SIZE * len(self._long_hint)  # an estimate, as it is not drawn yet
        is_short = hint_width > self._hint_share * width
        self._hint.SetInput(self._short_hint if is_short else self._long_hint)
        self._status.SetPosition(_MARGIN, _MARGIN + self._lift)
        self._message.SetPosition(width // 2, 3 * _MARGIN + _SIZE + self._lift)


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


def size_of(actor, renderer):
    """Width and height of a vtkTextActor in pixels."""
    size = [0.0, 0.0]
    actor.GetSize(renderer, size)
    return size


def _shape(color):
    mapper = configured(vtkPolyDataMapper2D(), InputData=vtkPolyData())
    actor = configured(vtkActor2D(), Mapper=mapper, Pickable=False)
    actor.GetProperty().SetColor(color)
    return actor


def _set_corners(actor, low, high):
    (left, bottom), (right, top) = low, high
    corners = [(left, bottom, 0), (right, bottom, 0), (right, top, 0), (left, top, 0)]
    actor.GetMapper().GetInput().SetPoints(polydata.points(corners))
