"""The grid that holds a deformed volume."""

import numpy as np

from vtk_mls.base.grid import Grid

SAMPLES = 48  # per axis of the box
MAX_GROWTHS = 8  # of the box, by half of its size on a side
SHRINKINGS = 2  # of the box to the samples inside the volume
_OTHER_AXES = ((1, 2), (0, 2), (0, 1))


def fitted_grid(deformation, source, progress):
    """The smallest `Grid` found that is aligned with `source` and holds the deformed volume.

    The backward map is sampled over a box. The box grows on each side that the volume reaches,
    then shrinks to the samples inside the volume, plus one sample step. Polynomials can bring
    copies of the volume from far away, so the number of growth steps is limited.
    """
    size = np.array(source.dimensions, dtype=np.float64)
    low, high = np.full(3, -0.5), size - 0.5
    # far moves are found by control points
    rest, deformed = deformation._material_samples(source)
    material = source.index_of(deformed[_is_inside(source, rest)])
    low, high = _enclosed(low, high, material)
    margin = 0.25 * (high - low) + 1
    low, high = low - margin, high + margin
    growing, shrinking = progress.divided(MAX_GROWTHS, SHRINKINGS)
    for part in growing.divided(*[1] * MAX_GROWTHS):
        inside, axes = _sampled(deformation, source, (low, high), part)
        step = 0.5 * (high - low)
        faces_low, faces_high = (
            np.array([inside.take(end, axis).any() for axis in range(3)]) for end in (0, -1)
        )
        if not (faces_low.any() or faces_high.any()):
            break
        low, high = low - step * faces_low, high + step * faces_high
    for part in shrinking.divided(*[1] * SHRINKINGS):
        inside, axes = _sampled(deformation, source, (low, high), part)
        if not inside.any():
            break
        step = (high - low) / (SAMPLES - 1)
        found = [axis[np.any(inside, axis=others)] for axis, others in zip(axes, _OTHER_AXES)]
        low = np.array([axis[0] for axis in found]) - step
        high = np.array([axis[-1] for axis in found]) + step
    low, high = _enclosed(low, high, material)
    first, last = np.floor(low), np.ceil(high)
    flat = size == 1  # a slice stays a slice
    first, last = np.where(flat, 0, first), np.where(flat, 0, last)
    return Grid(
        (last - first + 1).astype(int), source.at(first[None])[0], source.spacing, source.direction
    )


def _sampled(deformation, source, box, progress):
    """Whether G maps each sample of an index box into `source`, (n, n, n) bool; and the axes."""
    axes = [np.linspace(low, high, SAMPLES) for low, high in zip(*box)]
    index = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = _is_inside(source, deformation.backward(source.at(index), progress))
    return inside.reshape((SAMPLES,) * 3), axes


def _is_inside(source, points):
    return source.covers(source.index_of(points))


def _enclosed(low, high, index):
    if len(index) == 0:
        return low, high
    return np.minimum(low, index.min(axis=0)), np.maximum(high, index.max(axis=0))
