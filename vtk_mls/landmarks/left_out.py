"""Settings of a map, and predictions of each pair from the others.

A prediction is that of the map without the pair, at its q, in float64.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.linear_algebra import distances
from vtk_mls.base.progress import SILENT, Progress
from vtk_mls.deformation import Deformation
from vtk_mls.model.kinds.splines import precision, without_lone

_MAX_TEMPORARY = 1 << 19  # distances at a time


@dataclass(frozen=True)
class Settings:
    """Settings of a `Deformation`.

    Attributes
    ----------
    kind : str
    degree : int or None
        None for kinds without one.
    alpha, smoothing : float
        With alpha 0 all pairs weigh alike: one map for all; and of a spline it has no meaning.
    order : int or None
        Of a spline.
    softening : float
        Of a spline.
    """

    kind: str
    degree: int | None
    alpha: float
    smoothing: float = 0.0
    order: int | None = None
    softening: float = 0.0

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `Deformation`."""
        names = ["kind", "degree", "order", "alpha", "smoothing", "softening"]
        values = {name: getattr(self, name) for name in names}
        return {name: value for name, value in values.items() if value not in (None, 0)}

    @property
    def flags(self) -> str:
        """Options of `vtk-mls deform`."""
        values = self.options.items()
        texts = ((name, v if isinstance(v, str) else f"{v:.4g}") for name, v in values)
        return " ".join(f"--{name} {text}" for name, text in texts)


BASELINE = {kind: Settings(kind, None, 0.0) for kind in ("rigid", "affine")}


@dataclass(frozen=True, eq=False)
class PointPairs:
    """Pairs p, q (n, 3), world coordinates, with the weights (n,) of a `Deformation`."""

    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]
    weights: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.rest)

    def precision(self, settings: Settings) -> NDArray[np.float64]:
        """`splines.precision` for the settings of a spline."""
        lengths = settings.smoothing, settings.softening
        return precision(self.deformed, self.weights, settings.order, *lengths)

    def of_rows(self, rows: NDArray[np.int64]) -> PointPairs:
        return PointPairs(self.rest[rows], self.deformed[rows], self.weights[rows])


def predictions(
    pairs: PointPairs, rows: NDArray[np.int64], settings: Settings, progress: Progress = SILENT
) -> NDArray[np.float64]:
    """p (m, 3) of the pairs in `rows`, each from all others: G(q_i) of the map without pair i.

    World coordinates of the rest space. The q are distinct.
    """
    result, is_alone = pairs.rest.copy(), np.ones(len(pairs), bool)
    if settings.kind == "spline":
        matrix = pairs.precision(settings)
        diagonal = without_lone(matrix.diagonal())
        is_alone = np.isnan(diagonal)
        result -= matrix @ (pairs.rest - pairs.deformed) / diagonal[:, None]
    options = {**settings.options, "device": "reference"}
    for i in progress.over(rows[is_alone[rows]].tolist()):
        others = pairs.of_rows(np.delete(np.arange(len(pairs)), i))
        value = Deformation(others.rest, others.deformed, weights=others.weights, **options)
        result[i] = value.backward(pairs.deformed[i, None])[0]
    return result[rows]


def nearest(pairs: PointPairs, rows: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """The `count` pairs of `rows` with the nearest q to each pair, without itself: (n, k)."""
    count = min(count, len(rows) - 1)
    result = np.empty((len(pairs), count), np.int64)
    step = max(1, _MAX_TEMPORARY // len(rows))
    for start in range(0, len(pairs), step):
        part = np.arange(start, min(start + step, len(pairs)))
        apart = distances(pairs.deformed[part], pairs.deformed[rows])
        apart[part[:, None] == rows] = np.inf
        result[part] = rows[np.argpartition(apart, count - 1, axis=1)[:, :count]]
    return result
