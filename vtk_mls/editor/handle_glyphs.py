"""All handles as balls of one actor, and lines from where they rest to where they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkGlyph3DMapper, vtkPolyDataMapper

from vtk_mls.vtk import arrays

# 0 to 255
RESTING, MOVED, ANCHORED = (205, 212, 222), (255, 150, 40), (80, 160, 255)
SELECTED, HELD = (70, 230, 120), (255, 70, 110)
_HIDDEN = 0.3  # opacity of what is behind or within the data
_RADIUS, _RESTING_RADIUS, _MORE = 6.5, 5.0, 3.0  # pixels; and of the one under the mouse


@dataclass(frozen=True, eq=False)
class Marks:
    """Handles of a `State`, and rows of those that are to be seen as such.

    Attributes
    ----------
    state : State
    selected, held : (m,) ints
    hovered : int or None
    are_visible : bool
    """

    state: object
    selected: np.ndarray
    hovered: int | None
    held: np.ndarray
    are_visible: bool = True

    def colours(self):
        """(n, 3), 0 to 255."""
        colours = np.where(self.state.is_resting[:, None], RESTING, MOVED)
        colours[self.state.anchored] = ANCHORED
        colours[self.selected] = SELECTED
        colours[self.held] = HELD
        return colours


class HandleGlyphs:
    """Draws handles as large on the screen wherever they are, and faintly what hides them.

    Parameters
    ----------
    renderer, overlay : vtkRenderer
        Of the data, and one that is drawn over them.
    """

    def __init__(self, renderer, overlay):
        self._balls, self._lines = vtkPolyData(), vtkPolyData()
        self._actors = [
            *(_ball_actor(self._balls, opacity) for opacity in (1, _HIDDEN)),
            *(_line_actor(self._lines, opacity) for opacity in (1, _HIDDEN)),
        ]
        for number, actor in enumerate(self._actors):
            (overlay if number % 2 else renderer).AddActor(actor)
        self._pixels = np.zeros(0)

    def set_visible(self, is_visible):
        """Show or hide all of them."""
        for actor in self._actors:
            actor.SetVisibility(is_visible)

    def show(self, marks):
        """Draw handles as `Marks` say."""
        state, hovered = marks.state, marks.hovered
        count, resting = len(state), state.is_resting
        self._pixels = np.where(resting, _RESTING_RADIUS, _RADIUS)
        self._pixels[[] if hovered is None else [hovered]] += _MORE
        data = self._balls.GetPointData()
        self._balls.SetPoints(_points(state.deformed))
        data.AddArray(_named("colour", marks.colours().astype(np.uint8), VTK_UNSIGNED_CHAR))
        data.AddArray(_named("radius", np.ones(count), VTK_DOUBLE))
        moved = np.flatnonzero(~resting)
        ends = np.stack([state.rest[moved], state.deformed[moved]], axis=1).reshape(-1, 3)
        self._lines.SetPoints(_points(ends))
        cells = vtkCellArray()
        cells.SetData(
            arrays.ids(2 * np.arange(len(moved) + 1)), arrays.ids(np.arange(2 * len(moved)))
        )
        self._lines.SetLines(cells)

    def fit(self, projection):
        """Make the balls as large as they are to be, as a `Projection` shows them."""
        points = self._balls.GetPoints()
        if points is None or points.GetNumberOfPoints() == 0:
            return
        positions = arrays.to_numpy(points.GetData())
        radius = self._pixels * projection.size_of_a_pixel(positions)
        before = arrays.to_numpy(self._balls.GetPointData().GetArray("radius"))
        if not np.allclose(before, radius, rtol=1e-3, atol=0):
            self._balls.GetPointData().AddArray(_named("radius", radius, VTK_DOUBLE))
            self._balls.Modified()


def _named(name, values, vtk_type):
    array = arrays.from_numpy(values, vtk_type)
    array.SetName(name)
    return array


def _points(positions):
    points = vtkPoints()
    points.SetData(arrays.from_numpy(positions, VTK_DOUBLE))
    return points


def _ball_actor(balls, opacity):
    sphere, mapper, actor = vtkSphereSource(), vtkGlyph3DMapper(), vtkActor()
    sphere.SetRadius(1)
    sphere.SetThetaResolution(20)
    sphere.SetPhiResolution(14)
    mapper.SetInputData(balls)
    mapper.SetSourceConnection(sphere.GetOutputPort())
    mapper.SetScaleModeToScaleByMagnitude()
    mapper.SetScaleArray("radius")
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("colour")
    mapper.SetColorModeToDirectScalars()
    actor.SetMapper(mapper)
    actor.PickableOff()
    drawn_as = actor.GetProperty()
    drawn_as.SetOpacity(opacity)
    drawn_as.SetAmbient(0.45)
    drawn_as.SetDiffuse(0.6)
    drawn_as.SetSpecular(0.25)
    drawn_as.SetSpecularPower(30)
    return actor


def _line_actor(lines, opacity):
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(lines)
    actor.SetMapper(mapper)
    actor.PickableOff()
    actor.GetProperty().SetColor(np.divide(MOVED, 255))
    actor.GetProperty().SetLineWidth(2)
    actor.GetProperty().SetOpacity(opacity)
    actor.GetProperty().LightingOff()
    return actor
