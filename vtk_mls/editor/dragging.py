"""Where handles go that the mouse drags."""

from __future__ import annotations

import numpy as np

_SHORT = 0.15  # of a pixel for a pixel's length: a direction that is seen nearly from its end


class Drag:
    """A drag of some handles by one of them.

    Parameters
    ----------
    projection : Projection
    positions : (m, 3) float64, world coordinates
        Of the handles that move.
    grabbed : (3,)
        Position of the one that is held.
    pixel : (2,)
        Where the mouse took it.
    """

    def __init__(self, projection, positions, grabbed, pixel):
        self._projection, self._positions, self._grabbed = projection, positions, grabbed
        self._start = np.array(pixel, float)
        self._seen = projection.pixels(grabbed[None])[0]

    def in_view_plane(self, pixel):
        """New positions (m, 3): as far from the eye as before."""
        target = self._seen[:2] + np.asarray(pixel) - self._start
        return self._positions + self._projection.world(target, self._seen[2]) - self._grabbed

    def along(self, direction, pixel):
        """New positions along a unit vector, as far as the mouse has gone along it."""
        step = self._projection.size_of_a_pixel(self._grabbed[None])[0]
        tip = self._projection.pixels((self._grabbed + step * direction)[None])[0]
        shown = tip[:2] - self._seen[:2]
        length = np.linalg.norm(shown)
        if length < _SHORT:  # towards the eye: up is out
            shown, length = np.array([0.0, 1.0]), 1.0
        pixels = (np.asarray(pixel) - self._start) @ shown / length
        return self._positions + pixels / max(length, _SHORT) * step * direction

    def to(self, point):
        """New positions, the one that is held at a point."""
        return self._positions + point - self._grabbed
