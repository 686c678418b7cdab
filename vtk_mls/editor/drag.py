"""Drags of handles in the projection of a renderer."""

import numpy as np

_MIN_PIXELS = 0.15  # length of a projected pixel step, below which a direction points at the eye


class Drag:
    """A drag of handles at positions (m, 3) by one at `grabbed` (3,), from a pixel of the mouse."""

    def __init__(self, projection, positions, grabbed, pixel):
        self._projection, self._positions, self._grabbed = projection, positions, grabbed
        self._start = np.array(pixel, float)
        self._grabbed_pixel = projection.pixels(grabbed[None])[0]

    def in_view_plane(self, pixel):
        """New positions (m, 3) at the same depth."""
        target = self._grabbed_pixel[:2] + np.asarray(pixel) - self._start
        depth = self._grabbed_pixel[2]
        return self._positions + self._projection.world(target, depth) - self._grabbed

    def along(self, direction, pixel):
        """New positions along a unit vector, as far as the mouse has moved along it."""
        step = self._projection.pixel_size(self._grabbed[None])[0]
        tip = self._projection.pixels((self._grabbed + step * direction)[None])[0]
        projected = tip[:2] - self._grabbed_pixel[:2]
        length = np.linalg.norm(projected)
        if length < _MIN_PIXELS:  # towards the eye: up is outwards
            projected, length = np.array([0.0, 1.0]), 1.0
        pixels = (np.asarray(pixel) - self._start) @ projected / length
        return self._positions + pixels / max(length, _MIN_PIXELS) * step * direction

    def to(self, point):
        """New positions, with the grabbed handle at a point (3,)."""
        return self._positions + point - self._grabbed
