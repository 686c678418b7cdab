"""Base of `Affine`, `Field` and `Chain`, which are evaluated point by point."""

from __future__ import annotations

from typing import Any

import numpy as np

from vtk_mls.base.progress import SILENT
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms import chain_engine

_SAMPLES = 9  # along each axis of a grid, of known positions


class PointwiseTransform(Transform):
    """A transform given by functions of points, all float64 and in world coordinates."""

    cuts: Any = ()
    in_rest_frame: Any = False
    device: Any = None
    regions = ()

    def _origins(self, points, progress):
        """G(v) (m, 3) at v of `points` (m, 3)."""
        raise NotImplementedError

    def _jacobians(self, points, progress):
        """dG_i/dv_j (m, 3, 3) at `points` (m, 3)."""
        raise NotImplementedError

    def _search(self, points, progress):
        """v - x (m, 3) with G(v) = x for x of `points` (m, 3), and whether it was found (m,).

        `points` are float32 or float64, and need not be finite.
        """
        raise NotImplementedError

    def _on_grid(self, grid, points, progress, with_jacobian):
        mapping, differentiating = progress.divided(1, with_jacobian)
        origins = self._origins(points, mapping)
        return origins, None, self._jacobians(points, differentiating) if with_jacobian else None

    @property
    def _engine(self):
        return chain_engine

    def _material_samples(self, grid):
        axes = [np.linspace(0, count - 1, _SAMPLES) for count in grid.dimensions]
        x = grid.at(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3))
        displacement, found = self._search(x, SILENT)
        return x[found], (x + displacement)[found]
