"""Pairs that do not fit the others, and pairs whose labels look swapped."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vtk_mls.landmarks.left_out import PointPairs, nearby_predictions, nearest
from vtk_mls.landmarks.settings import Settings

_MAX_PREDICTORS = 64  # the nearest pairs, from which each is predicted here
_NEIGHBORS = 12  # whose errors say what is usual at a place
# Limit of the error of a good pair, in usual errors: normal noise of each coordinate passes 2.7
# medians once in 2,000 times. At the rim of the pairs, where predictions extrapolate, the limit is
# larger, up to a factor of about 2.
_LIMIT = 3.0
_MAX_SHARE = 1 / 3  # of the pairs that can be outliers
_ROUNDING = 1e-9  # of the extent of the pairs: errors that do not matter
_CLEARLY = 0.5  # how much nearer, as a factor, a swapped pair is predicted to the other's place


def find(pairs: PointPairs, settings: Settings) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """The outliers (n,), and p of each pair (n, 3) as the pairs that are no outliers predict it.

    The worst pair of each neighborhood is taken out until all others are predicted within the
    limit, since an outlier also spoils the predictions of its neighbors.

    Parameters
    ----------
    pairs : PointPairs
        With distinct q.
    settings : Settings
    """
    kept = np.arange(len(pairs))
    min_count = len(pairs) - int(_MAX_SHARE * len(pairs))
    while True:
        neighbors = nearest(pairs, kept, _NEIGHBORS)
        predicted = nearby_predictions(pairs, nearest(pairs, kept, _MAX_PREDICTORS), settings)
        score = _score(pairs, predicted, kept, neighbors)
        suspects = kept[score[kept] > 1]
        worst = suspects[score[suspects] >= score[neighbors[suspects]].max(axis=1)]
        worst = worst[np.argsort(-score[worst], kind="stable")][: max(0, len(kept) - min_count)]
        if len(worst) == 0:
            return score > 1, predicted
        kept = np.setdiff1d(kept, worst)


def swapped(
    pairs: PointPairs, is_outlier: NDArray[np.bool_], predicted: NDArray[np.float64]
) -> NDArray[np.int64]:
    """The outlier whose place each outlier has, and which has its place: (n,) rows, -1 for none.

    Parameters
    ----------
    pairs : PointPairs
    is_outlier, predicted
        Of `find`.
    """
    result = np.full(len(pairs), -1)
    rows = np.flatnonzero(is_outlier)
    if len(rows) < 2:
        return result
    places = pairs.rest[rows]
    distance = np.linalg.norm(predicted[rows, None] - places, axis=2)
    own = distance.diagonal().copy()
    np.fill_diagonal(distance, np.inf)
    other = distance.argmin(axis=1)
    is_swapped = distance.min(axis=1) < _CLEARLY * own
    is_swapped &= is_swapped[other] & (other[other] == np.arange(len(rows)))
    result[rows[is_swapped]] = rows[other[is_swapped]]
    return result


def _score(pairs, predicted, kept, neighbors):
    """The error of each prediction (n,), relative to the limit."""
    error = np.linalg.norm(predicted - pairs.rest, axis=1)
    usual = np.sqrt(np.median(error[neighbors], axis=1) * np.median(error[kept]))
    offset = pairs.deformed[neighbors] - pairs.deformed[:, None]
    reach = np.linalg.norm(offset, axis=2).mean(axis=1)
    # 0 amid the neighbors, 1 far from them
    outside = np.linalg.norm(offset.mean(axis=1), axis=1) / reach
    rounding = _ROUNDING * np.ptp(pairs.rest, axis=0).max()
    return error / (_LIMIT * (1 + outside**2) * usual + rounding)
