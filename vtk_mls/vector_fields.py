"""Gradients of what is on a grid, and of what a deformation makes of it (Eq. 29)."""

from __future__ import annotations

import numpy as np

from vtk_mls.sampling import sample

# How far into the material the face of an opening shows in the gradient, in voxels of the source.
REACH = 1.5


def gradient(array, grid):
    """Gradient of `array` on `grid`, by differences.

    Parameters
    ----------
    array : (nz, ny, nx) array
    grid : Grid

    Returns
    -------
    (nz, ny, nx, 3) float32, per world unit
        Of fourth order inside, of second order at the border, 0 across a single slice.
    """
    values = np.asarray(array, dtype=np.float64)
    slopes = np.stack([_slope(values, 2 - axis) for axis in range(3)], axis=-1)
    # d/dx = sum of d/di times di/dx
    return (slopes @ np.linalg.inv(grid.index_to_world)).astype(np.float32)


def covariant(vectors, transposed_jacobian, normalise):
    """J_G^T times each of `vectors` (..., 3); of length 1 (or 0) if `normalise`."""
    vectors = np.einsum("...ij,...j->...i", transposed_jacobian, vectors)
    if normalise:
        vectors = unit(vectors)
    return vectors.astype(np.float32)


def contravariant(vectors, jacobian):
    """J_G^-1 times each of `vectors` (..., 3): tangents move so with the material.

    0 where `jacobian` (..., 3, 3) is singular.
    """
    a, b, c = np.moveaxis(jacobian, -2, 0)
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)
    volume = np.sum(a * rows[..., 0, :], axis=-1)[..., None]
    moved = np.einsum("...ij,...i->...j", rows, vectors)
    return np.divide(moved, volume, out=np.zeros_like(moved), where=volume != 0)


def at_faces(deformation, v, values, slopes, source, interpolation, background):
    """Gradient of a deformed array near the faces of an opening.

    Where the material ends there is a step from its value to `background`. In the undeformed
    material it lies one voxel wide along the cut, and turns with J_G^T like every gradient
    (Eq. 29): on the face it is all, and over the next voxel it gives way to the gradient of the
    values. A cut that is closed has no step: half a voxel behind the face there must be a void.

    Parameters
    ----------
    deformation : Deformation
        With cuts.
    v : (m, 3) array, world coordinates
        Places, not in the void.
    values, slopes : (nz, ny, nx) and (nz, ny, nx, 3) arrays of floats
        The undeformed array, and its `gradient`.
    source : Grid
        Where these are.
    interpolation, background
        As of `Deformation.resample`.

    Returns
    -------
    (m, 3) float64, per world unit
    """
    voxel = np.abs(source.spacing).mean()
    origin = deformation.backward(v)
    turn = deformation.jacobian(v).swapaxes(1, 2)
    void_distances = [cut.void_distance(v, origin) for cut in deformation.cuts]
    void_distance, nearest = np.min(void_distances, axis=0), np.argmin(void_distances, axis=0)
    away = np.zeros_like(v)
    for number, cut in enumerate(deformation.cuts):
        here = nearest == number
        away[here] = cut.away(v[here], origin[here])
    across = np.einsum("mij,mj->mi", turn, away)
    squared = np.maximum(np.sum(across**2, axis=1), np.finfo(float).tiny)
    behind = v - ((void_distance + voxel / 2) / squared)[:, None] * across
    depth = -deformation.void_distance(behind)
    share = np.clip(REACH - void_distance / voxel, 0, 1) * np.clip(4 * depth / voxel, 0, 1)

    index = source.whole.index_of(origin)
    step = (sample(values, index, interpolation, background, source) - background) / voxel
    inner = sample(slopes, index, interpolation, 0, source)
    return np.einsum("mij,mj->mi", turn, inner + share[:, None] * (step[:, None] * away - inner))


def unit(vectors):
    """`vectors` (..., 3) with length 1, or 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def _slope(values, axis):
    """Derivative along an axis, per index."""
    n = values.shape[axis]
    if n == 1:
        return np.zeros_like(values)
    slope = np.gradient(values, axis=axis, edge_order=2 if n > 2 else 1)
    if n > 4:
        inner = [slice(None)] * 3
        inner[axis] = slice(2, -2)
        near, far = np.roll(values, -1, axis), np.roll(values, -2, axis)
        near -= np.roll(values, 1, axis)
        far -= np.roll(values, 2, axis)
        slope[tuple(inner)] = ((8 * near - far) / 12)[tuple(inner)]
    return slope
