"""The mouse over slices: it drags handles in them, moves and lays slices elsewhere."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor.dragging import Drag
from vtk_mls.editor.mouse import NEAR, PRIORITY


class SliceMouse:
    """Turns mouse events over `Slices` into edits; none of them reaches the camera.

    Parameters
    ----------
    interactor : vtkRenderWindowInteractor
    editor : Editor
    slices : Slices
    """

    def __init__(self, interactor, editor, slices):
        self._interactor, self._editor, self._slices = interactor, editor, slices
        self._pane = self._drag = None
        handlers = {
            "LeftButtonPressEvent": self._press,
            "MouseMoveEvent": self._move,
            "LeftButtonReleaseEvent": self._release,
            "MouseWheelForwardEvent": self._wheel,
            "MouseWheelBackwardEvent": self._wheel,
            **dict.fromkeys(("RightButtonPressEvent", "MiddleButtonPressEvent"), self._other),
        }
        self._tags = {
            event: interactor.AddObserver(event, what, PRIORITY + 1)
            for event, what in handlers.items()
        }

    def finish(self):
        """Let go of what is held."""
        is_dragging, self._drag, self._pane = self._drag is not None, None, None
        if is_dragging:
            self._editor.let_go()

    def detach(self):
        """Hear no more events."""
        for tag in self._tags.values():
            self._interactor.RemoveObserver(tag)

    @property
    def _pixel(self):
        return np.array(self._interactor.GetEventPosition(), float)

    def _press(self, interactor, event):
        pane = self._slices.pane_at(self._pixel)
        if pane is None:
            return
        self._editor.finish()
        self._pane = pane
        row = self._slices.nearest(pane, self._editor.state, self._pixel, NEAR)
        if row is None:
            self._editor.look_at(pane.point_at(self._pixel), is_moving=True)
        else:
            self._grab(row)
        self._abort(event)

    def _grab(self, row):
        editor, state = self._editor, self._editor.state
        if row not in editor.selected:
            editor.select([row])
        rows, at = np.asarray(editor.selected), state.deformed
        self._drag = Drag(self._pane.projection, at[rows], at[row], self._pixel)
        editor.take(rows, row)

    def _move(self, interactor, event):
        if self._drag is not None:
            self._editor.drag_to(self._drag.in_view_plane(self._pixel))
        elif self._pane is not None:
            self._editor.look_at(self._pane.point_at(self._pixel), is_moving=True)
        else:
            pane = None if self._is_camera_moving else self._slices.pane_at(self._pixel)
            if pane is None or self._editor.grabbed is not None:
                return
            row = self._slices.nearest(pane, self._editor.state, self._pixel, NEAR)
            self._editor.hover(row)
        self._abort(event)

    def _release(self, interactor, event):
        if self._pane is None:
            return
        was_looking = self._drag is None
        self.finish()
        if was_looking:
            self._editor.look_at(self._slices.point)
        self._abort(event)

    def _wheel(self, interactor, event):
        pane = self._slices.pane_at(self._pixel)
        if pane is not None:
            self._editor.look_at(self._slices.point_after(pane, 1 if "Forward" in event else -1))
            self._abort(event)

    def _other(self, interactor, event):
        if self._slices.pane_at(self._pixel) is not None:
            self._abort(event)

    @property
    def _is_camera_moving(self):
        return self._interactor.GetInteractorStyle().GetState() != 0

    def _abort(self, event):
        """Keep the event from the camera."""
        self._interactor.GetCommand(self._tags[event]).SetAbortFlag(True)
