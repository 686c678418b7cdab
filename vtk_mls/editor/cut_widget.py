"""A plane in the view for the mouse: a cut, or half of one with its edge."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkInteractionWidgets import (
    vtkImplicitPlaneRepresentation,
    vtkImplicitPlaneWidget2,
)

from vtk_mls import HalfPlane, Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor.half_sheet import HalfSheet

_FACE, _BRIGHT = (0.35, 0.75, 1.0), (0.8, 0.93, 1.0)
_OPACITY, _GRASPED = 0.18, 0.35  # of the sheet
# Where half of it is drawn instead: VTK's mouse grasps nothing that is not there at all.
_UNSEEN, _FAINT = 0.004, 0.06
_MARGIN = 0.1  # of the size, by which the sheet is larger than the data
_BESIDE = 0.01  # of the size: how far from the middle, where handles may be
_STEP = np.pi / 4  # by which a half-plane is turned in its plane


class CutWidget:
    """Lets the mouse move and tilt a flat cut.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
    scene : Scene
        What is cut.
    moved, ended : callable
        Called with the cut while it is moved, and when the mouse lets it go.
    """

    def __init__(self, interactor, scene, moved, ended):
        self._bounds, self._cut, self._renderer = scene.bounds, None, scene.renderer
        beyond = _MARGIN / 2 * np.ptp(self._bounds, axis=0)
        corners = self._bounds + np.stack([-beyond, beyond])
        self._half = HalfSheet(scene.renderer, scene.overlay, corners)
        self._plane, self._widget = _representation(self._bounds), vtkImplicitPlaneWidget2()
        self._widget.SetInteractor(interactor)
        self._widget.SetRepresentation(self._plane)
        self._widget.KeyPressActivationOff()
        self._interactor, self._is_held = interactor, False
        self._moved, self._ended = moved, ended
        for event, what in (
            ("StartInteractionEvent", self._hold),
            ("InteractionEvent", self._move),
            ("EndInteractionEvent", self._let_go),
        ):
            self._widget.AddObserver(event, what)

    def show(self, cut):
        """Show a Plane or a HalfPlane, or nothing for None."""
        self._cut = cut
        if (cut is not None) != bool(self._widget.GetEnabled()):
            self._enable(cut is not None)
        self._half.set_visible(isinstance(cut, HalfPlane))
        if cut is not None:
            self._plane.SetOrigin(cut.point)
            self._plane.SetNormal(cut.normal)
            self._draw(cut)

    def finish(self):
        """Let go of it if the mouse holds it."""
        if self._is_held:
            # VTK's widget hears the mouse while it holds something, even if it is switched off
            self._interactor.InvokeEvent("LeftButtonReleaseEvent")

    def set_visible(self, is_visible):
        """Hide it, or show it again if there is a cut."""
        self._enable(is_visible and self._cut is not None)
        self._half.set_visible(is_visible and isinstance(self._cut, HalfPlane))

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
        self.finish()
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)

    def _hold(self, widget, event):
        self._is_held = True

    def _move(self, widget, event):
        self._moved(self._read())

    def _let_go(self, widget, event):
        self._is_held = False
        self._ended(self._read())

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
        self._draw(cut)
        return cut

    def _draw(self, cut):
        """Draw as a sheet what cuts: all of a plane, or half of it."""
        is_half = isinstance(cut, HalfPlane)
        self._plane.GetPlaneProperty().SetOpacity(_UNSEEN if is_half else _OPACITY)
        self._plane.GetSelectedPlaneProperty().SetOpacity(_FAINT if is_half else _GRASPED)
        if is_half:
            self._half.show(cut)


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
    plane.SetPlaceFactor(1 + _MARGIN)
    plane.PlaceWidget(bounds.T.ravel())
    plane.OutlineTranslationOff()
    plane.OutsideBoundsOn()
    plane.ScaleEnabledOff()
    plane.SetDrawOutline(False)
    plane.GetPlaneProperty().SetColor(_FACE)
    plane.GetSelectedPlaneProperty().SetColor(_FACE)
    plane.SetEdgeColor(_FACE)
    plane.TubingOff()
    plane.GetNormalProperty().SetColor(_FACE)
    plane.GetSelectedNormalProperty().SetColor(_BRIGHT)
    return plane
