"""The widget for a flat cut: a plane, or a part of it with its edge."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPlane, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkContourFilter, vtkCutter
from vtkmodules.vtkInteractionWidgets import (
    vtkImplicitPlaneRepresentation,
    vtkImplicitPlaneWidget2,
)

from vtk_mls import Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor import polydata
from vtk_mls.editor.drag_widget import DragWidget
from vtk_mls.model.cuts import Obstacle
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import positions_of
from vtk_mls.vtk.objects import configured

_BLUE, _LIGHT_BLUE, _RED = (0.35, 0.75, 1.0), (0.8, 0.93, 1.0), (1.0, 0.45, 0.55)
_OPACITY, _GRABBED_OPACITY = 0.18, 0.35  # of the plane
# Of the plane of a cut with an edge: VTK does not pick an invisible plane.
_MIN_OPACITY, _GRABBED_MIN_OPACITY = 0.004, 0.06
_SHEET_OPACITIES = 0.3, 1.0  # of the sheet and its edge
_HIDDEN_OPACITIES = 0.1, 0.45  # likewise, behind the data
_EDGE_WIDTH = 4
_MARGIN = 0.1  # of the plane around the data, relative to their size
_LENGTH = 0.25  # of new cuts, relative to the data
_CELLS = 32  # along each axis of the box in which a sheet is drawn
_OFFSET = 0.01  # of the initial plane from the middle, where handles may be


class CutWidget(DragWidget):
    """Lets the mouse move and tilt a flat cut in a `Scene`."""

    def __init__(self, interactor, scene):
        self._bounds, self._cut = scene.bounds, None
        margin = _MARGIN / 2 * np.ptp(self._bounds, axis=0)
        self._sheet = EdgedSheet(scene, self._bounds + np.stack([-margin, margin]))
        self._plane = _representation(self._bounds)
        super().__init__(interactor, scene.renderer, vtkImplicitPlaneWidget2(), self._plane)

    @property
    def _has_value(self):
        return self._cut is not None

    def show(self, cut):
        """Show a flat cut, or nothing for None."""
        self._cut = cut
        self._update()
        if cut is not None and self._is_visible:
            configured(self._plane, Origin=cut.point, Normal=cut.normal)
            self._draw_sheet(cut)

    def initial_cut(self, shape, previous, camera):
        """A cut of a `shape`, in the place of the previous one, if there is one.

        Its first vector in the plane points up, its lengths are a quarter of the data.
        """
        plane = previous or self._initial_plane(camera)
        up = np.array(camera.GetViewUp())
        up = up - up @ plane.normal * plane.normal
        axis = _nearest_axis(up)
        is_in_plane = abs(axis @ plane.normal) < 0.9
        length = _LENGTH * np.ptp(self._bounds, axis=0).max()
        new = {"vector": axis if is_in_plane else up, "length": length}
        return shape(*(getattr(plane, f.name, new.get(f.kind)) for f in shape.fields))

    def _initial_plane(self, camera):
        """A plane near the middle of the data, seen edge-on."""
        viewing = np.subtract(camera.GetFocalPoint(), camera.GetPosition())
        normal = _nearest_axis(np.cross(viewing, camera.GetViewUp()))
        size = np.ptp(self._bounds, axis=0).max()
        return Plane(self._bounds.mean(axis=0) + _OFFSET * size * normal, normal)

    def _update(self):
        is_enabled = super()._update()
        self._sheet.set_visible(is_enabled and isinstance(self._cut, Obstacle))
        return is_enabled

    def _value(self):
        point, normal = np.array(self._plane.GetOrigin()), np.array(self._plane.GetNormal())
        values = {"point": point, "normal": normal}
        for name in (field.name for field in self._cut.fields[2:] if field.kind == "vector"):
            value = getattr(self._cut, name)
            values[name] = value - value @ normal * normal
            if np.linalg.norm(values[name]) < 1e-3:  # tilted until it was along the new normal
                values[name] = np.cross(normal, np.cross(self._cut.normal, value))
        cut = self._cut.changed(**values)
        self._draw_sheet(cut)
        return cut

    def _draw_sheet(self, cut):
        """Fill all of a plane, or the part that cuts."""
        is_part = isinstance(cut, Obstacle)
        self._plane.GetPlaneProperty().SetOpacity(_MIN_OPACITY if is_part else _OPACITY)
        self._plane.GetSelectedPlaneProperty().SetOpacity(
            _GRABBED_MIN_OPACITY if is_part else _GRABBED_OPACITY
        )
        if is_part:
            self._sheet.show(cut)


class EdgedSheet:
    """Draws a flat cut and its edge within a box with corners (2, 3)."""

    def __init__(self, scene, corners):
        self._actors, self._plane, self._sheet = [], vtkPlane(), vtkPolyData()
        spacing = np.maximum(np.ptp(corners, axis=0), 1e-9 * np.ptp(corners)) / _CELLS
        box = configured(vtkImageData(), Dimensions=[_CELLS + 1] * 3, Spacing=spacing)
        box.SetOrigin(corners[0])
        self._cutter = configured(vtkCutter(), InputData=box, CutFunction=self._plane)
        part = configured(vtkClipPolyData(), InputData=self._sheet)
        edge = configured(vtkContourFilter(), InputData=self._sheet)
        edge.SetValue(0, 0.0)
        layers = (scene.renderer, _SHEET_OPACITIES), (scene.overlay, _HIDDEN_OPACITIES)
        for renderer, opacities in layers:
            for source, color, opacity in zip((part, edge), (_BLUE, _RED), opacities):
                self._actors.append(polydata.unlit_actor(source, color, _EDGE_WIDTH, opacity))
                renderer.AddActor(self._actors[-1])
        self.set_visible(False)

    def show(self, cut):
        """Draw a cut."""
        configured(self._plane, Origin=cut.point, Normal=cut.normal)
        self._cutter.Update()
        self._sheet.ShallowCopy(self._cutter.GetOutput())
        depth = cut.depth(positions_of(self._sheet).astype(float))
        arrays.add(self._sheet.GetPointData(), "depth", depth)
        self._sheet.GetPointData().SetActiveScalars("depth")

    def set_visible(self, is_visible):
        """Show or hide the sheet."""
        for actor in self._actors:
            actor.SetVisibility(is_visible)


def _nearest_axis(vector):
    """The unit vector along the axis that is nearest to a vector (3,)."""
    axis = np.abs(vector).argmax()
    return unit(np.eye(3)[axis] * (-1.0 if vector[axis] < 0 else 1.0))


def _representation(bounds):
    plane = configured(vtkImplicitPlaneRepresentation(), PlaceFactor=1 + _MARGIN)
    plane.PlaceWidget(bounds.T.ravel())
    configured(plane, OutlineTranslation=False, OutsideBounds=True, ScaleEnabled=False)
    configured(plane, DrawOutline=False, EdgeColor=_BLUE, Tubing=False)
    plane.GetPlaneProperty().SetColor(_BLUE)
    plane.GetSelectedPlaneProperty().SetColor(_BLUE)
    plane.GetNormalProperty().SetColor(_BLUE)
    plane.GetSelectedNormalProperty().SetColor(_LIGHT_BLUE)
    return plane
