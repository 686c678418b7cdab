"""The mouse over the handles: hovering, selecting, dragging."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor.dragging import Drag

PRIORITY = 10.0  # above interactor styles and widgets
NEAR = 9  # pixels from a handle's middle
_STILL = 3  # pixels that a click may move


class Mouse:
    """Turns mouse events of an interactor into edits; what is beside handles moves the camera."""

    def __init__(self, interactor, editor):
        self._interactor, self._editor = interactor, editor
        self._drag = self._band = self._pressed = None
        self._surfaces = self._normal = None
        self._tags = {
            event: interactor.AddObserver(event, what, PRIORITY)
            for event, what in (
                ("LeftButtonPressEvent", self._press),
                ("MouseMoveEvent", self._move),
                ("LeftButtonReleaseEvent", self._release),
                ("LeaveEvent", self._leave),
            )
        }

    @property
    def is_busy(self):
        """Whether it holds something."""
        return self._drag is not None or self._band is not None

    @property
    def pixel(self):
        """Where it is."""
        return np.array(self._interactor.GetEventPosition(), float)

    def finish(self):
        """Let go of what is held."""
        if self._drag is not None:
            self._drag = self._surfaces = self._normal = None
            self._editor.let_go()
        if self._band is not None:
            self._band = None
            self._editor.show_band(None)

    def detach(self):
        """Hear no more events."""
        self.finish()
        for tag in self._tags.values():
            self._interactor.RemoveObserver(tag)

    def _press(self, interactor, event):
        self.finish()
        self._pressed = self.pixel
        row = self._near()
        if self._editor.draw_line_to(self._pressed):
            pass
        elif row is not None:
            self._grab(row)
        elif interactor.GetControlKey():
            self._band = self._pressed
        else:
            return
        self._abort(event)

    def _grab(self, row):
        editor, state = self._editor, self._editor.state
        if not self._interactor.GetControlKey() and row not in editor.selected:
            editor.select([row])
        rows = np.union1d(editor.selected, [row])
        self._drag = Drag(editor.projection, state.deformed[rows], state.deformed[row], self.pixel)
        self._surfaces = editor.surfaces()
        editor.take(rows, row)

    def _move(self, interactor, event):
        if self._drag is not None:
            if np.linalg.norm(self.pixel - self._pressed) > _STILL:
                self._pressed = np.full(2, np.inf)  # it is no click
                with self._editor.telling():
                    self._editor.drag_to(self._positions())
        elif self._band is not None:
            self._editor.show_band((self._band, self.pixel))
        else:
            self._editor.hover(self._near())
            return
        self._abort(event)

    def _positions(self):
        """Where the handles go that are held."""
        editor, held = self._editor, self._drag
        if self._interactor.GetShiftKey():
            if self._normal is None:
                self._normal = self._surfaces.normal(editor.state.deformed[editor.grabbed])
            return held.along(self._normal, self.pixel)
        if self._interactor.GetControlKey():
            point = self._surfaces.hit(editor.projection, self.pixel)
            return held.in_view_plane(self.pixel) if point is None else held.to(point)
        return held.in_view_plane(self.pixel)

    def _release(self, interactor, event):
        if not self.is_busy:
            return
        is_click = np.linalg.norm(self.pixel - self._pressed) <= _STILL
        editor, band = self._editor, self._band
        grabbed = editor.grabbed
        self.finish()
        if band is not None:
            editor.select(editor.projection.between(editor.state.deformed, band, self.pixel))
        elif is_click and interactor.GetControlKey():
            editor.select(np.setxor1d(editor.selected, [grabbed]))
        self._abort(event)

    def _leave(self, interactor, event):
        if not self.is_busy:
            self._editor.hover(None)

    def _near(self):
        editor = self._editor
        return editor.projection.nearest(editor.state.deformed, self.pixel, NEAR)

    def _abort(self, event):
        """Keep the event from the camera."""
        self._interactor.GetCommand(self._tags[event]).SetAbortFlag(True)
