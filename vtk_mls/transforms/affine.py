"""Affine maps."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.linear_algebra import transformed
from vtk_mls.base.validation import finite, freeze
from vtk_mls.transforms.pointwise import PointwiseTransform


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Affine(PointwiseTransform):
    """An affine map of all space.

    Parameters
    ----------
    matrix : (4, 4) array_like
        From the undeformed to the deformed space, homogeneous, in world coordinates: the inverse of
        the matrix of an ITK transform that resamples images. Its last row is (0, 0, 0, 1).

    Raises
    ------
    ValueError, TypeError
        If the matrix has another shape or last row, is not finite, or has no inverse.
    """

    matrix: NDArray[np.float64]
    _inverse: NDArray[np.float64] = field(init=False)

    def __init__(self, matrix: ArrayLike) -> None:
        array = finite("matrix", matrix, (4, 4))
        if not np.array_equal(array[3], (0, 0, 0, 1)):
            raise ValueError(
                f"`matrix` must have the last row (0, 0, 0, 1), got {array[3].tolist()}"
            )
        if np.linalg.matrix_rank(array[:3, :3]) < 3:
            raise ValueError(f"`matrix` must be invertible, got {array[:3, :3].tolist()}")
        inverse = np.linalg.inv(array)
        inverse[3] = 0, 0, 0, 1
        freeze(self, matrix=array, _inverse=inverse)

    def __repr__(self) -> str:
        return f"<Affine {self.matrix[:3].tolist()}>"

    def _origins(self, points, progress):
        return points + _displacement(self._inverse, points)

    def _jacobians(self, points, progress):
        return np.tile(self._inverse[:3, :3], (len(points), 1, 1))

    def _search(self, points, progress):
        displacement = _displacement(self.matrix, points.astype(np.float64))
        return displacement, np.isfinite(displacement).all(axis=1)


def _displacement(matrix, points):
    """How far a matrix (4, 4) moves `points` (m, 3): exactly 0 for the identity."""
    return transformed(matrix[:3, :3] - np.eye(3), points) + matrix[:3, 3]
