"""The widget that turns and moves a region: a box around it."""

import numpy as np
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkInteractionWidgets import vtkBoxRepresentation, vtkBoxWidget2

from vtk_mls.editor.drag_widget import DragWidget
from vtk_mls.vtk.objects import configured
from vtk_mls.vtk.transforms import matrix_of

_COLOR, _GRABBED_COLOR = (1.0, 0.78, 0.35), (1.0, 0.35, 0.45)
_WIDTH, _GRABBED_OPACITY = 2.5, 0.12  # of edges, and of the face that the mouse drags
_MARGIN = 0.08  # of the box around the region, relative to its longest side
_MIN_SIZE = 0.12  # of the box, relative to the data


class MotionWidget(DragWidget):
    """Lets the mouse turn a shape about its center by the faces of a box; Shift moves it."""

    def __init__(self, interactor, scene):
        self._min_size = _MIN_SIZE * np.ptp(scene.bounds, axis=0).max()
        self._shape, self._box = None, _representation()
        widget = configured(vtkBoxWidget2(), ScalingEnabled=False, MoveFacesEnabled=False)
        super().__init__(interactor, scene.overlay, widget, self._box)

    @property
    def _has_value(self):
        return self._shape is not None

    def show(self, shape, motion):
        """Show the box around the `bounds` of a shape after a motion (4, 4); nothing for None."""
        if shape is not self._shape and shape is not None:
            self._box.PlaceWidget(self._bounds_of(shape))
        self._shape = shape
        self._update()
        if shape is not None and not self._is_dragged:
            self._box.SetTransform(configured(vtkTransform(), Matrix=motion.ravel()))

    def _bounds_of(self, shape):
        low, high = shape.bounds
        margin = _MARGIN * (high - low).max()
        half = np.maximum((high - low) / 2 + margin, self._min_size / 2)
        middle = (low + high) / 2
        return np.stack([middle - half, middle + half], axis=1).ravel()

    def _value(self):
        """The motion (4, 4) of the box, exactly a rotation and a translation."""
        transform = vtkTransform()
        self._box.GetTransform(transform)
        motion = matrix_of(transform.GetMatrix())
        left, _, right = np.linalg.svd(motion[:3, :3])
        center = self._shape.bounds.mean(axis=0)
        moved = motion[:3, :3] @ center + motion[:3, 3]
        motion[:3, :3] = left @ right
        motion[:3, 3] = moved - motion[:3, :3] @ center
        return motion

    def _update(self):
        is_enabled = super()._update()
        if is_enabled:
            self._box.HandlesOff()  # those of faces would resize it
        return is_enabled


def _representation():
    box = configured(vtkBoxRepresentation(), PlaceFactor=1.0, OutlineCursorWires=False)
    box.HandlesOff()
    for outline, color in (
        (box.GetOutlineProperty(), _COLOR),
        (box.GetSelectedOutlineProperty(), _GRABBED_COLOR),
    ):
        configured(outline, Color=color, LineWidth=_WIDTH, Lighting=False)
    configured(box.GetSelectedFaceProperty(), Color=_GRABBED_COLOR, Opacity=_GRABBED_OPACITY)
    return box
