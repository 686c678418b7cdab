"""Texts and a rubber band over the picture."""

from __future__ import annotations

import vtkmodules.vtkRenderingFreeType  # noqa: F401  draws texts
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import (
    vtkActor2D,
    vtkPolyDataMapper2D,
    vtkTextActor,
)

_WHITE, _SOFT, _AMBER, _GREEN = (1, 1, 1), (0.74, 0.80, 0.87), (1, 0.78, 0.35), (0.5, 0.95, 0.65)
_PANEL, _MARGIN, _SIZE = (0.04, 0.05, 0.08), 14, 14


class Overlay:
    """What is written over the picture of a renderer: the keys, how it is, and what was said.

    Parameters
    ----------
    renderer : vtkRenderer
    keys : list of (str, str)
        Lines of the legend, which is not there at first.
    hint : (str, str)
        What is there while the legend is not, the second part alone where there is no room.
    """

    def __init__(self, renderer, keys, hint):
        names, texts = zip(*keys)
        self._renderer, self._hints, self._has_texts = renderer, ("   ".join(hint), hint[1]), True
        self._keys = _text(_AMBER), _text(_SOFT)
        self._keys[0].SetInput("\n".join(names))
        self._keys[1].SetInput("\n".join(texts))
        for actor in self._keys:
            actor.GetTextProperty().SetVerticalJustificationToTop()
            actor.GetTextProperty().SetLineSpacing(1.15)
        self._panel, self._band = _rectangle(_PANEL, 0.62), _outline(_GREEN)
        self._hint, self._status, self._message = (
            *(_text(_SOFT), _text(_SOFT)),
            _text(_AMBER, _SIZE + 3),
        )
        self._hint.GetTextProperty().SetVerticalJustificationToTop()
        self._message.GetTextProperty().SetBackgroundColor(_PANEL)
        self._message.GetTextProperty().SetBackgroundOpacity(0.75)
        self._message.GetTextProperty().SetJustificationToCentered()
        texts = self._hint, self._status, self._message
        for actor in (self._panel, *self._keys, *texts, self._band):
            renderer.AddViewProp(actor)
        self.set_band(None)
        self.set_keys_visible(False)

    @property
    def message(self):
        """What is said."""
        return self._message.GetInput() or ""

    @property
    def status(self):
        """How it is."""
        return self._status.GetInput() or ""

    @property
    def shows_keys(self):
        """Whether the legend of keys is there."""
        return bool(self._panel.GetVisibility())

    def set_keys_visible(self, is_visible):
        """Show or hide the legend of keys."""
        for actor in (self._panel, *self._keys):
            actor.SetVisibility(is_visible)
        self._hint.SetVisibility(self._has_texts and not is_visible)

    def set_texts_visible(self, are_visible):
        """Show or hide how it is and the hint; the legend is hidden."""
        self._has_texts = are_visible
        self._status.SetVisibility(are_visible)
        self.set_keys_visible(False)

    def set_message_visible(self, is_visible):
        """Show or hide what is said."""
        self._message.SetVisibility(is_visible)

    def say(self, sentence):
        """Show a sentence, or none for an empty one."""
        self._message.SetInput(_wrapped(sentence, self._renderer.GetSize()[0] // 10))

    def set_status(self, text):
        """Show how it is."""
        self._status.SetInput(text)

    def set_band(self, corners):
        """Show a rectangle between two corners in pixels, or none for None."""
        self._band.SetVisibility(corners is not None)
        if corners is not None:
            _set_corners(self._band, *corners)

    def lay_out(self):
        """Put everything where it belongs in a window of this size."""
        width, height = self._renderer.GetSize()
        sizes = []
        for actor in self._keys:
            size = [0.0, 0.0]
            actor.GetSize(self._renderer, size)
            sizes.append(size)
        (first, tall), (second, _) = sizes
        top = height - _MARGIN
        self._keys[0].SetPosition(2 * _MARGIN, top - _MARGIN)
        self._keys[1].SetPosition(2 * _MARGIN + first + _MARGIN, top - _MARGIN)
        low = (_MARGIN, top - tall - 2 * _MARGIN)
        _set_corners(self._panel, low, (first + second + 4 * _MARGIN, top))
        self._hint.SetPosition(_MARGIN, top)
        self._hint.SetInput(self._hints[_width_of(self._hints[0]) > width])
        self._status.SetPosition(_MARGIN, _MARGIN)
        self._message.SetPosition(width // 2, 3 * _MARGIN + _SIZE)


def _text(colour, size=_SIZE):
    actor = vtkTextActor()
    actor.SetTextScaleModeToNone()
    actor.PickableOff()
    font = actor.GetTextProperty()
    font.SetFontFamilyToArial()
    font.SetFontSize(size)
    font.SetColor(colour)
    return actor


def _width_of(text):
    """Pixels that a line is wide, about: it is to be known before it is drawn."""
    return 0.6 * _SIZE * len(text)


def _wrapped(sentence, width):
    import textwrap

    return "\n".join(textwrap.wrap(sentence, max(width, 30)))


def _rectangle(colour, opacity):
    actor = _shape(colour)
    corners = vtkCellArray()
    corners.InsertNextCell(4)
    for i in range(4):
        corners.InsertCellPoint(i)
    actor.GetMapper().GetInput().SetPolys(corners)
    actor.GetProperty().SetOpacity(opacity)
    return actor


def _outline(colour):
    actor = _shape(colour)
    corners = vtkCellArray()
    corners.InsertNextCell(5)
    for i in (0, 1, 2, 3, 0):
        corners.InsertCellPoint(i)
    actor.GetMapper().GetInput().SetLines(corners)
    actor.GetProperty().SetLineWidth(1.5)
    return actor


def _shape(colour):
    polydata, mapper, actor = vtkPolyData(), vtkPolyDataMapper2D(), vtkActor2D()
    mapper.SetInputData(polydata)
    actor.SetMapper(mapper)
    actor.PickableOff()
    actor.GetProperty().SetColor(colour)
    return actor


def _set_corners(actor, low, high):
    points = vtkPoints()
    for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])):
        points.InsertNextPoint(x, y, 0)
    actor.GetMapper().GetInput().SetPoints(points)
