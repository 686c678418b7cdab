"""Gradients of what is on a grid, and of what a deformation makes of it (Eq. 29)."""

from __future__ import annotations

import numpy as np


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


def turned(vectors, transposed_jacobian, normalise):
    """J_G^T times each of `vectors` (..., 3); of length 1 (or 0) if `normalise`."""
    vectors = np.einsum("...ij,...j->...i", transposed_jacobian, vectors)
    if normalise:
        length = np.linalg.norm(vectors, axis=-1, keepdims=True)
        vectors = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return vectors.astype(np.float32)


def pushed(vectors, jacobian):
    """J_G^-1 times each of `vectors` (..., 3): tangents move so with the material.

    0 where `jacobian` (..., 3, 3) is singular.
    """
    a, b, c = np.moveaxis(jacobian, -2, 0)
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)
    volume = np.sum(a * rows[..., 0, :], axis=-1)[..., None]
    moved = np.einsum("...ij,...i->...j", rows, vectors)
    return np.divide(moved, volume, out=np.zeros_like(moved), where=volume != 0)


def faced(gradients, opening, values, background, grid):
    """`gradients`, with those on the face of an opening taken across it; 0 in the void.

    A voxel of material next to the void sees the border between both, as the paper has it: the
    direction is that of the gradient of the opening, the size that of the step from `background`
    to its value in one voxel.
    """
    void = opening < 0
    face = ~void & _touching(void)
    across = gradient(opening, grid)[face]
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    step = np.abs(values[face] - background)[:, None] / np.abs(grid.spacing).mean()
    sign = np.where(values[face] < background, -1, 1)[:, None]
    gradients[face] = np.divide(
        sign * step * across, length, out=np.zeros_like(across, dtype=np.float64), where=length > 0
    )
    gradients[void] = 0
    return gradients


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


def _touching(void):
    """Voxels with a void neighbour along an axis."""
    found = np.zeros_like(void)
    for axis in range(3):
        ahead, behind = [slice(None)] * 3, [slice(None)] * 3
        ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
        found[tuple(ahead)] |= void[tuple(behind)]
        found[tuple(behind)] |= void[tuple(ahead)]
    return found
