"""Gradients of what is on a grid, and of what a deformation makes of it (Eq. 29)."""

from __future__ import annotations

import numpy as np

from vtk_mls.base.linear_algebra import transformed, unit
from vtk_mls.base.progress import SILENT

# How far into the material the face of a void shows in the gradient, in voxels of the source.
REACH = 1.5
_ON_FACE = 1e-3  # what is nearer to a cut counts as on it, in voxels


def gradient(array, grid, progress=SILENT):
    """Gradient of `array` on `grid`, by differences.

    Parameters
    ----------
    array : (nz, ny, nx) array
    grid : Grid
    progress : Progress, optional

    Returns
    -------
    (nz, ny, nx, 3) float32, per world unit
        Of fourth order inside, of second order at the border, 0 across a single slice.
    """
    values = np.asarray(array, dtype=np.float64)
    slopes = np.stack([_slope(values, axis) for axis in progress.over((2, 1, 0))], axis=-1)
    # d/dx = sum of d/di times di/dx
    return transformed(grid.world_to_index.T, slopes).astype(np.float32)


def covariant(vectors, transposed_jacobian, normalise):
    """J_G^T times each of `vectors` (..., 3); of length 1 (or 0) if `normalise`."""
    vectors = np.einsum("...ij,...j->...i", transposed_jacobian, vectors)
    if normalise:
        vectors = unit(vectors)
    return vectors.astype(np.float32)


def contravariant(vectors, jacobian):
    """J_G^-1 times each of `vectors` (..., 3), as tangents move with the material.

    0 where `jacobian` (..., 3, 3) is singular.
    """
    a, b, c = np.moveaxis(jacobian, -2, 0)
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)
    volume = np.sum(a * rows[..., 0, :], axis=-1)[..., None]
    moved = np.einsum("...ij,...i->...j", rows, vectors)
    return np.divide(moved, volume, out=np.zeros_like(moved), where=volume != 0)


def near_faces(engine, deformation, void_distance, fields, sampling, progress):
    """Gradient of a deformed array where it is taken across the face of a void.

    Parameters
    ----------
    engine, deformation, fields, sampling, progress
        As for `at_faces`.
    void_distance : (sampling.target.size,) array, world units

    Returns
    -------
    near : (m,) int64
        Numbers of the points, x fastest.
    values : (m, 3) float64, per world unit
    """
    reach = REACH * _voxel(sampling.source)
    near = np.flatnonzero((void_distance >= 0) & (void_distance < reach))
    v = sampling.target.numbered(near)
    return near, at_faces(engine, deformation, v, fields, sampling, progress)


def at_faces(engine, deformation, v, fields, sampling, progress):
    """Gradient of a deformed array near the faces of a void.

    Where the material ends, the array has a step from its value to the background. In the
    undeformed material this step is one voxel wide along the cut; its gradient is covariant like
    every other (Eq. 29). Up to half a voxel from the face it replaces the gradient of the values,
    into which it is blended linearly over the next voxel. A cut that is closed has no step: half a
    voxel behind the face there must be a void.

    Parameters
    ----------
    engine : engine.protocol.Engine
    deformation : Deformation
        With cuts.
    v : (m, 3) array, world coordinates
        Points that are not in the void.
    fields : (nz, ny, nx) and (nz, ny, nx, 3) arrays of floats
        The undeformed array, and its `gradient`.
    sampling : Sampling
        Of the array.
    progress : Progress

    Returns
    -------
    (m, 3) float64, per world unit
    """
    values, slopes = fields
    source, voxel = sampling.source, _voxel(sampling.source)
    (method,) = sampling.methods(1)
    mapping, sloping, closing, sampled = progress.divided(1, 3, 1, 1)
    origin = deformation.backward(v, mapping)
    covariant_jacobian = deformation.jacobian(v, sloping).swapaxes(1, 2)
    seen = origin if deformation.in_rest_frame else v  # from where cuts are seen
    void_distances = [cut.void_distance(seen, origin) for cut in deformation.cuts]
    void_distance, nearest = np.min(void_distances, axis=0), np.argmin(void_distances, axis=0)
    away = np.zeros_like(v)
    for number, cut in enumerate(deformation.cuts):
        here = nearest == number
        away[here] = cut.away(seen[here], origin[here])
    across = np.einsum("mij,mj->mi", covariant_jacobian, away)
    squared = np.maximum(np.sum(across**2, axis=1), np.finfo(float).tiny)
    behind = v - ((void_distance + voxel / 2) / squared)[:, None] * across
    depth = -deformation.void_distance(behind, closing)
    # right on a cut in the rest frame the origin does not tell on which side the material is
    unsure = np.flatnonzero((void_distance < _ON_FACE * voxel) & (depth <= 0))
    if deformation.in_rest_frame and len(unsure) > 0:
        mirrored = -deformation.void_distance(2 * v[unsure] - behind[unsure])
        others = unsure[mirrored > 0]
        away[others], depth[others] = -away[others], mirrored[mirrored > 0]
    share = np.clip(REACH - void_distance / voxel, 0, 1) * np.clip(4 * depth / voxel, 0, 1)

    sampled.report(0)
    index, background = source.whole.index_of(origin), sampling.background
    step = (engine.sample(values, index, method, background, source) - background) / voxel
    inner = engine.sample(slopes, index, method, 0, source)
    blended = inner + share[:, None] * (step[:, None] * away - inner)
    return np.einsum("mij,mj->mi", covariant_jacobian, blended)


def _voxel(grid):
    """Mean distance of neighbours, world units."""
    return np.abs(grid.spacing).mean()


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
