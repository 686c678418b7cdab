"""The legend of the colors of the change of volume."""

from __future__ import annotations

import itertools

import numpy as np
import vtkmodules.vtkRenderingFreeType  # noqa: F401  renders texts
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D, vtkTextMapper

from vtk_mls.editor import polydata
from vtk_mls.editor.polydata import configured
from vtk_mls.rendering.volume_colors import FOLDED, MAX_DOUBLINGS, colors_of

# Sizes in pixels.
_WIDTH, _HEIGHT, _MARGIN, _GAP, _FONT_SIZE = 14, 180, 18, 10, 13
_BANDS = 60
_TITLE, _FOLD = "volume \N{MULTIPLICATION SIGN}", "folds"
_LABELS = (2, "4"), (1, "2"), (0, "1"), (-1, "1/2"), (-2, "1/4")  # doublings, text
_TEXT_COLOR = (0.74, 0.80, 0.87)


class VolumeLegend:
    """A bar of the colors with numbers, at the right side of a vtkRenderer; hidden at first."""

    def __init__(self, renderer):
        self._renderer, self._bar = renderer, vtkPolyData()
        mapper = configured(vtkPolyDataMapper2D(), InputData=self._bar)
        mapper.SetScalarModeToUseCellData()
        bar = configured(vtkActor2D(), Mapper=mapper)
        self._texts = [_text(text) for text in (*(text for _, text in _LABELS), _FOLD, _TITLE)]
        self._actors = [bar, *self._texts]
        for actor in self._actors:
            actor.PickableOff()
            renderer.AddViewProp(actor)
        doublings = np.linspace(-MAX_DOUBLINGS, MAX_DOUBLINGS, _BANDS)
        colors = [FOLDED, *colors_of(2.0**-doublings)]
        self._bar.SetPolys(polydata.cells(np.arange(4 * (_BANDS + 1)).reshape(-1, 4)))
        self._bar.GetCellData().SetScalars(polydata.colors(255 * np.array(colors)))
        self.set_visible(False)

    def set_visible(self, is_visible):
        """Show or hide the legend."""
        for actor in self._actors:
            actor.SetVisibility(is_visible)

    def lay_out(self):
        """Place the legend for the size of the window."""
        width, height = self._renderer.GetSize()
        right, low = width - _MARGIN, (height - _HEIGHT) / 2
        heights = low + np.linspace(0, _HEIGHT, _BANDS + 1)
        bands = [(low - _GAP - _WIDTH, low - _GAP), *itertools.pairwise(heights)]
        left = right - _WIDTH
        corners = [
            corner
            for bottom, top in bands
            for corner in ((left, bottom, 0), (right, bottom, 0), (right, top, 0), (left, top, 0))
        ]
        self._bar.SetPoints(polydata.points(corners))
        middle = low + _HEIGHT / 2
        rise = _HEIGHT / (2 * MAX_DOUBLINGS)
        levels = [middle + rise * doublings for doublings, _ in _LABELS]
        levels += [low - _GAP - _WIDTH / 2, low + _HEIGHT + _GAP + _FONT_SIZE / 2]
        for text, level in zip(self._texts, levels):
            text.SetPosition(left - _GAP / 2, level)
        self._texts[-1].SetPosition(right, levels[-1])


def _text(text):
    mapper = configured(vtkTextMapper(), Input=text)
    font = configured(mapper.GetTextProperty(), FontSize=_FONT_SIZE, Color=_TEXT_COLOR)
    font.SetJustificationToRight()
    font.SetVerticalJustificationToCentered()
    return configured(vtkActor2D(), Mapper=mapper)
