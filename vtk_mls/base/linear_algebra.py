"""Vectors and matrices in float64.

Products with many vectors avoid BLAS: its threads busy-wait for tens of milliseconds after each
product, and take processor time from the kernels.
"""

import numpy as np

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]  # cyclic indices of coordinates


def dots(vectors, vector):
    """Dot products of `vectors` (..., n) with `vector` (n,): (...)."""
    return np.einsum("...i,i->...", vectors, vector)


def transformed(matrix, vectors):
    """Products of `matrix` (m, n) with `vectors` (..., n): (..., m)."""
    return np.einsum("ij,...j->...i", matrix, vectors)


def distances(a, b):
    """The distances (m, n) of points `a` (m, 3) from points `b` (n, 3)."""
    return np.sqrt(sum((x[:, None] - y) ** 2 for x, y in zip(a.T, b.T)))


def unit(vectors):
    """Unit vectors along `vectors` (..., 3); 0 for 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def cross(a, b):
    """a x b (..., 3), faster than numpy's for few vectors."""
    return a[..., _NEXT] * b[..., _LAST] - a[..., _LAST] * b[..., _NEXT]


def finite(matrices):
    """`matrices` with 0 for numbers that are not finite: numpy's decompositions would raise."""
    return np.where(np.isfinite(matrices), matrices, 0)


def fitted_affine(before, after):
    """The least-squares affine map x -> A x + b between points (n, 3); A (3, 3), b (3,).

    If the points do not determine it, it is the one nearest to the identity.
    """
    center, change = before.mean(axis=0), after - before
    mean = change.mean(axis=0)
    tilt = np.linalg.lstsq(before - center, change - mean, rcond=1e-6)[0].T
    return np.eye(3) + tilt, mean - tilt @ center
