"""One slice of the deformed data in its own renderer, with the handles near it."""

import numpy as np
import vtkmodules.vtkRenderingImage  # noqa: F401  renders slices
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPlane, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkCutter
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation
from vtkmodules.vtkRenderingCore import vtkImageSlice, vtkImageSliceMapper, vtkRenderer

from vtk_mls import Grid
from vtk_mls.editor import polydata
from vtk_mls.editor.handle_glyphs import DRAWN
from vtk_mls.editor.overlay import Names
from vtk_mls.editor.scene_mesh import OUTLINE_COLOR
from vtk_mls.rendering.projection import Projection
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured, output_of

_MARGIN = 0.2  # around the data at rest, relative to their size
# Direction to the eye, and up, for slices across x, y, z: as radiologists view LPS.
EYE = np.array([(1.0, 0, 0), (0, -1, 0), (0, 0, -1)])
UP = np.array([(0.0, 0, 1), (0, 0, 1), (0, -1, 0)])
_AXIS_COLORS = (0.95, 0.40, 0.40), (0.95, 0.85, 0.35), (0.45, 0.70, 1.0)
_GRID_COLOR, _GRID_OPACITY = (0.45, 0.95, 0.85), 0.75


class SlicePane:
    """A slice across an axis of the world in a `renderer`; `bounds` (2, 3) are of data at rest."""

    def __init__(self, axis, bounds):
        self.axis, self.renderer = axis, vtkRenderer()
        self._size, self._position = np.ptp(bounds, axis=0).max(), 0.0
        self._corners = bounds + _MARGIN * self._size * np.array([[-1], [1]])
        self.renderer.SetBackground(0.02, 0.025, 0.035)
        self._mapper = configured(vtkImageSliceMapper(), Orientation=axis)
        self._image = image = configured(vtkImageSlice(), Mapper=self._mapper, Visibility=False)
        self._outlines, self._cross, self._balls = vtkPolyData(), vtkPolyData(), vtkPolyData()
        outlines = polydata.unlit_actor(self._outlines, width=2)
        outlines.SetPosition(*(self._size * 1e-3 * EYE[axis]))  # in front of the image
        cross = polydata.unlit_actor(self._cross)
        cross.SetVisibility(bool(np.ptp(bounds, axis=0)[axis]))  # flat images have no other slices
        self._lines = vtkPolyData()
        lines = polydata.unlit_actor(self._lines, _GRID_COLOR, 1.2, _GRID_OPACITY)
        self._handles, self._label = _ball_actor(self._balls), _label(axis)
        for prop in (image, lines, outlines, cross, self._handles, self._label):
            self.renderer.AddViewProp(prop)
        self._names = Names(self.renderer)
        configured(self.renderer.GetActiveCamera(), ViewUp=UP[axis], ParallelProjection=True)
        self.look_at(bounds.mean(axis=0), 1.0)
        self.renderer.AddObserver("StartEvent", self._fit)

    def look_at(self, center, zoom):
        """Set the middle (3,) of the picture, and the magnification."""
        self._center, self._zoom = np.array(center, float), zoom
        position = self._center + 3 * self._size * EYE[self.axis]
        configured(self.renderer.GetActiveCamera(), FocalPoint=self._center, Position=position)
        self._fit()

    @property
    def projection(self):
        """The current `Projection`."""
        return Projection(self.renderer)

    def point_at(self, pixel):
        """The point (3,) of the slice at a pixel."""
        near, far = self.projection.ray(pixel)
        fraction = (self._position - near[self.axis]) / (far - near)[self.axis]
        return near + fraction * (far - near)

    def show(self, items, surfaces, point, count, distortion):
        """Draw the slice through a point, with `count` samples along its longer side.

        The outlines of `surfaces`, vtkPolyData, are drawn as for meshes. `distortion` is a
        `Distortion`.
        """
        self._position = point[self.axis]
        grid = self._grid(count)
        points = grid.points()
        _, colors = colors_of(items, points) or (None, np.zeros((grid.size, 3), np.uint8))
        colors = distortion.tinted(points, colors)
        image = ImageGeometry.of_grid(grid).apply_to(vtkImageData())
        arrays.add(image.GetPointData(), "colors", colors)
        image.GetPointData().SetActiveScalars("colors")
        self._mapper.SetInputData(image)
        self._image.VisibilityOn()
        self._draw_lines(distortion.lines_in(self.axis, grid))
        meshes = [(item.mesh(), getattr(item, "outline_color", None)) for item in items]
        self._draw_outlines([*meshes, *((surface, OUTLINE_COLOR) for surface in surfaces)])
        self._draw_cross(point)
        title = f"{'xyz'[self.axis]} = {self._position:.4g}"
        self._label.SetText(vtkCornerAnnotation.UpperRight, title)
        self.renderer.ResetCameraClippingRange()

    def show_handles(self, positions, colors, are_visible, names=None, nodes=()):
        """Draw handles at positions (n, 3) with colors (n, 3), and names as of `Slices`.

        `nodes` (k, 3) are those of a curve that is drawn.
        """
        places = self._in_front(positions, 2)
        self._names.show(places, *(names or ([], [])), are_visible)
        places = np.concatenate([places, self._in_front(nodes, 2)])
        colors = np.concatenate([colors, np.tile(DRAWN, (len(nodes), 1))])
        self._balls.SetPoints(polydata.points(places))
        self._balls.SetVerts(polydata.cells(np.arange(len(places))[:, None]))
        self._balls.GetPointData().SetScalars(polydata.colors(colors))
        self._handles.SetVisibility(are_visible)
        self.renderer.ResetCameraClippingRange()

    def _grid(self, count):
        """A grid over the whole pane, as material may move far."""
        extent = np.ptp(self._visible_box, axis=0)
        spacing = np.full(3, np.delete(extent, self.axis).max() / count)
        dimensions = np.ceil(extent / spacing).astype(int) + 1
        first = self._visible_box[0].copy()
        dimensions[self.axis], first[self.axis] = 1, self._position
        return Grid(dimensions, first, spacing)

    def _draw_lines(self, ends):
        self._lines.SetPoints(polydata.points(self._in_front(ends, 0.5)))
        self._lines.SetLines(polydata.cells(np.arange(2 * len(ends)).reshape(-1, 2)))

    def _draw_outlines(self, meshes):
        """Draw the outlines of meshes: pairs of a dataset, or None, and a color."""
        normal, append = np.eye(3)[self.axis], vtkAppendPolyData()
        plane = configured(vtkPlane(), Origin=normal * self._position, Normal=normal)
        for mesh, color in meshes:
            if mesh is not None:
                outline = vtkPolyData()
                outline.CopyStructure(output_of(vtkCutter(), InputData=mesh, CutFunction=plane))
                colors = np.tile(np.multiply(color, 255), (outline.GetNumberOfCells(), 1))
                outline.GetCellData().SetScalars(polydata.colors(colors))
                append.AddInputData(outline)
        if append.GetNumberOfInputConnections(0):
            self._outlines.ShallowCopy(output_of(append))

    def _draw_cross(self, point):
        """Draw the positions of the other two slices."""
        others = [axis for axis in range(3) if axis != self.axis]
        ends = np.tile(np.array(point, float), (4, 1))
        for i, along in enumerate(others[::-1]):
            ends[2 * i : 2 * i + 2, along] = self._corners[:, along]
        colors = [np.multiply(_AXIS_COLORS[across], 255) for across in others]
        self._cross.SetPoints(polydata.points(self._in_front(ends, 1)))
        self._cross.SetLines(polydata.cells(np.array([(0, 1), (2, 3)])))
        self._cross.GetCellData().SetScalars(polydata.colors(colors))

    def _in_front(self, points, layer):
        """Points (n, 3) moved into a layer just in front of the slice."""
        points = np.array(points, float).reshape(-1, 3)
        step = 2e-3 * self._size * EYE[self.axis, self.axis]
        points[:, self.axis] = self._position + layer * step
        return points

    def _fit(self, *_):
        """Fit the camera to the data for the shape of the renderer."""
        extent, up = np.ptp(self._corners, axis=0), np.abs(UP[self.axis]) > 0
        high, wide = extent[up][0], np.delete(extent, [self.axis, int(up.argmax())])[0]
        width, height = self.renderer.GetSize()
        scale = max(high, wide * height / max(width, 1)) / 2 / self._zoom
        self.renderer.GetActiveCamera().SetParallelScale(scale)
        half = np.where(up, scale, scale * width / max(height, 1))
        self._visible_box = self._center + half * np.array([[-1], [1]])


