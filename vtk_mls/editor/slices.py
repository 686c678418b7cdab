"""Three axis-aligned slices beside the 3-D view, through one point."""

import numpy as np

from vtk_mls.editor.shape_actors import moved_surface
from vtk_mls.editor.slice_pane import SlicePane

_VIEW_WIDTH = 0.66  # of the 3-D view beside slices, relative to the window
_MOVING_SAMPLES, _RESTING_SAMPLES = 112, 360  # along the longer side
_HANDLE_DISTANCE = 0.04  # from a slice, up to which it shows handles, relative to the data
_WHEEL_STEPS = 100  # through the data
_MAX_ZOOM = 200.0
# The panes that are shown: the 3-D view, it and all slices, or the slice across z, y, or x.
PANES = ONLY_3D, ALL, *SLICES = "3-D", "all", "axial", "coronal", "sagittal"
NO_NODES = np.zeros((0, 3))


class Slices:
    """Slices of the deformed data of a `Scene`.

    Attributes
    ----------
    pane : str, one of `PANES`
    zoom, center : float, and (3,) float64, world coordinates
        Magnification, and the middle of all slices.
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
        self._scene, self._panes, self.pane, self.regions = scene, [], ONLY_3D, []
        self._distortion, self.compared, self.drawn_nodes = distortion, [], NO_NODES
        self._home = self._viewport, self._layout = scene.renderer.GetViewport(), _column
        self.is_coarse = False
        self.set_bounds(scene.bounds)
        self.set_pane(self.first_pane)

    @property
    def first_pane(self):
        """The pane that is shown first: of flat images the only slice."""
        flat_axis = self._scene.flat_axis
        return ONLY_3D if flat_axis is None else SLICES[2 - flat_axis]

    @property
    def is_visible(self):
        """Whether any slice is shown."""
        return self.pane != ONLY_3D

    def set_pane(self, pane):
        """Show one of `PANES`, from the next `show` on."""
        self.pane, window = pane, self._scene.window
        for shown in self._panes:
            window.RemoveRenderer(shown.renderer)
        if self.is_visible and not self._panes:
            self._panes = [SlicePane(axis, self._bounds) for axis in (2, 1, 0)]
        view, *viewports = self._layout(self._viewport) if pane == ALL else [self._viewport] * 4
        for layer in self._scene.layers:
            layer.SetViewport(view)
            layer.SetDraw(pane not in SLICES)
        for shown, viewport in zip(self._visible_panes, viewports):
            window.AddRenderer(shown.renderer)
            shown.renderer.SetViewport(viewport)

    def arrange(self, viewport, layout, pane):
        """Put the 3-D view and the slices into another part of the window.

        `viewport` is (left, low, right, high), 0 to 1; `layout` takes it, and returns the viewports
        of the 3-D view and of three slices.
        """
        self._viewport, self._layout = viewport, layout
        self.set_pane(pane)

    def set_bounds(self, bounds):
        """Show another box (2, 3) in the slices, from its middle."""
        self.set_pane(ONLY_3D)
        self._bounds, self._panes, self.point = bounds, [], bounds.mean(axis=0)
        self.reset_zoom()

    def reset_zoom(self):
        """Fit the slices to the data, from the next `show` on."""
        self.zoom, self.center = 1.0, self._bounds.mean(axis=0)

    def zoom_at(self, pane, pixel, to, factor):
        """Zoom by a factor about a pixel of a pane, which moves to the pixel `to`."""
        zoom = float(np.clip(self.zoom * factor, 1 / _MAX_ZOOM, _MAX_ZOOM))
        center = pane.point_at(pixel) + (self.center - pane.point_at(to)) * self.zoom / zoom
        self.zoom, self.center = zoom, np.clip(center, *self._bounds)

    def restore(self):
        """Return to the initial part of the window, and to the data of the scene."""
        self.compared = []
        self.set_bounds(self._scene.bounds)
        self.arrange(*self._home, self.first_pane)

    def show(self, is_final):
        """Draw the deformed data; coarsely unless `is_final`."""
        samples = _RESTING_SAMPLES if is_final else _MOVING_SAMPLES
        panes, self.is_coarse = self._visible_panes, not is_final and self.is_visible
        surfaces = [moved_surface(region) for region in self.regions] if panes else []
        for pane in panes:
            items = self.compared or self._scene.items
            pane.look_at(self.center, self.zoom)
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
        return [pane for pane, name in zip(self._panes, SLICES) if self.pane in (ALL, name)]


def _column(viewport):
    """Three slices at the right side of the 3-D view."""
    left, low, right, high = viewport
    split, third = left + _VIEW_WIDTH * (right - left), (high - low) / 3
    tops = [high - index * third for index in range(3)]
    return (left, low, split, high), *((split, top - third, right, top) for top in tops)
