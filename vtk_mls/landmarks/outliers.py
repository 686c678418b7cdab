"""Pairs that do not fit the others, and pairs whose labels look swapped."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vtk_mls.landmarks.left_out import PointPairs, nearby_predictions, nearest, remainders
from vtk_mls.landmarks.settings import Settings

_MAX_PREDICTORS = 64  # the nearest pairs, from which each is predicted here
_NEIGHBORS = 12  # their errors define the usual error at a place
# Limit of the error of a good pair, in usual errors. Normal noise of each coordinate exceeds 2.7
# medians once in 2,000 times. At the rim of the pairs, where predictions extrapolate, the limit is
# up to twice as large.
_LIMIT = 3.0
# Errors of exact pairs must exceed both limits: in usual errors, and in usual errors relative to
# the remainder.
_EXACT_LIMIT, _REMAINDER_LIMIT = 5.0, 1.25
_SPREAD_QUANTILES = 0.2, 0.8  # of errors; their ratio is the spread, which few outliers change
# The largest spread of n errors by noise is _NOISE_SPREAD + _NOISE_SPREAD_OF_FEW / sqrt(n). Many
# normal errors have 2.3, those of 60 exact pairs of smooth maps as a rule 3 to 8.
_NOISE_SPREAD, _NOISE_SPREAD_OF_FEW = 2.3, 6.0
_MAX_SHARE = 1 / 3  # of the pairs that can be outliers
_ROUNDING = 1e-9  # of the extent of the pairs; smaller errors are ignored
# Largest distance from the prediction of a swapped pair to the other's place, in its own error.
_MAX_SWAP_RATIO = 0.5


def find(pairs: PointPairs, settings: Settings) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """The outliers (n,), and p of each pair (n, 3) as predicted from the other pairs.

    The q are distinct. Outliers predict nothing, since they would spoil the predictions of their
    neighbors: the worst pair of each neighborhood is removed until all others are within the limit.
    """
    inliers = np.arange(len(pairs))
    min_count = len(pairs) - int(_MAX_SHARE * len(pairs))
    while True:
        neighbors = nearest(pairs, inliers, _NEIGHBORS)
        predictors = nearest(pairs, inliers, _MAX_PREDICTORS)
        predicted = nearby_predictions(pairs, predictors, settings)
        remainder = remainders(pairs, predictors, settings)
        score = _score(pairs, predicted, remainder, inliers, neighbors)
        suspects = inliers[score[inliers] > 1]
        worst = suspects[score[suspects] >= score[neighbors[suspects]].max(axis=1)]
        worst = worst[np.argsort(-score[worst], kind="stable")][: max(0, len(inliers) - min_count)]
        if len(worst) == 0:
            return score > 1, predicted
        inliers = np.setdiff1d(inliers, worst)


def swapped(
    pairs: PointPairs, is_outlier: NDArray[np.bool_], predicted: NDArray[np.float64]
) -> NDArray[np.int64]:
    """The outlier with which each outlier of `find` has exchanged its place: (n,) rows, or -1."""
    result = np.full(len(pairs), -1)
    rows = np.flatnonzero(is_outlier)
    if len(rows) < 2:
        return result
    places = pairs.rest[rows]
    distance = np.linalg.norm(predicted[rows, None] - places, axis=2)
    own = distance.diagonal().copy()
    np.fill_diagonal(distance, np.inf)
    other = distance.argmin(axis=1)
    is_swapped = distance.min(axis=1) < _MAX_SWAP_RATIO * own
    is_swapped &= is_swapped[other] & (other[other] == np.arange(len(rows)))
    result[rows[is_swapped]] = rows[other[is_swapped]]
    return result


def _score(pairs, predicted, remainder, inliers, neighbors):
    """The error of each prediction (n,), relative to the limit.

    Errors of noisy pairs are alike amid the others. Those of exact pairs grow like the remainder,
    and spread more: most are small, and a few are large where pairs are sparse or the map bends.
    """
    error = np.linalg.norm(predicted - pairs.rest, axis=1)
    offset = pairs.deformed[neighbors] - pairs.deformed[:, None]
    reach = np.linalg.norm(offset, axis=2).mean(axis=1)
    # 0 amid the neighbors, 1 far from them
    outside = np.linalg.norm(offset.mean(axis=1), axis=1) / reach
    rim = 1 + outside**2
    rounding = _ROUNDING * np.ptp(pairs.rest, axis=0).max()

    def usual(errors):
        return np.sqrt(np.median(errors[neighbors], axis=1) * np.median(errors[inliers]))

    limit = rim * usual(error)
    low, high = np.quantile((error / rim)[inliers], _SPREAD_QUANTILES)
    if high <= (_NOISE_SPREAD + _NOISE_SPREAD_OF_FEW / len(inliers) ** 0.5) * low:
        return error / (_LIMIT * limit + rounding)
    relative_limit = _REMAINDER_LIMIT * remainder * usual(error / remainder)
    return error / (np.maximum(_EXACT_LIMIT * limit, relative_limit) + rounding)