def colors_of(items, points):
    """`colors_at` of several items, the last one in front; None without images."""
    sampled = [item.colors_at(points) for item in items]
    sampled = [part for part in sampled if part is not None]
    if not sampled:
        return None
    has_any, colors = np.zeros(len(points), bool), np.zeros((len(points), 3), np.uint8)
    for has_material, item_colors in sampled:
        is_shown = has_material | ~has_any
        colors[is_shown] = item_colors[is_shown]
        has_any |= has_material
    return has_any, colors


def letter_of(direction):
    """The letter of a direction (3,) along an axis of LPS coordinates."""
    axis = int(np.abs(direction).argmax())
    return "RAI"[axis] if direction[axis] < 0 else "LPS"[axis]


def _label(axis):
    """The position of the slice, and letters of directions at the edges."""
    label = configured(vtkCornerAnnotation(), LinearFontScaleFactor=5, MaximumFontSize=13)
    label.GetTextProperty().SetColor(_AXIS_COLORS[axis])
    label.SetText(vtkCornerAnnotation.LowerRight, "LPS")
    right, up = np.cross(UP[axis], EYE[axis]), UP[axis]
    for edge, direction in zip(("Right", "Left", "Upper", "Lower"), (right, -right, up, -up)):
        label.SetText(getattr(vtkCornerAnnotation, f"{edge}Edge"), letter_of(direction))
    return label


def _ball_actor(balls):
    actor = polydata.unlit_actor(balls)
    actor.GetMapper().SetScalarModeToUsePointData()
    polydata.show_points_as_balls(actor, 12)
    configured(actor.GetProperty(), Lighting=True, Ambient=0.45, Diffuse=0.6)
    return actor
