"""The projection of a renderer, in numpy."""

import numpy as np

from vtk_mls.vtk.transforms import matrix_of


class Projection:
    """The current projection of a vtkRenderer between world and window pixels."""

    def __init__(self, renderer):
        camera, aspect = renderer.GetActiveCamera(), renderer.GetTiledAspectRatio()
        self._matrix = matrix_of(camera.GetCompositeProjectionTransformMatrix(aspect, -1, 1))
        self._inverse = np.linalg.inv(self._matrix)
        self._size = np.array(renderer.GetSize(), float)
        self._origin = np.array(renderer.GetOrigin(), float)

    def pixels(self, points):
        """Pixels and depths (n, 3) of `points` (n, 3), -1 to 1 away from the eye; NaN behind it."""
        clip = np.c_[points, np.ones(len(points))] @ self._matrix.T
        with np.errstate(all="ignore"):
            visible = np.where(clip[:, 3:] > 0, clip[:, :3] / clip[:, 3:], np.nan)
        return np.c_[(visible[:, :2] + 1) / 2 * self._size + self._origin, visible[:, 2]]

    def world(self, pixel, depth):
        """The points (..., 3) at pixels (..., 2) and depths (...)."""
        at = 2 * (np.asarray(pixel, float) - self._origin) / self._size - 1
        depth = np.broadcast_to(depth, at.shape[:-1])[..., None]
        clip = np.concatenate([at, depth, np.ones(depth.shape)], axis=-1) @ self._inverse.T
        return clip[..., :3] / clip[..., 3:]

    def ray(self, pixel):
        """The nearest and the farthest visible point (3,) at a pixel."""
        return self.world(pixel, -1.0), self.world(pixel, 1.0)

    def pixel_size(self, points):
        """Height (n,) of a pixel in world units at `points` (n, 3)."""
        at = self.pixels(points)
        at = np.where(np.isfinite(at), at, 0)
        step = self.world(at[:, :2] + (0, 1), at[:, 2]) - self.world(at[:, :2], at[:, 2])
        return np.linalg.norm(step, axis=1)

    def nearest(self, points, pixel, max_distance):
        """Row of the foremost of the points within `max_distance` pixels of `pixel`, or None."""
        at = self.pixels(points)
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(np.linalg.norm(at[:, :2] - pixel, axis=1) <= max_distance)
        return int(rows[at[rows, 2].argmin()]) if len(rows) else None

    def between(self, points, corner, opposite):
        """Rows of the points in a rectangle of pixels."""
        low, high = np.minimum(corner, opposite), np.maximum(corner, opposite)
        at = self.pixels(points)[:, :2]
        return np.flatnonzero(((at >= low) & (at <= high)).all(axis=1))
