"""Predictions of each pair from the others: the map without it, at its q, in float64."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.progress import SILENT, Progress
from vtk_mls.deformation import Deformation
from vtk_mls.landmarks.settings import Settings
from vtk_mls.model import kinds
from vtk_mls.model.kinds.kind import Kind
from vtk_mls.model.kinds.splines import precision, without_lone

_MAX_TEMPORARY = 1 << 21  # elements of an array
# Without one pair the others usually determine the same maps as all pairs, and the fit of all is
# reused. It is repeated for few pairs, and for pairs with a high leverage: 1 - leverage is the
# share of a function's norm that remains without the pair.
_MAX_REFITTED_PAIRS = 30
_MAX_LEVERAGE = 0.99


@dataclass(frozen=True, eq=False)
class PointPairs:
    """Pairs p, q (n, 3), world coordinates, with the weights (n,) of a `Deformation`."""

    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]
    weights: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.rest)

    def of_rows(self, rows: NDArray[np.int64]) -> PointPairs:
        return PointPairs(self.rest[rows], self.deformed[rows], self.weights[rows])


def predictions(
    pairs: PointPairs, rows: NDArray[np.int64], settings: Settings, progress: Progress = SILENT
) -> NDArray[np.float64]:
    """p (m, 3) of the pairs in `rows`, each from all others: G(q_i) of the map without pair i.

    World coordinates of the rest space. The q are distinct.
    """
    if settings.kind == "spline":
        return _spline_predictions(pairs, settings)[rows]
    kind = kinds.named(settings.kind, degree=settings.degree)
    points = _FittedPoints(pairs, kind)
    if len(pairs) <= _MAX_REFITTED_PAIRS:
        is_refitted = np.ones(len(rows), bool)
    else:
        is_refitted = _leverage(points)[rows] > _MAX_LEVERAGE
    result = np.empty((len(rows), 3))
    for part in progress.over(_parts(np.flatnonzero(~is_refitted), len(pairs), points)):
        result[part] = _predicted(points, rows[part], settings)
    for i in np.flatnonzero(is_refitted):
        others = np.delete(np.arange(len(pairs)), rows[i])
        points = _FittedPoints(pairs.of_rows(others), kind)
        weighted = _WeightedPairs(points, pairs.deformed[rows[i], None], settings)
        result[i] = pairs.deformed[rows[i]] + kind.fit(weighted).displacement[0]
    return result


def nearest(pairs: PointPairs, rows: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """The `count` pairs of `rows` with the nearest q to each pair, without itself: (n, k)."""
    count = min(count, len(rows) - 1)
    result = np.empty((len(pairs), count), np.int64)
    for part in _slices(np.arange(len(pairs)), 3 * len(rows)):
        offset = pairs.deformed[part, None] - pairs.deformed[rows]
        d2 = np.einsum("mna,mna->mn", offset, offset)
        d2[part[:, None] == rows] = np.inf
        result[part] = rows[np.argpartition(d2, count - 1, axis=1)[:, :count]]
    return result


def _spline_predictions(pairs, settings):
    matrix = precision(pairs.deformed, pairs.weights, settings.order, settings.smoothing)
    diagonal = without_lone(matrix.diagonal())[:, None]
    result = pairs.rest - matrix @ (pairs.rest - pairs.deformed) / diagonal
    for i in np.flatnonzero(np.isnan(diagonal)):
        p, q, weights = (np.delete(x, i, axis=0) for x in vars(pairs).values())
        options = {**settings.options, "weights": weights, "device": "reference"}
        result[i] = Deformation(p, q, **options).backward(pairs.deformed[i, None])[0]
    return result


def _predicted(points, rows, settings):
    v = points.pairs.deformed[rows]
    weighted = _WeightedPairs(points, v, settings, rows)
    return v + points.kind.fit(weighted).displacement


def _parts(rows, count, points):
    """Parts of `rows` whose temporary arrays with `count` pairs are small."""
    return [*_slices(rows, count * max(points.kind.functions(points) + 3, 6))]


def _slices(rows: NDArray[np.int64], elements_per_row: int) -> Iterator[NDArray[np.int64]]:
    step = max(1, _MAX_TEMPORARY // elements_per_row)
    for start in range(0, len(rows), step):
        yield rows[start : start + step]


def _leverage(points):
    """(n,): 1 for a pair without which the others determine fewer maps."""
    basis = kinds.named("polynomial", degree=points.kind.proxy_order).determined(points)
    return (1 + (basis.values**2).sum(axis=1)) / len(points.pairs)


class _FittedPoints:
    """Distinct control points for a `Kind`, without the merge of equal ones.

    Its attributes are those of `handles.control_points.ControlPoints`.
    """

    def __init__(self, pairs: PointPairs, kind: Kind):
        self.pairs, self.kind = pairs, kind
        self.center = pairs.deformed.mean(axis=0)
        self.scale = float(np.abs(pairs.deformed - self.center).max())
        self.positions = pairs.rest, pairs.deformed
        self.determined = kind.determined(self)

    def local(self, points):
        return (points - self.center) / self.scale


class _WeightedPairs:
    """Pairs weighted for points v (m, 3): the attributes of `reference.weights.WeightedPoints`.

    For each point, the pair in `rows` (m,) is left out, if they are given.
    """

    def __init__(self, points, v, settings, rows=None):
        self.control_points, self.v = points, v
        pairs = points.pairs
        offset = pairs.deformed - v[:, None]
        d2 = np.einsum("mia,mia->mi", offset, offset) + settings.smoothing**2
        index = np.arange(len(v))
        if rows is not None:
            d2[index, rows] = np.inf
        self.nearest = nearest = d2.argmin(axis=1)
        share = d2[index, nearest][:, None] / d2
        # alpha 0 is one map for all, in which the weight 0 of a pair left out is not 0^0
        self.w = pairs.weights * np.where(share > 0, share, 0) ** settings.alpha * (share > 0)
        self.p_k, self.q_k = pairs.rest[nearest], pairs.deformed[nearest]
        self.x = v - self.q_k
        p, q = pairs.rest - self.p_k[:, None], pairs.deformed - self.q_k[:, None]
        self.total = self.w.sum(axis=1)
        self.p_star, self.q_star = self._mean(p), self._mean(q)
        self.p, self.q = p - self.p_star[:, None], q - self.q_star[:, None]

    def values_of(self, basis):
        """As of `WeightedPoints`."""
        shape = (*self.w.shape, len(basis))
        return np.broadcast_to(basis.values, shape), basis.values[self.nearest]

    def _mean(self, values):
        return np.einsum("mi,mia->ma", self.w, values) / self.total[:, None]
