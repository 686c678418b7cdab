"""What one sees of a volume: where rays meet enough opacity."""

from __future__ import annotations

import numpy as np

from vtk_mls.editor import looks
from vtk_mls.interpolation import sample
from vtk_mls.linear_algebra import unit

_STEPS = 1000  # along a ray, at most
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
        low, high = self._box()
        first, last = _within(near, far, low, high)
        if first >= last:
            return None
        voxel = float(np.abs(self._grid.spacing).min())
        length = np.linalg.norm(far - near)
        count = int(np.clip(2 * (last - first) * length / voxel, 2, _STEPS))
        shares = np.linspace(first, last, count)
        thickness = (last - first) * length / count / float(np.abs(self._grid.spacing).mean())
        met = self._opacity_at(near + shares[:, None] * (far - near))
        total = 1 - np.cumprod((1 - met) ** thickness)
        if total[-1] < _LEAST:
            return None
        at = int(np.argmax(total >= min(_SEEN, total[-1] / 2)))
        return shares[at], near + shares[at] * (far - near)

    def normal(self, point):
        """The unit normal (3,) outwards of what is seen at a point; None where there is none."""
        reach = 2 * float(np.abs(self._grid.spacing).mean())
        steps = reach * np.concatenate([np.eye(3), -np.eye(3)])
        values = self._opacity_at(point + steps)
        slope = values[3:] - values[:3]
        return unit(slope) if slope.any() else None

    def _box(self):
        """Corners of a box that holds the deformed volume."""
        corners = self._grid.corners()
        if self._deformation is not None:
            size = np.ptp(corners, axis=0).max()
            moved = self._deformation.deformed
            corners = np.vstack([corners, moved - 0.2 * size, moved + 0.2 * size])
        return corners.min(axis=0), corners.max(axis=0)

    def _opacity_at(self, points):
        """Opacities of deformed space (n,)."""
        origins, is_void = points, False
        if self._deformation is not None:
            origins = self._deformation.backward(points)
            is_void = self._deformation.void(points) if self._deformation.cuts else False
        index = self._grid.index_of(origins)
        method = "nearest" if self._look.is_nearest else "linear"
        values = sample(self._values, index, method, 0, self._grid)
        return np.where(self._grid.covers(index) & ~is_void, looks.opacity(self._look, values), 0)


def _within(near, far, low, high):
    """Between which fractions of the segment from `near` to `far` it is in a box."""
    with np.errstate(all="ignore"):
        ends = np.array([(low - near), (high - near)]) / (far - near)
    ends = np.where(np.isfinite(ends), ends, [[-np.inf], [np.inf]])
    return max(0.0, ends.min(axis=0).max()), min(1.0, ends.max(axis=0).min())
