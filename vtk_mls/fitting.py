"""The grid that a deformed volume needs."""

from __future__ import annotations

import numpy as np

from vtk_mls.grid import Grid

_SAMPLES = 48  # per axis
_GROWTH = 8  # times that a side may move out by half of the size


def fitted_grid(deformation, source: Grid) -> Grid:
    """Smallest grid on the lattice of `source` found to hold the deformed volume.

    The backward map is sampled all over a box, inside and on its faces. The box grows on each
    side where the volume reaches it, then shrinks to the samples with one sample step to spare.
    Polynomials can bring copies of the volume from far away: growth stops after a few sizes.
    """
    size = np.array(source.dimensions, dtype=np.float64)
    low, high = np.full(3, -0.5), size - 0.5
    # control points say where the volume goes even if that is far
    control_points = source.index_of(deformation.deformed[_is_inside(source, deformation.rest)])
    low, high = _enclosed(low, high, control_points)
    margin = 0.25 * (high - low) + 1
    low, high = low - margin, high + margin
    for _ in range(_GROWTH):
        inside, axes = _sampled(deformation, source, low, high)
        step = 0.5 * (high - low)
        faces_low, faces_high = _touched(inside)
        if not (faces_low.any() or faces_high.any()):
            break
        low, high = low - step * faces_low, high + step * faces_high
    for _ in range(2):
        inside, axes = _sampled(deformation, source, low, high)
        if not inside.any():
            break
        step = (high - low) / (_SAMPLES - 1)
        found = [axis[np.any(inside, axis=others)] for axis, others in zip(axes, _OTHERS)]
        low = np.array([axis[0] for axis in found]) - step
        high = np.array([axis[-1] for axis in found]) + step
    low, high = _enclosed(low, high, control_points)
    first, last = np.floor(low), np.ceil(high)
    flat = size == 1  # a slice stays a slice
    first, last = np.where(flat, 0, first), np.where(flat, 0, last)
    return Grid(
        (last - first + 1).astype(int), source.at(first[None])[0], source.spacing, source.direction
    )


_OTHERS = ((1, 2), (0, 2), (0, 1))


def _sampled(deformation, source, low, high):
    """Whether G maps each sample of the index box into `source`; the samples' axes."""
    axes = [np.linspace(a, b, _SAMPLES) for a, b in zip(low, high)]
    index = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = _is_inside(source, deformation.backward(source.at(index)))
    return inside.reshape((_SAMPLES,) * 3), axes


def _is_inside(source, points):
    index = source.index_of(points)
    return ((index >= -0.5) & (index <= np.array(source.dimensions) - 0.5)).all(axis=1)


def _touched(inside):
    faces = [
        (np.take(inside, 0, axis=a).any(), np.take(inside, -1, axis=a).any()) for a in range(3)
    ]
    return np.array(faces).T


def _enclosed(low, high, index):
    if len(index) == 0:
        return low, high
    return np.minimum(low, index.min(axis=0)), np.maximum(high, index.max(axis=0))
