"""The cut through everything."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vtk_mls.cuts.cut import Cut, direction, freeze, vector


@dataclass(frozen=True, eq=False)
class Plane(Cut):
    """A cut through everything: its two sides do not see each other.

    Parameters
    ----------
    point, normal : (3,) array_like, world coordinates
        Points on the plane itself belong to the side of `normal`.
    """

    point: np.ndarray
    normal: np.ndarray

    def __post_init__(self):
        freeze(self, point=vector("point", self.point), normal=direction("normal", self.normal))

    def height(self, x):
        """Signed distance (...) of places `x` (..., 3) from the plane, world units."""
        return (x - self.point) @ self.normal

    def void_distance(self, v, g):
        side = np.where(self.height(v) < 0, -1, 1)
        return side * self.height(g)

    def away(self, v, g):
        return np.where(self.height(v) < 0, -1, 1)[:, None] * self.normal

    def farthest(self, control_points):
        return abs(self.height(control_points.centre)) / control_points.scale

    @property
    def plane(self):
        return self
