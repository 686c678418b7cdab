"""The projection of a renderer, and drags in it, in numpy."""

import numpy as np

from vtk_mls.vtk.transforms import matrix_of

_MIN_PIXELS = 0.15  # length of a projected pixel step, below which a direction points at the eye


class Projection:
    """The current projection of a vtkRenderer between world and window pixels."""

    def __init__(self, renderer):
        camera, aspect = renderer.GetActiveCamera(), renderer.GetTiledAspectRatio()
        matrix = camera.GetCompositeProjectionTransformMatrix(aspect, -1, 1)
        self._matrix = matrix_of(matrix)
        self._inverse = np.linalg.inv(self._matrix)
        self._size = np.array(renderer.GetSize(), float)
        self._origin = np.array(renderer.GetOrigin(), float)

    def pixels(self, points):
        """Pixels and depths (n, 3) of `points` (n, 3); NaN behind the eye.

        Depths grow from -1 to 1 away from the eye.
        """
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
