"""Interpolation of an array between its points: the float64 specification of the kernels."""

import itertools

import numpy as np

# By method: how many points beyond those next to an index determine the value there.
REACH = {"nearest": 0, "linear": 0, "cubic": 1}
INTERPOLATIONS = tuple(REACH)
NO_BOUNDS = np.array([[np.inf] * 3, [-np.inf] * 3])  # without points


def sample(array, index, method, background, source):
    """Values (m,) or (m, components) of `array` at continuous indices (i, j, k) of the whole grid.

    `array` (nz, ny, nx) or (nz, ny, nx, components), of any real dtype, is on the Grid `source`. At
    `index` (m, 3) the border's value continues up to half a spacing outside; beyond that it is the
    `background`, a number or one for each component. For a part of a grid, values outside are taken
    from its own border. "cubic" is Catmull-Rom (Keys, a = -1/2).

    Integers are rounded to the nearest and limited to their range. At a point of the grid it is
    exactly the value of that point; between equal values it is that value.
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
        total, offset = np.zeros(raw.shape), np.zeros(raw.shape)  # offset: relative to `raw`
        taps = [_taps(method, fraction[:, axis]) for axis in range(3)]
        for (dz, wz), (dy, wy), (dx, wx) in itertools.product(*taps[::-1]):
            at = np.clip(base + (dx, dy, dz), first, last) - first
            tap = values[tuple(at.T[::-1])]
            weight = (wx * wy * wz)[:, None]
            # NaN and infinity of a tap with weight 0 are ignored
            has_weight = np.broadcast_to(weight != 0, raw.shape)
            np.add(total, weight * tap.astype(np.float64), out=total, where=has_weight)
            np.add(offset, weight * _difference(tap, raw), out=offset, where=has_weight)
        at_point = (fraction == 0).all(axis=1)
        result = np.where(at_point[:, None], raw, _rounded_sum(raw, offset))
        if array.dtype.kind == "f":  # an infinite value or difference
            result = np.where(np.isfinite(result), result, cast(total, array.dtype))
    result[~inside] = cast(background, array.dtype)
    return result.reshape(len(index), *array.shape[3:])


def linear_with_slopes(values, index, with_slopes=True):
    """Linear values (m, ...) at indices (m, 3) = (i, j, k) of an array (nz, ny, nx, ...).

    Indices are limited to the array. The slopes (m, ..., 3) are per index, or None.
    """
    size = np.array(values.shape[2::-1])
    index = np.clip(index, 0, size - 1)
    cell = np.minimum(np.floor(index).astype(np.int64), np.maximum(size - 2, 0))
    shares = [(1 - t, t) for t in np.ascontiguousarray((index - cell).T)]
    strides = np.array([1, size[0], size[0] * size[1]])
    first, to_next = cell @ strides, np.minimum(size - 1, 1) * strides
    flat = values.reshape(-1, *values.shape[3:])
    rows = (slice(None), *[None] * (values.ndim - 3))
    result = np.zeros((len(index), *values.shape[3:]))
    slopes = np.zeros((*result.shape, 3)) if with_slopes else None
    for corner in np.ndindex(2, 2, 2):
        tap = flat[first + np.dot(corner, to_next)].astype(np.float64)
        x, y, z = weights = [share[side] for share, side in zip(shares, corner)]
        result += (x * y * z)[rows] * tap
        for axis in range(3) if with_slopes else ():
            others = weights[axis - 1] * weights[axis - 2]
            slopes[..., axis] += (2 * corner[axis] - 1) * others[rows] * tap
    return result, slopes


def joined_bounds(bounds, index, grid):
    """`bounds` (2, 3), extended by the indices (m, 3) inside `grid`."""
    if len(index) == 0:
        return bounds
    (low, high), ends = bounds, np.array([index.min(axis=0), index.max(axis=0)])
    if not grid.covers(ends).all():
        inside = grid.covers(index)
        if not inside.any():
            return bounds
        # columns are contiguous, as a rule
        ends = np.array([(column.min(), column.max()) for column in (a[inside] for a in index.T)]).T
    return np.array([np.minimum(low, ends[0]), np.maximum(high, ends[1])])


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


def _difference(a, b):
    """a - b in float64, rounded once."""
    if a.dtype.kind not in "iu" or a.itemsize < 8:
        return a.astype(np.float64) - b
    # up to 65 bits: the upper and lower halves have 33 each
    upper = (a >> 32).astype(np.int64) - (b >> 32).astype(np.int64)
    lower = (a & 0xFFFFFFFF).astype(np.int64) - (b & 0xFFFFFFFF).astype(np.int64)
    return upper * 2.0**32 + lower


def _rounded_sum(pivot, offset):
    """`pivot` plus a float64 `offset`, in the type of `pivot`, as `cast` rounds."""
    dtype = pivot.dtype
    if dtype.kind not in "iu" or dtype.itemsize < 8:
        return cast(pivot + offset, dtype)
    # with its sign bit flipped a signed integer is ordered as an unsigned one, whose range includes
    # every difference; the lowest bit is cleared so that ties round to even
    sign = np.uint64(1 << 63 if dtype.kind == "i" else 0)
    bits = pivot.view(np.uint64) ^ sign
    odd = bits & np.uint64(1)
    offset, bits = offset + odd, bits - odd
    up, down = (cast(np.maximum(part, 0), bits.dtype) for part in (offset, -offset))
    bits = np.where(bits + up < bits, np.uint64(2**64 - 1), bits + up)
    bits = np.where(down > bits, np.uint64(0), bits - down)
    return (bits ^ sign).view(dtype)


def is_in_range(number, dtype):
    """Whether `dtype` can hold a background, to its rounding."""
    if isinstance(number, (str, tuple)):  # automatic, or a number for each component
        return all(is_in_range(item, dtype) for item in number if isinstance(number, tuple))
    if dtype.kind in "iu":
        limits = np.iinfo(dtype)
        return bool(np.isfinite(number)) and limits.min <= round(number) <= limits.max
    return not np.isfinite(number) or bool(np.isfinite(cast(number, dtype)))


def cast(values, dtype):
    """`values` as `dtype`: integers are rounded to the nearest and limited to their range."""
    if isinstance(values, tuple):
        return np.array([cast(value, dtype) for value in values], dtype)
    if isinstance(values, int) and dtype.kind in "iu":  # beyond the precision of float64
        limits = np.iinfo(dtype)
        return dtype.type(min(max(values, int(limits.min)), int(limits.max)))
    values = np.asarray(values, np.float64)
    if dtype.kind not in "iu":
        return values.astype(dtype)
    limits = np.iinfo(dtype)
    rounded = np.rint(np.nan_to_num(values))
    # the float64 next to the largest 64-bit integer is one too many
    high = np.nextafter(float(limits.max), 0) if limits.max > 2**53 else limits.max
    inner = np.clip(rounded, limits.min, high).astype(dtype)
    return np.where(rounded > high, limits.max, inner).astype(dtype)
