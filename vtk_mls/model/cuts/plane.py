"""The unbounded plane cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.linear_algebra import dots
from vtk_mls.base.validation import freeze, vector
from vtk_mls.model.cuts.cut import Cut, direction
from vtk_mls.model.handles.control_points import ControlPoints


@dataclass(frozen=True, eq=False, init=False)
class Plane(Cut):
    """An unbounded cut: control points on one side do not act on the other.

    Parameters
    ----------
    point, normal : (3,) array_like, world coordinates
        Points on the plane itself belong to the side of `normal`.
    """

    point: NDArray[np.float64]
    normal: NDArray[np.float64]

    name = "plane"
    help = "A plane divides everything."

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        freeze(self, point=vector("point", point), normal=direction("normal", normal))

    def height(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Signed distance (...) of points `x` (..., 3) from the plane, world units."""
        return dots(x - self.point, self.normal)

    def void_distance(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        side = np.where(self.height(v) < 0, -1, 1)
        return side * self.height(g)

    def away(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(self.height(v) < 0, -1, 1)[:, None] * self.normal

    def farthest(self, control_points: ControlPoints) -> float:
        return float(abs(self.height(control_points.center)) / control_points.scale)

    @property
    def plane(self) -> Plane | None:
        return self
