"""Values of an array between its points: the float64 specification of what the kernels sample."""

from __future__ import annotations

import numpy as np

INTERPOLATIONS = ("nearest", "linear", "cubic")
NO_BOUNDS = np.array([[np.inf] * 3, [-np.inf] * 3])  # of no point


def sample(array, index, method, background, source):
    """Values of `array` at continuous indices.

    Parameters
    ----------
    array : (nz, ny, nx) or (nz, ny, nx, components) array of any real dtype
    index : (m, 3) float64
        Continuous indices (i, j, k) of the whole grid. Up to half a spacing beyond its border the
        border's value continues; beyond that is `background`.
    method : {"nearest", "linear", "cubic"}
        "cubic" is Catmull-Rom (Keys, a = -1/2).
    background : float
        Value outside, cast like every other.
    source : Grid
        Where the values are. If it is a part, what it lacks is taken from its own border.

    Returns
    -------
    (m,) or (m, components) array of the same dtype
        Integers are rounded to the nearest and kept in their range. At a point of the grid it is
        exactly that point's value.
    """
    size = np.array(source.whole.dimensions)
    first = np.array(source.first)
    last = first + source.dimensions - 1
    values = array.reshape(*array.shape[:3], -1)
    inside = source.whole.covers(index)
    index = np.clip(np.where(inside[:, None], index, 0), 0, size - 1)
    nearest = np.clip(np.floor(index + 0.5).astype(np.int64), first, last) - first
    raw = values[tuple(nearest.T[::-1])]
    if method == "nearest":
        result = raw.copy()
    else:
        base = np.floor(index).astype(np.int64)
        fraction = index - base
        total = np.zeros(raw.shape)
        taps = [_taps(method, fraction[:, axis]) for axis in range(3)]
        for dz, wz in taps[2]:
            for dy, wy in taps[1]:
                for dx, wx in taps[0]:
                    at = np.clip(base + (dx, dy, dz), first, last) - first
                    tap = values[tuple(at.T[::-1])].astype(np.float64)
                    weight = (wx * wy * wz)[:, None]
                    # a tap without weight must not bring in its NaN or infinity
                    total += np.where(weight == 0, 0, weight * np.where(weight == 0, 0, tap))
        at_point = (fraction == 0).all(axis=1)
        result = np.where(at_point[:, None], raw, cast(total, array.dtype))
    result[~inside] = cast(np.float64(background), array.dtype)
    return result.reshape(len(index), *array.shape[3:])


def joined_bounds(bounds, index, grid):
    """`bounds`, widened to hold those of the indices (m, 3) that are inside of `grid`."""
    inside = grid.covers(index)
    if not inside.any():
        return bounds
    index = index if inside.all() else index[inside]
    low, high = bounds
    return np.array([np.minimum(low, index.min(axis=0)), np.maximum(high, index.max(axis=0))])


def _taps(method, t):
    """Offsets along one axis with their weights (m,)."""
    if method == "linear":
        return [(0, 1 - t), (1, t)]
    return [
        (-1, ((2 - t) * t - 1) * t / 2),
        (0, ((3 * t - 5) * t * t + 2) / 2),
        (1, ((4 - 3 * t) * t + 1) * t / 2),
        (2, (t - 1) * t * t / 2),
    ]


def cast(values, dtype):
    """`values` as `dtype`: integers rounded to the nearest and kept in their range."""
    if dtype.kind not in "iu":
        return values.astype(dtype)
    limits = np.iinfo(dtype)
    rounded = np.rint(np.nan_to_num(values))
    # the float64 next to the largest 64-bit integer is one too many
    high = np.nextafter(float(limits.max), 0) if limits.max > 2**53 else limits.max
    inner = np.clip(rounded, limits.min, high).astype(dtype)
    return np.where(rounded > high, limits.max, inner).astype(dtype)
