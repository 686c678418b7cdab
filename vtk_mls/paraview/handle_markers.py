"""Markers of handles in ParaView's views: dragged, selected, and numbered ones differ.

ParaView's widget draws each handle by an actor of its own, all in one style, and a line through
them that drags all at once. Here its handles are picked but not drawn; one actor draws all markers.
"""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR
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

from vtk_mls.paraview.server_manager import Observers
from vtk_mls.rendering.projection import Projection
from vtk_mls.vtk.arrays import add, from_numpy, to_numpy
from vtk_mls.vtk.cells import set_positions
from vtk_mls.vtk.control_point_polydata import fill_arrows
from vtk_mls.vtk.objects import configured

_DRAGGED_COLOR = (1.0, 0.67, 0.0)
_PIXELS, _SELECTED_PIXELS = 10, 16  # diameters
_MAX_ROUND = 100  # markers; more are drawn with fewer faces, since that is slow without a GPU
_DIAMETER, _NUMBER = "Diameter", "Number"  # point arrays


class HandleMarkers:
    """The markers of one set of handles, in every view where a widget shows them."""

    def __init__(self):
        self._arrows, self._widgets = vtkPolyData(), []
        self._is_dragged = np.zeros(0, bool)
        self._is_numbered = self._is_empty = False

    def add_widget(self, widget):
        """Draw markers in place of a widget's handles; returns the vtkProps.

        `widget` is the proxy of a vtk3DWidgetRepresentation.
        """
        spheres = _Spheres()
        mapper = configured(vtkPolyDataMapper(), InputData=self._arrows, ScalarVisibility=False)
        arrows = configured(vtkActor(), Mapper=mapper, UseBounds=False)
        arrows.GetProperty().SetColor(_DRAGGED_COLOR)

        def frame_starts(representation):
            # the widget keeps its handles when all are removed
            for handle in actors_of(representation)[1:]:  # the first actor is the line
                handle.SetPickable(not self._is_empty)
            if self._is_empty:
                spheres.clear()
            else:
                spheres.update(representation, self._is_dragged, self._is_numbered)

        props = arrows, *spheres.props
        self._widgets.append(_WidgetProps(widget, props, frame_starts))
        return props

    def update(self, rest, deformed, is_numbered):
        """Show handles at (n, 3) world coordinates, with the numbers of their rows if numbered."""
        self._arrows.Initialize()
        self._is_empty, self._is_numbered = len(deformed) == 0, is_numbered
        if len(rest) == len(deformed):
            fill_arrows(self._arrows, rest, deformed)
            self._is_dragged = (rest != deformed).any(axis=1)

    def end(self):
        """Remove the markers from all views."""
        for widget in self._widgets:
            widget.end()
        self._widgets = []


class _WidgetProps:
    """Props in place of a widget's representation, while the widget is enabled.

    They are not part of the pipeline: states, Undo and pickers ignore them. At the start of each
    frame `frame_starts` is called with the representation.
    """

    def __init__(self, widget, props, frame_starts):
        self._props, self._frame_starts, self._renderer = props, frame_starts, None
        self._observers, self._frames = Observers(), Observers()
        for prop in props:
            prop.PickableOff()
        self._observers.follow_widget(
            widget.GetClientSideObject().GetWidget(), self._show, self._hide
        )

    def end(self):
        self._observers.end()
        self._hide(None, None)

    def _show(self, widget, event):
        self._hide(widget, event)
        representation = widget.GetRepresentation()
        renderer = self._renderer = representation.GetRenderer()
        for prop in self._props:
            renderer.AddViewProp(prop)
        renderer.RemoveViewProp(representation)  # it is picked all the same
        self._frames.add(renderer, "StartEvent", lambda *_: self._frame_starts(representation))

    def _hide(self, widget, event):
        if self._renderer is None:
            return
        renderer, self._renderer = self._renderer, None
        self._frames.end()
        for prop in self._props:
            renderer.RemoveViewProp(prop)


class _Spheres:
    """Spheres and numbers at the handles of a widget."""

    def __init__(self):
        self._points, self._sphere = vtkPolyData(), vtkSphereSource()
        mapper = configured(vtkGlyph3DMapper(), InputData=self._points, ScaleArray=_DIAMETER)
        mapper.SetSourceConnection(self._sphere.GetOutputPort())
        mapper.SetScaleModeToScaleByMagnitude()
        labels = configured(vtkLabeledDataMapper(), InputData=self._points, LabelFormat="  %d")
        labels.SetLabelModeToLabelFieldData()
        labels.SetFieldDataName(_NUMBER)
        labels.GetLabelTextProperty().ItalicOff()
        self._label = configured(vtkActor2D(), Mapper=labels)
        self.props = configured(vtkActor(), Mapper=mapper), self._label

    def clear(self):
        self._points.Initialize()

    def update(self, representation, is_dragged, is_numbered):
        """Show the handles of a vtkPolyLineRepresentation; `is_dragged` is (n,) bool."""
        representation.BuildRepresentation()  # handles are picked where the markers are
        positions = to_numpy(representation.GetHandlePositions())
        color = representation.GetHandleProperty().GetColor()
        colors, pixels = np.full((len(positions), 3), color), np.full(len(positions), _PIXELS)
        if len(is_dragged) == len(positions):
            colors[is_dragged] = _DRAGGED_COLOR
        selected = representation.GetCurrentHandleIndex()
        if 0 <= selected < len(positions):
            colors[selected] = representation.GetSelectedHandleProperty().GetColor()
            pixels[selected] = _SELECTED_PIXELS
        resolution = 16 if len(positions) < _MAX_ROUND else 8
        configured(self._sphere, ThetaResolution=resolution, PhiResolution=resolution)
        set_positions(self._points, positions.copy(), VTK_DOUBLE)
        values = self._points.GetPointData()
        diameters = pixels * Projection(representation.GetRenderer()).pixel_size(positions)
        values.SetScalars(from_numpy((255 * colors).astype(np.uint8), VTK_UNSIGNED_CHAR))
        add(values, _DIAMETER, diameters)
        add(values, _NUMBER, np.arange(1, len(positions) + 1))
        self._label.SetVisibility(is_numbered)
        self._label.GetMapper().GetLabelTextProperty().SetColor(color)


def remove_line(widget, event):
    """Remove the line between a widget's handles, so that it is neither drawn nor picked."""
    actors_of(widget.GetRepresentation())[0].SetMapper(None)


def actors_of(representation):
    """The actors of an enabled widget's representation."""
    actors = vtkPropCollection()
    representation.GetActors(actors)
    return [actors.GetItemAsObject(index) for index in range(actors.GetNumberOfItems())]
