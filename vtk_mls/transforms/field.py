"""Displacement fields on grids."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.interpolation import linear_with_slopes
from vtk_mls.base.progress import SILENT
from vtk_mls.base.validation import freeze, single_precision
from vtk_mls.queries.inverses import newton
from vtk_mls.transforms.pointwise import PointwiseTransform

_CHUNK = 1 << 18  # points whose corners are in memory at once
_FOUND = 1e-6  # largest residual of an inverse, as a fraction of the size of the grid
_STAGES = 16  # of a search in which the displacement grows from 0 to its full value


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Field(PointwiseTransform):
    """A displacement field, interpolated linearly, as ITK's DisplacementFieldTransform has one.

    Parameters
    ----------
    displacement : (nz, ny, nx, 3) array_like, world units
        G(v) - v, from where material is to where it came from, as
        `Deformation.displacement_field` returns it. It is kept as float32.
    grid : Grid
        Of points v of the deformed space. The displacement at its border continues up to half a
        spacing outside; beyond that it is 0.

    Raises
    ------
    ValueError, TypeError
        If the displacements do not have the shape of the grid, or are not finite.
    """

    displacement: NDArray[np.float32]
    grid: Grid

    def __init__(self, displacement: ArrayLike, grid: Grid) -> None:
        shape = (*checked_grid("grid", grid).shape, 3)
        array = single_precision("displacement", displacement)
        if array.shape != shape:
            raise ValueError(
                f"`displacement` must have the shape of the grid, {shape}, got {array.shape}"
            )
        if not np.isfinite(array).all():
            raise ValueError(
                "`displacement` must be finite, "
                f"got {np.count_nonzero(~np.isfinite(array))} numbers that are not"
            )
        freeze(self, displacement=np.ascontiguousarray(array).view(), grid=grid)

    def __repr__(self) -> str:
        return f"<Field of {' x '.join(map(str, self.grid.dimensions))} points>"

    def _origins(self, points, progress):
        return points + self._displacement(points, progress)[0]

    def _jacobians(self, points, progress):
        return np.eye(3) + self._displacement(points, progress, with_slopes=True)[1]

    def _search(self, points, progress):
        x = points.astype(np.float64)
        # 1e-16 of a far point is more than the tolerance
        size = np.maximum(np.ptp(self.grid.corners(), axis=0).max(), np.abs(x).max(axis=1) / 1e3)
        solving, continuing = progress.divided(1, 1)
        solving.report(0)
        v, residual = self._solve(x, x - self._displacement(x)[0], size)
        rows = np.flatnonzero(~(residual <= _FOUND * size))
        rows = rows[np.isfinite(x[rows]).all(axis=1)]
        candidate = x[rows]
        for stage in continuing.over(range(1, _STAGES + 1)) if len(rows) else ():
            candidate, last = self._solve(x[rows], candidate, size[rows], stage / _STAGES)
        if len(rows):
            better = last < residual[rows]
            v[rows[better]], residual[rows[better]] = candidate[better], last[better]
        return v - x, residual <= _FOUND * size

    def _solve(self, x, v, size, factor=1.0):
        """v (m, 3) with v + `factor` d(v) = x, from the guess `v`; the residuals (m,)."""

        def evaluate(v, rows):
            displacement, slopes = self._displacement(v, with_slopes=True)
            return factor * displacement, lambda: np.eye(3) + factor * slopes

        return newton(evaluate, x, v, size)

    def _displacement(self, points, progress=SILENT, with_slopes=False):
        """d (m, 3) at `points` (m, 3), and its slopes (m, 3, 3) or None; 0 outside."""
        grid, result = self.grid, np.empty(points.shape)
        slopes: Any = np.empty((len(points), 3, 3)) if with_slopes else None
        for start in progress.over(range(0, len(points), _CHUNK)):
            part = slice(start, start + _CHUNK)
            index = grid.index_of(points[part])
            inside = grid.covers(index)
            within = np.where(inside[:, None], index, 0)
            values, per_index = linear_with_slopes(self.displacement, within, with_slopes)
            result[part] = np.where(inside[:, None], values, 0)
            if with_slopes:
                is_limited = (index < 0) | (index > np.array(grid.dimensions) - 1)
                per_index *= (inside[:, None] & ~is_limited)[:, None, :]
                np.einsum("mia,aj->mij", per_index, grid.world_to_index, out=slopes[part])
        return result, slopes
