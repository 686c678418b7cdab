"""The widget for a flat cut: a plane, or half of it with its edge."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPlane
from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkCutter
from vtkmodules.vtkInteractionWidgets import (
    vtkImplicitPlaneRepresentation,
    vtkImplicitPlaneWidget2,
)

from vtk_mls import HalfPlane, Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor import polydata
from vtk_mls.editor.drag_widget import DragWidget
from vtk_mls.editor.polydata import configured

_BLUE, _LIGHT_BLUE, _RED = (0.35, 0.75, 1.0), (0.8, 0.93, 1.0), (1.0, 0.45, 0.55)
_OPACITY, _GRABBED_OPACITY = 0.18, 0.35  # of the plane
# Of the plane of a half-plane: VTK does not pick an invisible plane.
_MIN_OPACITY, _GRABBED_MIN_OPACITY = 0.004, 0.06
_HALF_OPACITIES = 0.3, 1.0  # of the sheet and its edge
_HIDDEN_OPACITIES = 0.1, 0.45  # likewise, behind the data
_EDGE_WIDTH = 4
_MARGIN = 0.1  # of the plane around the data, relative to their size
_OFFSET = 0.01  # of the initial plane from the middle, where handles may be


class CutWidget(DragWidget):
    """Lets the mouse move and tilt a flat cut in a `Scene`."""

    def __init__(self, interactor, scene):
        self._bounds, self._cut = scene.bounds, None
        margin = _MARGIN / 2 * np.ptp(self._bounds, axis=0)
        self._half = HalfSheet(scene, self._bounds + np.stack([-margin, margin]))
        self._plane = _representation(self._bounds)
        super().__init__(interactor, scene.renderer, vtkImplicitPlaneWidget2(), self._plane)

    @property
    def _has_value(self):
        return self._cut is not None

    def show(self, cut):
        """Show a Plane or a HalfPlane, or nothing for None."""
        self._cut = cut
        self._update()
        if cut is not None and self._is_visible:
            configured(self._plane, Origin=cut.point, Normal=cut.normal)
            self._draw_sheet(cut)

    def initial_plane(self, camera):
        """A plane near the middle of the data, seen edge-on."""
        viewing = np.subtract(camera.GetFocalPoint(), camera.GetPosition())
        normal = _nearest_axis(np.cross(viewing, camera.GetViewUp()))
        size = np.ptp(self._bounds, axis=0).max()
        return Plane(self._bounds.mean(axis=0) + _OFFSET * size * normal, normal)

    def half_of(self, plane, camera):
        """The upper half of a plane in the view."""
        up = np.array(camera.GetViewUp())
        up = up - up @ plane.normal * plane.normal
        axis = _nearest_axis(up)
        is_in_plane = abs(axis @ plane.normal) < 0.9
        return HalfPlane(plane.point, plane.normal, axis if is_in_plane else up)

    def _update(self):
        is_enabled = super()._update()
        self._half.set_visible(is_enabled and isinstance(self._cut, HalfPlane))
        return is_enabled

    def _value(self):
        point, normal = np.array(self._plane.GetOrigin()), np.array(self._plane.GetNormal())
        if not isinstance(self._cut, HalfPlane):
            return Plane(point, normal)
        inward = self._cut.inward - self._cut.inward @ normal * normal
        if np.linalg.norm(inward) < 1e-3:  # tilted until the half-plane was along its new normal
            inward = np.cross(normal, self._cut.along)
        cut = HalfPlane(point, normal, inward)
        self._draw_sheet(cut)
        return cut

    def _draw_sheet(self, cut):
        """Fill all of a plane, or half of it."""
        is_half = isinstance(cut, HalfPlane)
        self._plane.GetPlaneProperty().SetOpacity(_MIN_OPACITY if is_half else _OPACITY)
        self._plane.GetSelectedPlaneProperty().SetOpacity(
            _GRABBED_MIN_OPACITY if is_half else _GRABBED_OPACITY
        )
        if is_half:
            self._half.show(cut)


class HalfSheet:
    """Draws a HalfPlane within a box with corners (2, 3)."""

    def __init__(self, scene, corners):
        self._actors, self._plane, self._rim = [], vtkPlane(), vtkPlane()
        spacing = np.maximum(np.ptp(corners, axis=0), 1e-9 * np.ptp(corners))
        box = configured(vtkImageData(), Dimensions=(2, 2, 2), Origin=corners[0], Spacing=spacing)
        sheet = configured(vtkCutter(), InputData=box, CutFunction=self._plane)
        port = sheet.GetOutputPort()
        half = configured(vtkClipPolyData(), InputConnection=port, ClipFunction=self._rim)
        edge = configured(vtkCutter(), InputConnection=port, CutFunction=self._rim)
        layers = (scene.renderer, _HALF_OPACITIES), (scene.overlay, _HIDDEN_OPACITIES)
        for renderer, opacities in layers:
            for source, color, opacity in zip((half, edge), (_BLUE, _RED), opacities):
                self._actors.append(polydata.unlit_actor(source, color, _EDGE_WIDTH, opacity))
                renderer.AddActor(self._actors[-1])
        self.set_visible(False)

    def show(self, cut):
        """Draw a HalfPlane."""
        for plane, normal in ((self._plane, cut.normal), (self._rim, cut.inward)):
            configured(plane, Origin=cut.point, Normal=normal)

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
