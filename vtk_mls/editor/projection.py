"""Between the world and the pixels of a renderer, by numpy."""

from __future__ import annotations

import numpy as np


class Projection:
    """How a vtkRenderer projects now."""

    def __init__(self, renderer):
        camera, aspect = renderer.GetActiveCamera(), renderer.GetTiledAspectRatio()
        matrix = camera.GetCompositeProjectionTransformMatrix(aspect, -1, 1)
        self._matrix = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
        self._back = np.linalg.inv(self._matrix)
        self._size = np.array(renderer.GetSize(), float)
        self._origin = np.array(renderer.GetOrigin(), float)

    def pixels(self, points):
        """Pixels of the window and depths, which grow from -1 to 1 away from the eye: (n, 3).

        NaN for points (n, 3) behind the eye.
        """
        clip = np.c_[points, np.ones(len(points))] @ self._matrix.T
        with np.errstate(all="ignore"):
            seen = np.where(clip[:, 3:] > 0, clip[:, :3] / clip[:, 3:], np.nan)
        return np.c_[(seen[:, :2] + 1) / 2 * self._size + self._origin, seen[:, 2]]

    def world(self, pixel, depth):
        """The points (..., 3) that are seen at pixels (..., 2) at depths (...) as of `pixels`."""
        seen = 2 * (np.asarray(pixel, float) - self._origin) / self._size - 1
        depth = np.broadcast_to(depth, seen.shape[:-1])[..., None]
        clip = np.concatenate([seen, depth, np.ones(depth.shape)], axis=-1) @ self._back.T
        return clip[..., :3] / clip[..., 3:]

    def ray(self, pixel):
        """The near and the far end of what is seen at a pixel."""
        return self.world(pixel, -1.0), self.world(pixel, 1.0)

    def size_of_a_pixel(self, points):
        """World units that a pixel is high at each of `points` (n, 3): (n,)."""
        at = self.pixels(points)
        at = np.where(np.isfinite(at), at, 0)
        step = self.world(at[:, :2] + (0, 1), at[:, 2]) - self.world(at[:, :2], at[:, 2])
        return np.linalg.norm(step, axis=1)

    def nearest(self, points, pixel, within):
        """Row of the front one of the points seen at most so many pixels from `pixel`, or None."""
        at = self.pixels(points)
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(np.linalg.norm(at[:, :2] - pixel, axis=1) <= within)
        return int(rows[at[rows, 2].argmin()]) if len(rows) else None

    def between(self, points, corner, other):
        """Rows of the points that are seen in a rectangle of pixels."""
        low, high = np.minimum(corner, other), np.maximum(corner, other)
        at = self.pixels(points)[:, :2]
        return np.flatnonzero(((at >= low) & (at <= high)).all(axis=1))
