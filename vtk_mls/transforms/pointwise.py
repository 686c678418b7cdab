"""Transforms that are evaluated point by point: what `Affine`, `Field` and `Chain` share."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.grid import Grid
from vtk_mls.base.progress import SILENT, Progress
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms import engine


class PointwiseTransform(Transform):
    """A transform given by functions of points, all float64 and in world coordinates.

    Attributes
    ----------
    cuts : tuple of cuts
        Not empty if it may open voids.
    device : str or None
        That samples arrays, as of `Deformation`.
    """

    cuts: tuple[Any, ...] = ()
    in_rest_frame = False  # `origins` of Jacobians are not used
    device: str | None = None

    @abstractmethod
    def origins(self, points: NDArray[np.float64], progress: Progress) -> NDArray[np.float64]:
        """G(v) (m, 3) at v of `points` (m, 3), which need not be finite."""

    @abstractmethod
    def jacobians(self, points: NDArray[np.float64], progress: Progress) -> NDArray[np.float64]:
        """dG_i/dv_j (m, 3, 3) at `points` (m, 3)."""

    @abstractmethod
    def search(
        self, points: NDArray[np.float64], progress: Progress
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """v - x (m, 3) with G(v) = x for `points` (m, 3), and whether it was found (m,)."""

    def on_grid(
        self, grid: Grid, progress: Progress = SILENT, with_jacobian: bool = False
    ) -> tuple[NDArray[np.float64], NDArray[Any] | None, NDArray[Any] | None]:
        """Origins (m, 3), void distances (m,) or None, Jacobians (m, 3, 3) or None on a grid."""
        mapping, differentiating = progress.divided(1, 1)
        v = grid.points()
        jacobian = self.jacobians(v, differentiating) if with_jacobian else None
        return self.origins(v, mapping), None, jacobian

    @property
    def _engine(self):
        return engine
