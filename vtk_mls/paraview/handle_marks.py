"""How handles look in ParaView's views: who was dragged, from where, and which is selected.

ParaView's widget draws all its handles alike, each by itself, and a line through them that moves
all of them when it is dragged. Here its handles are grabbed and not drawn; what is drawn is one
actor for all.
"""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import (
    numpy_to_vtk,
    numpy_to_vtkIdTypeArray,
    vtk_to_numpy,
)
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkActor2D, vtkPolyDataMapper, vtkPropCollection
from vtkmodules.vtkRenderingLabel import vtkLabeledDataMapper

from vtk_mls.filters.handle_arrows import fill_arrows
from vtk_mls.paraview.beside_widget import BesideWidget

_DRAGGED = (1.0, 0.67, 0.0)
_SIZE, _SELECTED_SIZE = 10, 16  # pixels
_NUMBER = "Number"


class Marks:
    """The handles of one set, in every view where a widget shows them."""

    def __init__(self):
        self._arrows, self._views = vtkPolyData(), []
        self._is_dragged = np.zeros(0, bool)
        self._are_numbered = False

    def follow(self, widget):
        """Be drawn wherever and whenever a widget's handles are, and in their stead.

        Parameters
        ----------
        widget : proxy of a vtk3DWidgetRepresentation

        Returns
        -------
        sequence of vtkProp
            What is drawn.
        """
        handles = _Handles()
        arrows = _actor(self._arrows)
        arrows.GetProperty().SetColor(_DRAGGED)
        arrows.GetMapper().ScalarVisibilityOff()
        arrows.UseBoundsOff()

        def frame(representation):
            handles.update(representation, self._is_dragged, self._are_numbered)

        props = arrows, *handles.props
        self._views.append(BesideWidget(widget, props, frame))
        return props

    def point(self, rest, deformed):
        """Show what was dragged, pending edits included.

        Parameters
        ----------
        rest, deformed : (n, 3) float64, world coordinates
        """
        self._arrows.Initialize()
        if len(rest) == len(deformed):
            fill_arrows(self._arrows, rest, deformed)
            self._is_dragged = (rest != deformed).any(axis=1)

    def number(self, wanted):
        """Whether each handle has its number beside it, that of its row in the tables."""
        self._are_numbered = wanted

    def end(self):
        """Go from all views for good."""
        for view in self._views:
            view.hide()
        self._views = []


class _Handles:
    """What is drawn of the handles of a widget."""

    def __init__(self):
        self._every, self._selected, self._label = vtkPolyData(), vtkPolyData(), vtkActor2D()
        labels = vtkLabeledDataMapper()
        labels.SetInputData(self._every)
        labels.SetLabelModeToLabelFieldData()
        labels.SetFieldDataName(_NUMBER)
        labels.SetLabelFormat("  %d")
        labels.GetLabelTextProperty().ItalicOff()
        self._label.SetMapper(labels)
        self.props = (*self._spheres(), self._label)

    def _spheres(self):
        sizes = (self._every, _SIZE), (self._selected, _SELECTED_SIZE)
        for polydata, size in sizes:
            actor = _actor(polydata)
            actor.GetProperty().RenderPointsAsSpheresOn()
            actor.GetProperty().SetPointSize(size)
            yield actor

    def update(self, representation, is_dragged, are_numbered):
        """Show a representation's handles as they are now.

        Parameters
        ----------
        representation : vtkPolyLineRepresentation
        is_dragged : (n,) bool
        are_numbered : bool
        """
        representation.BuildRepresentation()  # so that they are grabbed where they are seen
        positions = vtk_to_numpy(representation.GetHandlePositions())
        usual = representation.GetHandleProperty().GetColor()
        colors = np.full((len(positions), 3), usual)
        if len(is_dragged) == len(positions):
            colors[is_dragged] = _DRAGGED
        _fill(self._every, positions, colors)
        selected = representation.GetCurrentHandleIndex()
        chosen = [selected] if 0 <= selected < len(positions) else []
        colors = np.full((1, 3), representation.GetSelectedHandleProperty().GetColor())
        _fill(self._selected, positions[chosen], colors[: len(chosen)])
        self._label.SetVisibility(are_numbered)
        self._label.GetMapper().GetLabelTextProperty().SetColor(usual)


def _fill(polydata, positions, colors):
    """Make points of positions (n, 3) and colors (n, 3) from 0 to 1, numbered from 1."""
    points, vertices = vtkPoints(), vtkCellArray()
    points.SetData(numpy_to_vtk(positions, deep=True))
    cells = np.stack([np.ones(len(positions)), np.arange(len(positions))], axis=1)
    cells = numpy_to_vtkIdTypeArray(cells.astype(np.int64).ravel(), deep=True)
    vertices.SetCells(len(positions), cells)
    polydata.SetPoints(points)
    polydata.SetVerts(vertices)
    polydata.GetPointData().SetScalars(numpy_to_vtk((255 * colors).astype(np.uint8), deep=True))
    numbers = numpy_to_vtk(np.arange(1, len(positions) + 1), deep=True)
    numbers.SetName(_NUMBER)
    polydata.GetPointData().AddArray(numbers)


def _actor(polydata):
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(polydata)
    actor.SetMapper(mapper)
    return actor


def forget_line(widget):
    """Leave of a widget only its handles: without a mapper the line is neither drawn nor picked.

    Parameters
    ----------
    widget : proxy of a vtk3DWidgetRepresentation
    """

    def shown(drawn, event):  # only then it tells its actors
        actors = vtkPropCollection()
        drawn.GetRepresentation().GetActors(actors)
        actors.GetItemAsObject(0).SetMapper(None)

    drawn = widget.GetClientSideObject().GetWidget()
    drawn.AddObserver("EnableEvent", shown)
    if drawn.GetEnabled():
        shown(drawn, None)
