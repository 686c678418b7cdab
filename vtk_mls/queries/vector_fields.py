"""Gradients of arrays on a grid, and vectors moved by a deformation (Eq. 29)."""

import numpy as np

from vtk_mls.base.linear_algebra import transformed, unit
from vtk_mls.base.progress import SILENT


def gradient(array, grid, progress=SILENT):
    """Gradient (nz, ny, nx, 3) float32, per world unit, of an array (nz, ny, nx) on a grid.

    By finite differences of fourth order inside, of second order at the border, 0 across a single
    slice.
    """
    values = np.asarray(array, dtype=np.float64)
    slopes = np.stack([_slope(values, axis) for axis in progress.over((2, 1, 0))], axis=-1)
    # d/dx = sum of d/di times di/dx
    return transformed(grid.world_to_index.T, slopes).astype(np.float32)


def covariant(vectors, transposed_jacobian, normalise):
    """J_G^T times `vectors` (..., 3); as unit vectors (or 0) if `normalise`."""
    vectors = np.einsum("...ij,...j->...i", transposed_jacobian, vectors)
    if normalise:
        vectors = unit(vectors)
    return vectors.astype(np.float32)


def contravariant(vectors, jacobian):
    """J_G^-1 times `vectors` (..., 3), which move as tangents of the material.

    0 where `jacobian` (..., 3, 3) is singular.
    """
    a, b, c = np.moveaxis(jacobian, -2, 0)
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)
    volume = np.sum(a * rows[..., 0, :], axis=-1)[..., None]
    moved = np.einsum("...ij,...i->...j", rows, vectors)
    return np.divide(moved, volume, out=np.zeros_like(moved), where=volume != 0)


def sampled_parts(arrays, versions, sampling, parts, sample, void_distance, normalise):
    """`arrays` at all points of the target of a `Sampling`, part by part: `Engine.resample`.

    `parts` are slices of the target, indices (m, 3) of the source, void distances (m,) or None, and
    Jacobians (m, 3, 3) or None. `sample` is `Engine.sample`. `void_distance` (target.size,) is
    filled. `normalise` says whether vectors become unit vectors, by the index of each array of
    covariant vectors.
    """
    normalise = normalise or {}
    results = [np.empty(sampling.target.shape + a.shape[3:], a.dtype) for a in arrays]
    rules = list(zip(sampling.methods(len(arrays)), sampling.backgrounds(len(arrays))))
    for part, index, distance, jacobian in parts:
        if void_distance is not None and distance is not None:
            void_distance[part] = distance
        for i, (array, (method, background), result) in enumerate(zip(arrays, rules, results)):
            background = 0.0 if i in normalise else background
            values = sample(array, index, method, background, sampling.source, versions[i])
            if i in normalise:
                values = covariant(values, jacobian.swapaxes(1, 2), normalise[i])
            result.reshape(-1, *array.shape[3:])[part] = values
    return results


def _slope(values, axis):
    """Derivative along an axis, per index."""
    values = np.moveaxis(values, axis, 0)
    n = len(values)
    if n == 1:
        slope = np.zeros_like(values)
    elif n <= 4:
        slope = np.gradient(values, axis=0, edge_order=2 if n > 2 else 1)
    else:
        slope = np.empty_like(values)
        slope[:2] = np.gradient(values[:4], axis=0, edge_order=2)[:2]
        slope[-2:] = np.gradient(values[-4:], axis=0, edge_order=2)[-2:]
        inner = np.subtract(values[3:-1], values[1:-3], out=slope[2:-2])
        inner *= 8
        inner -= values[4:] - values[:-4]
        inner /= 12
    return np.moveaxis(slope, 0, axis)
