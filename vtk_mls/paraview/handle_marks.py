"""How handles look in ParaView's views: who was dragged, from where, and which is selected.

ParaView's widget draws all its handles alike, each by itself, and a line through them that moves
all of them when it is dragged. Here its handles are grabbed and not drawn; what is drawn is one
actor for all.
"""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkActor2D,
    vtkGlyph3DMapper,
    vtkPolyDataMapper,
    vtkPropCollection,
)
from vtkmodules.vtkRenderingLabel import vtkLabeledDataMapper

from vtk_mls.filters.handle_arrows import fill_arrows
from vtk_mls.paraview.beside_widget import BesideWidget
from vtk_mls.vtk.arrays import add, from_numpy

_DRAGGED = (1.0, 0.67, 0.0)
_PIXELS, _SELECTED_PIXELS = 10, 16  # diameters
_MANY = 100
_DIAMETER, _NUMBER = "Diameter", "Number"


class Marks:
    """The handles of one set, in every view where a widget shows them."""

    def __init__(self):
        self._arrows, self._views = vtkPolyData(), []
        self._is_dragged = np.zeros(0, bool)
        self._are_numbered, self._are_removed = False, False

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
        mapper, arrows = vtkPolyDataMapper(), vtkActor()
        mapper.SetInputData(self._arrows)
        mapper.ScalarVisibilityOff()
        arrows.SetMapper(mapper)
        arrows.GetProperty().SetColor(_DRAGGED)
        arrows.UseBoundsOff()

        def frame(representation):
            _let_grab(representation, not self._are_removed)
            if self._are_removed:
                handles.clear()
            else:
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
        self._are_removed = len(deformed) == 0
        if len(rest) == len(deformed):
            fill_arrows(self._arrows, rest, deformed)
            self._is_dragged = (rest != deformed).any(axis=1)

    def number(self, wanted):
        """Whether each handle has its number beside it, that of its row in the tables."""
        self._are_numbered = wanted

    def end(self):
        """Go from all views for good."""
        for view in self._views:
            view.end()
        self._views = []


class _Handles:
    """What is drawn of the handles of a widget."""

    def __init__(self):
        self._points = vtkPolyData()
        labels, label = vtkLabeledDataMapper(), vtkActor2D()
        labels.SetInputData(self._points)
        labels.SetLabelModeToLabelFieldData()
        labels.SetFieldDataName(_NUMBER)
        labels.SetLabelFormat("  %d")
        labels.GetLabelTextProperty().ItalicOff()
        label.SetMapper(labels)
        self._label = label
        self.props = self._spheres(), label

    def _spheres(self):
        sphere, mapper, actor = vtkSphereSource(), vtkGlyph3DMapper(), vtkActor()
        self._sphere = sphere
        mapper.SetInputData(self._points)
        mapper.SetSourceConnection(sphere.GetOutputPort())
        mapper.SetScaleArray(_DIAMETER)
        mapper.SetScaleModeToScaleByMagnitude()
        actor.SetMapper(mapper)
        return actor

    def clear(self):
        """Show none."""
        self._points.Initialize()

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
        colors, pixels = np.full((len(positions), 3), usual), np.full(len(positions), _PIXELS)
        if len(is_dragged) == len(positions):
            colors[is_dragged] = _DRAGGED
        selected = representation.GetCurrentHandleIndex()
        if 0 <= selected < len(positions):
            colors[selected] = representation.GetSelectedHandleProperty().GetColor()
            pixels[selected] = _SELECTED_PIXELS
        corners = 16 if len(positions) < _MANY else 8  # 500 round ones take long without a GPU
        self._sphere.SetThetaResolution(corners)
        self._sphere.SetPhiResolution(corners)
        points, values = vtkPoints(), self._points.GetPointData()
        points.SetData(from_numpy(positions.copy(), VTK_DOUBLE))
        self._points.SetPoints(points)
        sizes = pixels * _size_of_a_pixel(positions, representation.GetRenderer())
        values.SetScalars(from_numpy((255 * colors).astype(np.uint8), VTK_UNSIGNED_CHAR))
        add(values, _DIAMETER, sizes)
        add(values, _NUMBER, np.arange(1, len(positions) + 1))
        self._label.SetVisibility(are_numbered)
        self._label.GetMapper().GetLabelTextProperty().SetColor(usual)


def _size_of_a_pixel(positions, renderer):
    """How large what a pixel shows is at positions (n, 3): (n,), world units."""
    camera, height = renderer.GetActiveCamera(), renderer.GetSize()[1]
    if camera.GetParallelProjection():
        return np.full(len(positions), 2 * camera.GetParallelScale() / height)
    depth = (positions - camera.GetPosition()) @ camera.GetDirectionOfProjection()
    return 2 * np.abs(depth) * np.tan(np.radians(camera.GetViewAngle()) / 2) / height


def _let_grab(representation, wanted):
    """Whether handles can be grabbed: a widget keeps them when all are removed."""
    actors = vtkPropCollection()
    representation.GetActors(actors)
    for number in range(1, actors.GetNumberOfItems()):  # the first is the line
        actors.GetItemAsObject(number).SetPickable(wanted)


def forget_line(widget):
    """Leave of a widget only its handles: without a mapper the line is neither drawn nor picked.

    Parameters
    ----------
    widget : proxy of a vtk3DWidgetRepresentation
    """
    drawn = widget.GetClientSideObject().GetWidget()
    drawn.AddObserver("EnableEvent", _remove_line)  # only then it tells its actors
    if drawn.GetEnabled():
        _remove_line(drawn, None)


def _remove_line(drawn, event):
    actors = vtkPropCollection()
    drawn.GetRepresentation().GetActors(actors)
    actors.GetItemAsObject(0).SetMapper(None)
