"""A plane in the view for the mouse: a cut, or half of one with its edge."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkFiltersSources import vtkLineSource
from vtkmodules.vtkInteractionWidgets import (
    vtkImplicitPlaneRepresentation,
    vtkImplicitPlaneWidget2,
)
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls import HalfPlane, Plane
from vtk_mls.linear_algebra import unit

_FACE, _EDGE = (0.35, 0.75, 1.0), (1.0, 0.45, 0.55)
_BESIDE = 0.01  # of the size: how far from the middle, where handles may be
_STEP = np.pi / 4  # by which a half-plane is turned in its plane


class CutWidget:
    """Lets the mouse move and tilt a flat cut.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
    renderer : vtkRenderer
    bounds : (2, 3)
        Corners of the data.
    moved, ended : callable
        Called with the cut while it is moved, and when the mouse lets it go.
    """

    def __init__(self, interactor, renderer, bounds, moved, ended):
        self._bounds, self._cut = bounds, None
        self._plane, self._widget = _representation(bounds), vtkImplicitPlaneWidget2()
        self._line, self._edge = vtkLineSource(), vtkActor()
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(self._line.GetOutputPort())
        self._edge.SetMapper(mapper)
        self._edge.PickableOff()
        self._edge.GetProperty().SetColor(_EDGE)
        self._edge.GetProperty().SetLineWidth(4)
        self._edge.GetProperty().LightingOff()
        self._edge.VisibilityOff()
        renderer.AddActor(self._edge)
        self._widget.SetInteractor(interactor)
        self._renderer = renderer
        self._widget.SetRepresentation(self._plane)
        self._widget.KeyPressActivationOff()
        for event, told in (("InteractionEvent", moved), ("EndInteractionEvent", ended)):
            self._widget.AddObserver(event, lambda *_, told=told: told(self._read()))

    def show(self, cut):
        """Show a Plane or a HalfPlane, or nothing for None."""
        self._cut = cut
        if (cut is not None) != bool(self._widget.GetEnabled()):
            self._enable(cut is not None)
        self._edge.SetVisibility(isinstance(cut, HalfPlane))
        if cut is not None:
            self._plane.SetOrigin(cut.point)
            self._plane.SetNormal(cut.normal)
            self._draw_edge(cut)

    def set_visible(self, is_visible):
        """Hide it, or show it again if there is a cut."""
        self._enable(is_visible and self._cut is not None)
        self._edge.SetVisibility(is_visible and isinstance(self._cut, HalfPlane))

    def first(self, camera):
        """A plane through the middle, which is seen from its end."""
        towards = np.subtract(camera.GetFocalPoint(), camera.GetPosition())
        normal = _along_axis(np.cross(towards, camera.GetViewUp()))
        size = np.ptp(self._bounds, axis=0).max()
        return Plane(self._bounds.mean(axis=0) + _BESIDE * size * normal, normal)

    def half(self, plane, camera):
        """The half of a plane that is up in the view."""
        up = np.array(camera.GetViewUp())
        up = up - up @ plane.normal * plane.normal
        along = _along_axis(up)
        is_good = abs(along @ plane.normal) < 0.9
        return HalfPlane(plane.point, plane.normal, along if is_good else up)

    def detach(self):
        """Leave the view."""
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)

    def _enable(self, is_enabled):
        # it forgets its renderer, and would take the one under the mouse
        self._widget.SetCurrentRenderer(self._renderer)
        self._widget.SetEnabled(is_enabled)

    def _read(self):
        """The cut where the widget is now."""
        point, normal = np.array(self._plane.GetOrigin()), np.array(self._plane.GetNormal())
        if not isinstance(self._cut, HalfPlane):
            return Plane(point, normal)
        inward = self._cut.inward - self._cut.inward @ normal * normal
        if np.linalg.norm(inward) < 1e-3:  # it was tilted onto its normal
            inward = np.cross(normal, self._cut.along)
        cut = HalfPlane(point, normal, inward)
        self._draw_edge(cut)
        return cut

    def _draw_edge(self, cut):
        if isinstance(cut, HalfPlane):
            reach = np.linalg.norm(np.ptp(self._bounds, axis=0)) / 2
            self._line.SetPoint1(cut.point - reach * cut.along)
            self._line.SetPoint2(cut.point + reach * cut.along)


def next_half(cut):
    """A half-plane with the same edge point, an eighth of a turn on in its plane."""
    inward = np.cos(_STEP) * cut.inward + np.sin(_STEP) * cut.along
    return HalfPlane(cut.point, cut.normal, inward)


def _along_axis(vector):
    """The unit vector along an axis that is nearest to a vector."""
    axis = np.abs(vector).argmax()
    return unit(np.eye(3)[axis] * (-1.0 if vector[axis] < 0 else 1.0))


def _representation(bounds):
    plane = vtkImplicitPlaneRepresentation()
    plane.SetPlaceFactor(1.1)
    plane.PlaceWidget(bounds.T.ravel())
    plane.OutlineTranslationOff()
    plane.OutsideBoundsOn()
    plane.ScaleEnabledOff()
    plane.SetDrawOutline(False)
    plane.GetPlaneProperty().SetColor(_FACE)
    plane.GetPlaneProperty().SetOpacity(0.18)
    plane.GetSelectedPlaneProperty().SetColor(_FACE)
    plane.GetSelectedPlaneProperty().SetOpacity(0.35)
    plane.SetEdgeColor(_FACE)
    plane.TubingOff()
    plane.GetNormalProperty().SetColor(_FACE)
    return plane
