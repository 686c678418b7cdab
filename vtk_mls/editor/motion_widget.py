"""The widget that turns and moves a region: a box around it."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkInteractionWidgets import vtkBoxRepresentation, vtkBoxWidget2

_COLOR, _GRABBED_COLOR = (1.0, 0.78, 0.35), (1.0, 0.35, 0.45)
_WIDTH, _GRABBED_OPACITY = 2.5, 0.12  # of edges, and of the face that the mouse drags
_MARGIN = 0.08  # of the box around the region, relative to its longest side
_MIN_SIZE = 0.12  # of the box, relative to the data


class MotionWidget:
    """Lets the mouse turn a region about its center by the faces of a box; Shift moves it.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
    scene : Scene
    """

    def __init__(self, interactor, scene):
        self._renderer, self._interactor = scene.overlay, interactor
        self._min_size = _MIN_SIZE * np.ptp(scene.bounds, axis=0).max()
        self._shape, self._is_visible, self._is_held = None, True, False
        self._moved = self._released = None
        self._box, self._widget = _representation(), vtkBoxWidget2()
        self._widget.SetInteractor(interactor)
        self._widget.SetRepresentation(self._box)
        self._widget.ScalingEnabledOff()
        self._widget.MoveFacesEnabledOff()
        self._widget.KeyPressActivationOff()
        self._widget.AddObserver("StartInteractionEvent", self._on_start)
        self._widget.AddObserver("InteractionEvent", self._on_move)
        self._widget.AddObserver("EndInteractionEvent", self._on_end)

    def set_callbacks(self, moved, released):
        """Call `moved(motion)` at each movement of the mouse, and `released(motion)` at its end."""
        self._moved, self._released = moved, released

    def show(self, region):
        """Show the box around a RegionHandle, or nothing for None."""
        shape = None if region is None else region.shape
        if shape is not self._shape and shape is not None:
            self._box.PlaceWidget(self._bounds_of(shape))
        self._shape = shape
        self._update()
        if region is not None and not self._is_held:
            matrix, transform = vtkMatrix4x4(), vtkTransform()
            matrix.DeepCopy(region.motion.ravel())
            transform.SetMatrix(matrix)
            self._box.SetTransform(transform)

    def set_visible(self, is_visible):
        """Hide or show the widget."""
        self._is_visible = is_visible
        self._update()

    def finish(self):
        """Release the region if the mouse holds it."""
        if self._is_held:
            # the widget receives mouse events until the button is released, even if disabled
            self._interactor.InvokeEvent("LeftButtonReleaseEvent")

    def detach(self):
        """Remove the widget from the view."""
        self.finish()
        self._widget.SetEnabled(False)
        self._widget.SetInteractor(None)

    def _bounds_of(self, shape):
        low, high = shape.bounds
        margin = _MARGIN * (high - low).max()
        half = np.maximum((high - low) / 2 + margin, self._min_size / 2)
        middle = (low + high) / 2
        return np.stack([middle - half, middle + half], axis=1).ravel()

    def _on_start(self, widget, event):
        self._is_held = True

    def _on_move(self, widget, event):
        self._moved(self._motion())

    def _on_end(self, widget, event):
        self._is_held = False
        self._released(self._motion())

    def _motion(self):
        """The motion (4, 4) of the box, exactly a rotation and a translation."""
        transform = vtkTransform()
        self._box.GetTransform(transform)
        matrix = transform.GetMatrix()
        motion = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
        left, _, right = np.linalg.svd(motion[:3, :3])
        center = self._shape.bounds.mean(axis=0)
        moved = motion[:3, :3] @ center + motion[:3, 3]
        motion[:3, :3] = left @ right
        motion[:3, 3] = moved - motion[:3, :3] @ center
        return motion

    def _update(self):
        is_enabled = self._is_visible and self._shape is not None
        if is_enabled != bool(self._widget.GetEnabled()):
            # the widget forgets its renderer, and would take the one under the mouse
            self._widget.SetCurrentRenderer(self._renderer)
            self._widget.SetEnabled(is_enabled)
            self._box.HandlesOff()  # those of faces would resize it


def _representation():
    box = vtkBoxRepresentation()
    box.SetPlaceFactor(1.0)
    box.OutlineCursorWiresOff()
    box.HandlesOff()
    for outline, color in (
        (box.GetOutlineProperty(), _COLOR),
        (box.GetSelectedOutlineProperty(), _GRABBED_COLOR),
    ):
        outline.SetColor(color)
        outline.SetLineWidth(_WIDTH)
        outline.LightingOff()
    box.GetSelectedFaceProperty().SetColor(_GRABBED_COLOR)
    box.GetSelectedFaceProperty().SetOpacity(_GRABBED_OPACITY)
    return box
