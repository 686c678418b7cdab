"""Settings of a map, predictions of each pair from the others, and pairs that do not fit these.

A prediction is that of the map without the pair, at its q, in float64. Pairs that do not fit are
outliers; some look as if their labels are swapped.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.linear_algebra import distances
from vtk_mls.base.progress import SILENT, Progress
from vtk_mls.deformation import Deformation
from vtk_mls.model.kinds.polynomials import RANK_TOLERANCE
from vtk_mls.model.kinds.splines import affine_basis, precision, without_lone
from vtk_mls.reference.weights import WeightedPoints

_MAX_TEMPORARY = 1 << 19  # distances at a time
_NEIGHBORS = 12  # their errors define the usual error at a place
# Limit of the error of a good pair, in usual errors; up to 1.4 times as large at the rim, where
# predictions extrapolate. Normal noise of each coordinate exceeds 2.7 medians once in 2,000 times.
_LIMIT, _EXACT_LIMIT, _RIM = 3.0, 5.0, 0.4
_SPREAD_QUANTILES = 0.2, 0.8  # of errors; their ratio is the spread, which few outliers change
# The largest spread of n errors by noise is _NOISE_SPREAD + _NOISE_SPREAD_OF_FEW / sqrt(n). Many
# normal errors have 2.3, those of 60 exact pairs of smooth maps as a rule 3 to 8.
_NOISE_SPREAD, _NOISE_SPREAD_OF_FEW = 2.3, 6.0
_MAX_SHARE = 1 / 3  # of the pairs that can be outliers
_ROUNDING = 1e-9  # of the extent of the pairs; smaller errors are ignored
# Largest distance from the prediction of a swapped pair to the other's place, in its own error.
_MAX_SWAP_RATIO = 0.5


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

    def deformation(self, settings: Settings, device: str | None = "reference") -> Deformation:
        options = {"weights": self.weights, "device": device, **settings.options}
        return Deformation(self.rest, self.deformed, **options)

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
    elif settings.kind != "polynomial":
        # those that alone determine an affine function
        is_alone = np.sum(affine_basis(pairs.deformed)[0] ** 2, axis=1) > 1 - RANK_TOLERANCE
        _predict_locally(pairs, rows[~is_alone[rows]], settings, result)
    for i in progress.over(rows[is_alone[rows]].tolist()):
        others = pairs.of_rows(np.delete(np.arange(len(pairs)), i))
        result[i] = others.deformation(settings).backward(pairs.deformed[i, None])[0]
    return result[rows]


def _predict_locally(pairs, rows, settings, result):
    """`predictions` by fits around each point, in which the weight of its pair is 0."""
    deformation, q = pairs.deformation(settings), pairs.deformed
    points = deformation.regions[0].control_points
    for part, _ in SILENT.chunks(len(rows), max(1, _MAX_TEMPORARY // len(pairs))):
        out = rows[part]
        is_other = (out[:, None] != np.arange(len(points))) | (len(points) == 1)
        handles = replace(points.handles, weights=is_other * points.handles.weights)
        weighted = WeightedPoints(deformation, replace(points, handles=handles), q[out])
        result[out] = q[out] + points.kind.fit(weighted).displacement


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


def find_outliers(
    pairs: PointPairs, settings: Settings, suspected: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """The outliers (n,), and p of each pair (n, 3) as predicted from the other pairs.

    The q are distinct; the settings are those of a spline. Outliers predict nothing, since they
    would spoil the predictions of their neighbors: the worst pair of each neighborhood is removed
    until all others are within the limit. Those `suspected` (n,) are left out at first. All
    follows from the equations solved once.

    An error is divided by its standard deviation as a Gaussian process has it, which is larger at
    the rim of the pairs and where they are sparse.
    """
    inliers = np.arange(len(pairs)) if suspected is None else np.flatnonzero(~suspected)
    min_count = len(pairs) - int(_MAX_SHARE * len(pairs))
    matrix = pairs.precision(settings)
    while True:
        neighbors = nearest(pairs, inliers, _NEIGHBORS)
        errors, variance = _left_out(matrix, pairs.rest - pairs.deformed, inliers)
        score = _score(pairs, errors, variance, inliers, neighbors)
        suspects = inliers[score[inliers] > 1]
        worst = suspects[score[suspects] >= score[neighbors[suspects]].max(axis=1)]
        worst = worst[np.argsort(-score[worst], kind="stable")][: max(0, len(inliers) - min_count)]
        if len(worst) == 0:
            return score > 1, pairs.rest - errors
        inliers = np.setdiff1d(inliers, worst)


def find_swapped(
    pairs: PointPairs, is_outlier: NDArray[np.bool_], predicted: NDArray[np.float64]
) -> NDArray[np.int64]:
    """The row (n,) of the outlier with which each outlier has exchanged its place, or -1."""
    result = np.full(len(pairs), -1)
    rows = np.flatnonzero(is_outlier)
    if len(rows) < 2:
        return result
    distance = np.linalg.norm(predicted[rows, None] - pairs.rest[rows], axis=2)
    own = distance.diagonal().copy()
    np.fill_diagonal(distance, np.inf)
    other = distance.argmin(axis=1)
    is_swapped = distance.min(axis=1) < _MAX_SWAP_RATIO * own
    is_swapped &= is_swapped[other] & (other[other] == np.arange(len(rows)))
    result[rows[is_swapped]] = rows[other[is_swapped]]
    return result


def _left_out(matrix, u, inliers):
    """Error (n, 3) of each pair as predicted from the other inliers, and its variance (n,).

    Both are 0 where a pair alone determines an affine function.
    """
    outliers = np.setdiff1d(np.arange(len(u)), inliers)
    errors, variance = np.zeros_like(u), np.ones(len(u))
    if len(outliers):
        # the equations without the outliers; then these, predicted from all others
        columns = matrix[:, outliers]
        inverse = np.linalg.pinv(columns[outliers])
        errors[outliers] = inverse @ (columns.T @ u)
        variance[outliers] = inverse.diagonal()
        matrix = matrix - columns @ inverse @ columns.T
    diagonal = without_lone(matrix.diagonal()[inliers])
    errors[inliers] = np.nan_to_num((matrix @ u)[inliers] / diagonal[:, None])
    variance[inliers] = np.nan_to_num(1 / diagonal, nan=1.0)
    return errors, variance


def _score(pairs, errors, variance, inliers, neighbors):
    """The error of each prediction (n,), relative to the limit."""
    relative = np.linalg.norm(errors, axis=1) / np.sqrt(variance)
    offset = pairs.deformed[neighbors] - pairs.deformed[:, None]
    reach = np.linalg.norm(offset, axis=2).mean(axis=1)
    # 0 amid the neighbors, 1 far from them
    rim = 1 + _RIM * (np.linalg.norm(offset.mean(axis=1), axis=1) / reach) ** 2
    usual = rim * np.sqrt(np.median(relative[neighbors], axis=1) * np.median(relative[inliers]))
    rounding = _ROUNDING * np.ptp(pairs.rest, axis=0).max() / np.sqrt(variance)
    low, high = np.quantile((relative / rim)[inliers], _SPREAD_QUANTILES)
    is_noise = high <= (_NOISE_SPREAD + _NOISE_SPREAD_OF_FEW / len(inliers) ** 0.5) * low
    return relative / ((_LIMIT if is_noise else _EXACT_LIMIT) * usual + rounding)
