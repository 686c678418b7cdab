"""Three slices beside the 3-D view, along the world's planes, through one point."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor.slice_pane import SlicePane

_SHARE = 0.66  # of the width that the 3-D view keeps
_MOVING, _RESTING = 112, 360  # samples along the longest side
_REACH = 0.04  # of the size of the data: handles as near as this to a slice are in it
_STEPS = 100  # of the wheel, through all of the data


class Slices:
    """Slices of what a `Scene` shows, deformed as it is.

    Attributes
    ----------
    is_visible : bool
    point : (3,) float64, world coordinates
        Through which they go.
    """

    def __init__(self, scene):
        self._scene, self._panes, self.is_visible = scene, [], False
        self._viewport = scene.renderer.GetViewport()
        self._bounds, self._marks = scene.bounds, None
        self.point = self._bounds.mean(axis=0)

    def toggle(self):
        """Show them, or the 3-D view alone."""
        self.is_visible = not self.is_visible
        left, low, right, high = self._viewport
        split = left + _SHARE * (right - left) if self.is_visible else right
        for renderer in (self._scene.renderer, self._scene.overlay):
            renderer.SetViewport(left, low, split, high)
        if not self._panes:
            self._panes = [SlicePane(axis, self._bounds) for axis in (2, 1, 0)]
        for number, pane in enumerate(self._panes):
            top, third = high - (high - low) * number / 3, (high - low) / 3
            pane.renderer.SetViewport(split, top - third, right, top)
            if self.is_visible:
                self._scene.window.AddRenderer(pane.renderer)
            else:
                self._scene.window.RemoveRenderer(pane.renderer)
        self.show(is_final=True)

    def detach(self):
        """Leave the window to the 3-D view."""
        if self.is_visible:
            self.toggle()

    def show(self, is_final):
        """Draw the data as they are deformed now."""
        for pane in self._panes if self.is_visible else ():
            pane.show(self._scene.shown, self.point, _RESTING if is_final else _MOVING)

    def mark(self, marks):
        """Draw the handles that are near each: `Marks`."""
        self._marks = marks
        for pane in self._panes if self.is_visible else ():
            pane.mark(marks, self._near(pane, marks.state))

    def pane_at(self, pixel):
        """The `SlicePane` that is seen at a pixel; None in the 3-D view."""
        for pane in self._panes if self.is_visible else ():
            if pane.renderer.IsInViewport(*map(int, pixel)):
                return pane
        return None

    def nearest(self, pane, state, pixel, within):
        """Row of the handle of a slice that is seen at a pixel, or None."""
        rows = self._near(pane, state)
        found = pane.projection.nearest(state.deformed[rows], pixel, within)
        return None if found is None else int(rows[found])

    def move_to(self, point, is_final=True):
        """Go through another point."""
        self.point = np.clip(point, *self._bounds)
        self.show(is_final)
        if self._marks is not None:
            self.mark(self._marks)

    def point_after(self, pane, count):
        """The point to go through when one of them is moved by so many steps of the wheel."""
        size = np.ptp(self._bounds, axis=0)[pane.axis]
        return self.point + count * size / _STEPS * np.eye(3)[pane.axis]

    def _near(self, pane, state):
        """Rows of the handles that are in a slice."""
        reach = _REACH * np.ptp(self._bounds, axis=0).max()
        return np.flatnonzero(np.abs(state.deformed - self.point)[:, pane.axis] <= reach)
