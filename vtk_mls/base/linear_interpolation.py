"""Linear interpolation with slopes, of the small images that handles and masks are made of."""

from __future__ import annotations

import numpy as np


def linear(values, index):
    """Values (m,) at indices (m, 3) = (i, j, k) of an array (nz, ny, nx), and slopes (m, 3).

    Indices are limited to the array. Slopes are per index.
    """
    last = np.array(values.shape[::-1]) - 1
    index = np.clip(index, 0, last)
    cell = np.minimum(np.floor(index).astype(np.int64), np.maximum(last - 1, 0))
    share = index - cell
    result, slope = np.zeros(len(index)), np.zeros((len(index), 3))
    for corner in np.ndindex(2, 2, 2):
        at = np.minimum(cell + corner, last)
        tap = values[at[:, 2], at[:, 1], at[:, 0]].astype(np.float64)
        weights = np.where(corner, share, 1 - share)
        result += weights.prod(axis=1) * tap
        for axis in range(3):
            others = np.delete(weights, axis, axis=1).prod(axis=1)
            slope[:, axis] += (1 if corner[axis] else -1) * others * tap
    return result, slope
