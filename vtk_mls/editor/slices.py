"""Three axis-aligned slices beside the 3-D view, through one point."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor.shape_actors import moved_surface
from vtk_mls.editor.slice_pane import SlicePane

_VIEW_WIDTH = 0.66  # of the 3-D view beside slices, relative to the window
_MOVING_SAMPLES, _RESTING_SAMPLES = 112, 360  # along the longer side
_HANDLE_DISTANCE = 0.04  # from a slice, up to which it shows handles, relative to the data
_WHEEL_STEPS = 100  # through the data


class Slices:
    """Slices of the deformed data of a `Scene`.

    Attributes
    ----------
    is_visible : bool
    point : (3,) float64, world coordinates
        Of all three slices.
    regions : list of RegionHandle
        Slices show their outlines.
    """

    def __init__(self, scene, distortion):
        self._scene, self._panes, self.is_visible, self.regions = scene, [], False, []
        self._distortion = distortion
        self._viewport = scene.renderer.GetViewport()
        self._bounds = scene.bounds
        self.point = self._bounds.mean(axis=0)

    def toggle(self):
        """Show or hide the slices."""
        self.is_visible = not self.is_visible
        left, low, right, high = self._viewport
        split = left + _VIEW_WIDTH * (right - left) if self.is_visible else right
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
        """Hide the slices."""
        if self.is_visible:
            self.toggle()

    def show(self, is_final):
        """Draw the deformed data; coarsely unless `is_final`."""
        samples = _RESTING_SAMPLES if is_final else _MOVING_SAMPLES
        panes = self._visible_panes
        surfaces = [moved_surface(region) for region in self.regions] if panes else []
        for pane in panes:
            pane.show(self._scene.items, surfaces, self.point, samples, self._distortion)

    def show_handles(self, positions, colors, are_visible):
        """Draw the handles that are near slices, from positions and colors (n, 3)."""
        for pane in self._visible_panes:
            rows = self.rows_near(pane, positions)
            pane.show_handles(positions[rows], colors[rows], are_visible)

    def pane_at(self, pixel):
        """The `SlicePane` at a pixel; None in the 3-D view."""
        for pane in self._visible_panes:
            if pane.renderer.IsInViewport(*map(int, pixel)):
                return pane
        return None

    def rows_near(self, pane, positions):
        """Rows of the positions (n, 3) near a slice."""
        distance = _HANDLE_DISTANCE * np.ptp(self._bounds, axis=0).max()
        return np.flatnonzero(np.abs(positions - self.point)[:, pane.axis] <= distance)

    def move_to(self, point, is_final=True):
        """Move the slices to a point (3,)."""
        self.point = np.clip(point, *self._bounds)
        self.show(is_final)

    def point_after(self, pane, count):
        """The point of the slices after `count` steps of the wheel over a pane."""
        size = np.ptp(self._bounds, axis=0)[pane.axis]
        return self.point + count * size / _WHEEL_STEPS * np.eye(3)[pane.axis]

    @property
    def _visible_panes(self):
        return self._panes if self.is_visible else []
