"""Parts of a resampled image, each from the part of the source that it needs."""

from dataclasses import replace

import numpy as np

from vtk_mls.base import interpolation, validation
from vtk_mls.engine.dispatch import engine_for

MAX_SOURCE_BYTES = 1 << 28  # read at once; a part that needs more is resampled in halves
_MIN_SIDE = 8  # points along an axis that is not halved
_ROWS = 1 << 20  # of indices at a time, which fit caches


def resampled_part(read, dtypes, transform, sampling):
    """Arrays on a part of the target, equal to the bit to that part of the whole.

    The map is evaluated once: its origins say what to read, and are sampled then. Threads that read
    do not keep others from the device. `read` gives the list of arrays (nz, ny, nx[, components])
    on a part of the source, a Grid, and `dtypes` are theirs, with the shape of the components.
    `sampling` goes from the whole source to a part of the target, with numbers as backgrounds.
    """
    target = sampling.target
    index = transform._engine.source_index(transform, sampling)
    methods, backgrounds = sampling.methods(len(dtypes)), sampling.backgrounds(len(dtypes))
    bounds, whole = interpolation.NO_BOUNDS, sampling.source.whole
    for start in range(0, len(index), _ROWS):
        bounds = interpolation.joined_bounds(bounds, index[start : start + _ROWS], whole)
    source = _needed_part(sampling, bounds, methods)
    if source is None:
        return [_filled(target.shape, *pair) for pair in zip(dtypes, backgrounds)]
    size = source.size * sum(dtype.itemsize for dtype in dtypes)
    if size > MAX_SOURCE_BYTES and max(target.dimensions) > _MIN_SIDE:
        del index
        axis = int(np.argmax(target.dimensions))
        halves = [
            resampled_part(read, dtypes, transform, replace(sampling, target=half))
            for half in _halves(target, axis)
        ]
        return [np.concatenate(pair, axis=2 - axis) for pair in zip(*halves)]
    sample = engine_for(transform.device).sample
    results = []
    for array, dtype, method, background in zip(read(source), dtypes, methods, backgrounds):
        values = validation.native_array(array)
        values = sample(values, index, method, background, source)
        results.append(values.reshape(target.shape + dtype.shape).astype(dtype.base, copy=False))
    return results


def slices_of(part):
    """Slices (z, y, x) of a part in an array of the whole."""
    return tuple(slice(a, a + n) for a, n in zip(part.first[::-1], part.shape))


def _needed_part(sampling, bounds, methods):
    """The part of the source that determines all values of the target; None if nothing does."""
    low, high = bounds
    if not np.isfinite(low).all():
        return None
    reach = max(interpolation.REACH[method] for method in methods)
    last = np.array(sampling.source.dimensions) - 1
    low = np.clip(np.floor(low) - reach, 0, last)
    high = np.clip(np.ceil(high) + reach, low, last)
    return sampling.source.part(low, high - low + 1)


def _filled(shape, dtype, background):
    return np.full(shape + dtype.shape, interpolation.cast(background, dtype.base), dtype.base)


def _halves(grid, axis):
    size = np.array(grid.dimensions)
    middle = np.where(np.arange(3) == axis, size // 2, 0)
    yield grid.part((0, 0, 0), np.where(middle, middle, size))
    yield grid.part(middle, size - middle)
