"""The cut through everything."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.linear_algebra import dots
from vtk_mls.cuts.cut import Cut, direction, freeze, vector

if TYPE_CHECKING:
    from vtk_mls.handles.control_points import ControlPoints


@dataclass(frozen=True, eq=False)
class Plane(Cut):
    """A cut through everything: its two sides do not see each other.

    Parameters
    ----------
    point, normal : (3,) array_like, world coordinates
        Points on the plane itself belong to the side of `normal`.
    """

    point: NDArray[np.float64]
    normal: NDArray[np.float64]

    if TYPE_CHECKING:

        def __init__(self, point: ArrayLike, normal: ArrayLike) -> None: ...

    def __post_init__(self) -> None:
        freeze(self, point=vector("point", self.point), normal=direction("normal", self.normal))

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Signed distance (...) of points `x` (..., 3) from the plane, world units."""
        return dots(x - self.point, self.normal)

    def void_distance(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        side = np.where(self.height(v) < 0, -1, 1)
        return side * self.height(g)

    def away(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(self.height(v) < 0, -1, 1)[:, None] * self.normal

    def is_beside(self, x: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.ones(len(x), bool)

    def farthest(self, control_points: ControlPoints) -> float:
        return abs(self.height(control_points.centre)) / control_points.scale

    @property
    def plane(self) -> Plane | None:
        return self
