"""Three axis-aligned slices beside the 3-D view, through one point."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor.shape_actors import moved_surface
from vtk_mls.editor.slice_pane import SlicePane

_VIEW_WIDTH = 0.66  # of the 3-D view beside slices, relative to the window
_MOVING_SAMPLES, _RESTING_SAMPLES = 112, 360  # along the longer side
_HANDLE_DISTANCE = 0.04  # from a slice, up to which it shows handles, relative to the data
_WHEEL_STEPS = 100  # through the data
NO_NODES = np.zeros((0, 3))


class Slices:
    """Slices of the deformed data of a `Scene`.

    Attributes
    ----------
    is_visible : bool
    point : (3,) float64, world coordinates
        Of all three slices.
    regions : list of RegionHandle
        Slices show their outlines.
    drawn_nodes : (k, 3) float64, world coordinates
        Nodes of a curve until it ends. Slices show those near.
    compared : list
        Items that replace those of the scene, unless it is empty; see `ComparedItem`.
    """

    def __init__(self, scene, distortion):
        self._scene, self._panes, self.is_visible, self.regions = scene, [], False, []
        self._distortion, self.compared, self.drawn_nodes = distortion, [], NO_NODES
        self._home = self._viewport, self._layout = scene.renderer.GetViewport(), _column
        self._bounds = scene.bounds
        self.point = self._bounds.mean(axis=0)

    def toggle(self):
        """Show or hide the slices."""
        self.set_visible(not self.is_visible)
        self.show(is_final=True)

    def set_visible(self, is_visible):
        """Show or hide the slices, from the next `show` on."""
        self.is_visible = is_visible
        if not self._panes:
            self._panes = [SlicePane(axis, self._bounds) for axis in (2, 1, 0)]
        view, *viewports = self._layout(self._viewport) if is_visible else [self._viewport]
        for renderer in (self._scene.renderer, self._scene.overlay):
            renderer.SetViewport(view)
        window = self._scene.window
        for pane in self._panes:
            window.RemoveRenderer(pane.renderer)
        for pane, viewport in zip(self._panes, viewports):
            pane.renderer.SetViewport(viewport)
            window.AddRenderer(pane.renderer)

    def arrange(self, viewport, layout, is_visible):
        """Put the 3-D view and the slices into another part of the window.

        `viewport` is (left, low, right, high), 0 to 1; `layout` takes it, and returns the viewports
        of the 3-D view and of three slices.
        """
        self._viewport, self._layout = viewport, layout
        self.set_visible(is_visible)

    def set_bounds(self, bounds):
        """Show another box (2, 3) in the slices, from its middle."""
        self.set_visible(False)
        self._bounds, self._panes = bounds, []
        self.point = bounds.mean(axis=0)

    def restore(self, bounds):
        """Return to the initial part of the window, for a box (2, 3); slices are hidden."""
        self.set_bounds(bounds)
        self.compared = []
        self.arrange(*self._home, False)

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
            items = self.compared or self._scene.items
            pane.show(items, surfaces, self.point, samples, self._distortion)

    def show_handles(self, positions, colors, are_visible, names=None):
        """Draw the handles that are near slices, from positions and colors (n, 3).

        `names` are n names and their n priorities, as of `Names`; None for none.
        """
        for pane in self._visible_panes:
            rows = self.rows_near(pane, positions)
            near = None if names is None else [np.array(column)[rows] for column in names]
            nodes = self.drawn_nodes[self.rows_near(pane, self.drawn_nodes)]
            pane.show_handles(positions[rows], colors[rows], are_visible, near, nodes)

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

    def move_to(self, point):
        """Move the slices to a point (3,), from the next `show` on."""
        self.point = np.clip(point, *self._bounds)

    def point_after(self, pane, count):
        """The point of the slices after `count` steps of the wheel over a pane."""
        size = np.ptp(self._bounds, axis=0)[pane.axis]
        return self.point + count * size / _WHEEL_STEPS * np.eye(3)[pane.axis]

    @property
    def _visible_panes(self):
        return self._panes if self.is_visible else []


def _column(viewport):
    """Three slices at the right side of the 3-D view."""
    left, low, right, high = viewport
    split, third = left + _VIEW_WIDTH * (right - left), (high - low) / 3
    tops = [high - index * third for index in range(3)]
    return (left, low, split, high), *((split, top - third, right, top) for top in tops)
