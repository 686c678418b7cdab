"""What one sees of a volume: where rays meet enough opacity."""

from __future__ import annotations

import numpy as np

from vtk_mls.base.interpolation import sample
from vtk_mls.base.linear_algebra import unit
from vtk_mls.editor import looks
from vtk_mls.rendering.volume_ray import light_along

_STEP = 0.5  # along a ray, of the smallest spacing
_SEEN = 0.5  # opacity that rays have met at the surface that one sees
_LEAST = 0.05  # or, of less, the half of it


class VolumeSurface:
    """The visible surface of a deformed volume.

    Parameters
    ----------
    grid : Grid
    values : (nz, ny, nx) array
    look : Look
    deformation : Deformation or None
    """

    def __init__(self, grid, values, look, deformation):
        self._grid, self._values, self._look = grid, values, look
        self._deformation = deformation

    def hit(self, near, far):
        """Where the ray from `near` to `far` (3,) meets it: (fraction, point), or None."""
        spacing = np.abs(self._grid.spacing)
        ends, step = np.stack([near, far]), _STEP * spacing.min()
        found = light_along(self._opacity_at, ends, self._box(), step, spacing.mean())
        if found is None:
            return None
        t, met = found[0], 1 - found[1]
        if met[-1] < _LEAST:
            return None
        share = np.interp(min(_SEEN, met[-1] / 2), met, t)
        return share, near + share * (far - near)

    def normal(self, point):
        """The unit normal (3,) outwards of what is seen at a point; None where there is none."""
        reach = 2 * float(np.abs(self._grid.spacing).mean())
        steps = reach * np.concatenate([np.eye(3), -np.eye(3)])
        values = self._opacity_at(point + steps)
        slope = values[3:] - values[:3]
        return unit(slope) if slope.any() else None

    def _box(self):
        """Corners (2, 3) of a box that holds the deformed volume."""
        corners = self._grid.corners()
        if self._deformation is not None:
            size = np.ptp(corners, axis=0).max()
            moved = self._deformation.deformed
            corners = np.vstack([corners, moved - 0.2 * size, moved + 0.2 * size])
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def at(self, points):
        """Which points (n, 3) of deformed space have material, and values (n,) there."""
        origins, is_void = points, False
        if self._deformation is not None:
            origins = self._deformation.backward(points)
            is_void = self._deformation.void(points) if self._deformation.cuts else False
        index = self._grid.index_of(origins)
        method = "nearest" if self._look.is_nearest else "linear"
        values = sample(self._values, index, method, 0, self._grid)
        return self._grid.covers(index) & ~np.asarray(is_void), values

    def _opacity_at(self, points):
        """Opacities of deformed space (n,)."""
        is_there, values = self.at(points)
        return np.where(is_there, looks.opacity(self._look, values), 0)
