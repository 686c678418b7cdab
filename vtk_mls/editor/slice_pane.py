"""One slice of deformed data in a renderer of its own, with the handles that are near it."""

from __future__ import annotations

import numpy as np
import vtkmodules.vtkRenderingImage  # noqa: F401  draws slices
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkPlane, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkCutter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkImageSlice,
    vtkImageSliceMapper,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkTextActor,
)

from vtk_mls import Grid
from vtk_mls.editor.projection import Projection
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_MARGIN = 0.2  # of the size, beyond the data at rest
# Whence one looks along x, y, z, and what is up: in LPS as radiologists do.
_FROM = np.array([(1.0, 0, 0), (0, -1, 0), (0, 0, -1)])
_UP = np.array([(0.0, 0, 1), (0, 0, 1), (0, -1, 0)])
_HUES = (0.95, 0.40, 0.40), (0.95, 0.85, 0.35), (0.45, 0.70, 1.0)  # of the planes
_OUTLINE = (0.95, 0.80, 0.55)


class SlicePane:
    """A plane across one of the world's axes.

    Parameters
    ----------
    axis : int
    bounds : (2, 3)
        Corners of the data at rest.

    Attributes
    ----------
    renderer : vtkRenderer
    """

    def __init__(self, axis, bounds):
        self.axis, self.renderer = axis, vtkRenderer()
        size = np.ptp(bounds, axis=0).max()
        self._corners = bounds + _MARGIN * size * np.array([[-1], [1]])
        self._size, self._at = size, 0.0
        self.renderer.SetBackground(0.02, 0.025, 0.035)
        self._image, self._slice = vtkImageSliceMapper(), vtkImageSlice()
        self._image.SetOrientation(axis)
        self._slice.SetMapper(self._image)
        self._outlines, self._cross, self._balls = vtkPolyData(), vtkPolyData(), vtkPolyData()
        self._edges = [_line_actor(self._outlines, _OUTLINE, 2), _line_actor(self._cross, None, 1)]
        self._handles = _ball_actor(self._balls)
        self._name = _text(_HUES[axis])
        for prop in (self._slice, *self._edges, self._handles, self._name):
            self.renderer.AddViewProp(prop)
        self._look_along(bounds.mean(axis=0))

    @property
    def projection(self):
        """How it is seen."""
        return Projection(self.renderer)

    def point_at(self, pixel):
        """The point (3,) of the slice at a pixel."""
        near, far = self.projection.ray(pixel)
        share = (self._at - near[self.axis]) / (far - near)[self.axis]
        return near + share * (far - near)

    def show(self, shown, point, count):
        """Draw what is there of data, with so many samples along the longest side."""
        self._fit()
        self._at = point[self.axis]
        grid = self._grid(count)
        colours = np.zeros((grid.size, 3), np.uint8)
        points = grid.points()
        for each in shown:
            found = each.colours_at(points)
            if found is not None:
                is_there, of = found
                colours[is_there] = of[is_there]
        image = vtkImageData()
        ImageGeometry.of_grid(grid).apply_to(image)
        arrays.add(image.GetPointData(), "colours", colours)
        image.GetPointData().SetActiveScalars("colours")
        self._image.SetInputData(image)
        self._draw_outlines([each.mesh() for each in shown])
        self._draw_cross(point)
        self._name.SetInput(f"{'xyz'[self.axis]} = {self._at:.4g}")
        self.renderer.ResetCameraClippingRange()

    def mark(self, marks, rows):
        """Draw some handles."""
        points, cells = vtkPoints(), vtkCellArray()
        points.SetData(arrays.from_numpy(self._before(marks.state.deformed[rows], 2), VTK_DOUBLE))
        cells.SetData(arrays.ids(np.arange(len(rows) + 1)), arrays.ids(np.arange(len(rows))))
        colours = arrays.from_numpy(marks.colours()[rows].astype(np.uint8), VTK_UNSIGNED_CHAR)
        self._balls.SetPoints(points)
        self._balls.SetVerts(cells)
        self._balls.GetPointData().SetScalars(colours)
        self._balls.Modified()
        self._handles.SetVisibility(marks.are_visible)
        self.renderer.ResetCameraClippingRange()

    def _grid(self, count):
        """A grid of all that is seen, for material that has moved far."""
        extent = np.ptp(self._seen, axis=0)
        spacing = np.full(3, np.delete(extent, self.axis).max() / count)
        dimensions = np.ceil(extent / spacing).astype(int) + 1
        first = self._seen[0].copy()
        dimensions[self.axis], first[self.axis] = 1, self._at
        return Grid(dimensions, first, spacing)

    def _draw_outlines(self, meshes):
        plane, append = vtkPlane(), vtkAppendPolyData()
        plane.SetOrigin(np.eye(3)[self.axis] * self._at)
        plane.SetNormal(np.eye(3)[self.axis])
        for mesh in meshes:
            if mesh is not None:
                cut = vtkCutter()
                cut.SetInputData(mesh)
                cut.SetCutFunction(plane)
                append.AddInputConnection(cut.GetOutputPort())
        if append.GetNumberOfInputConnections(0):
            append.Update()
            self._outlines.ShallowCopy(append.GetOutput())
            self._edges[0].SetPosition(*(self._size * 1e-3 * _FROM[self.axis]))

    def _draw_cross(self, point):
        """Where the other two slices are."""
        others = [axis for axis in range(3) if axis != self.axis]
        ends, colours = [], []
        for across, along in (others, others[::-1]):
            for corner in self._corners:
                end = np.array(point, float)
                end[along] = corner[along]
                ends.append(end)
            colours.append(np.multiply(_HUES[across], 255))
        points, lines = vtkPoints(), vtkCellArray()
        points.SetData(arrays.from_numpy(self._before(np.array(ends), 1), VTK_DOUBLE))
        lines.SetData(arrays.ids(np.array([0, 2, 4])), arrays.ids(np.arange(4)))
        self._cross.SetPoints(points)
        self._cross.SetLines(lines)
        hues = arrays.from_numpy(np.array(colours).astype(np.uint8), VTK_UNSIGNED_CHAR)
        self._cross.GetCellData().SetScalars(hues)
        self._cross.Modified()

    def _before(self, points, layer):
        """Points (n, 3) just before the slice, on the eye's side."""
        points = np.array(points, float).reshape(-1, 3)
        points[:, self.axis] = self._at + layer * 2e-3 * self._size * _FROM[self.axis, self.axis]
        return points

    def _look_along(self, middle):
        camera = self.renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(middle)
        camera.SetPosition(middle + 3 * self._size * _FROM[self.axis])
        camera.SetViewUp(_UP[self.axis])
        self.renderer.AddObserver("StartEvent", self._fit)

    def _fit(self, *_):
        """See all of it, whatever the shape of the renderer."""
        extent, up = np.ptp(self._corners, axis=0), np.abs(_UP[self.axis]) > 0
        high, wide = extent[up][0], np.delete(extent, [self.axis, int(up.argmax())])[0]
        width, height = self.renderer.GetSize()
        scale = max(high, wide * height / max(width, 1)) / 2
        self.renderer.GetActiveCamera().SetParallelScale(scale)
        half = np.where(up, scale, scale * width / max(height, 1))
        self._seen = self._corners.mean(axis=0) + half * np.array([[-1], [1]])


def _line_actor(polydata, colour, width):
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(polydata)
    mapper.SetScalarVisibility(colour is None)
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarModeToUseCellData()
    actor.SetMapper(mapper)
    actor.PickableOff()
    actor.GetProperty().SetColor(colour or (1, 1, 1))
    actor.GetProperty().SetLineWidth(width)
    actor.GetProperty().LightingOff()
    return actor


def _ball_actor(balls):
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(balls)
    mapper.SetColorModeToDirectScalars()
    actor.SetMapper(mapper)
    actor.PickableOff()
    actor.GetProperty().SetPointSize(12)
    actor.GetProperty().RenderPointsAsSpheresOn()
    actor.GetProperty().SetAmbient(0.45)
    actor.GetProperty().SetDiffuse(0.6)
    return actor


def _text(colour):
    actor = vtkTextActor()
    actor.SetPosition(8, 8)
    actor.PickableOff()
    actor.GetTextProperty().SetFontSize(13)
    actor.GetTextProperty().SetColor(colour)
    return actor
