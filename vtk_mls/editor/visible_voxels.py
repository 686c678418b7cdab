"""Where an image has something, as its look shows it."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor import looks

_SAMPLES = 64  # along each axis


class VisibleVoxels:
    """The points of an image that a look does not leave transparent, on a coarse grid.

    Parameters
    ----------
    grid : Grid
    values : (nz, ny, nx) array
    look : Look
    """

    def __init__(self, grid, values, look):
        self._grid = grid
        steps = [max(1, n // _SAMPLES) for n in grid.dimensions]
        some = values[tuple(slice(None, None, step) for step in steps[::-1])]
        is_seen = looks.opacity(look, some.ravel()) > 0
        index = np.argwhere(is_seen.reshape(some.shape))[:, ::-1]
        self._points = grid.at(index * steps)
        self._reach = float(np.abs(grid.spacing * steps).max())

    @property
    def bounds(self):
        """Corners (2, 3) of a box round them; without any, round the image."""
        points = self._points if len(self._points) else self._grid.corners()
        return np.array([points.min(axis=0), points.max(axis=0)])

    def nearest(self, points):
        """Those that are next to each of `points` (n, 3): (n, 3); points among them stay."""
        if len(self._points) == 0:
            return points
        found = np.array(points)
        for row, point in enumerate(points):
            squares = ((self._points - point) ** 2).sum(axis=1)
            if squares.min() > self._reach**2:
                found[row] = self._points[squares.argmin()]
        return found
